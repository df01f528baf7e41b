"""The cycle: what is rejected leaves no trace, what is told by facet follows the mesh, what cannot be is refused."""

from dataclasses import replace

import numpy as np
import pytest

from wearfem.case import LifeCase, Stop, Window
from wearfem.cycle import (
    Particles,
    Worn,
    _meshed_again,
    bounds_of,
    cycle,
    first_state,
    move,
    sample_rate,
    worn_to,
)
from wearfem.errors import UserError
from wearfem.formula import FormulaFlow, Sliding
from wearfem.history import history_of
from wearfem.liner.block import Hexahedra, Tetrahedra, block, mapped, sheet
from wearfem.liner.curvature import largest_curvature
from wearfem.liner.liner import Liner, wear_surface
from wearfem.liner.solve import Structure
from wearfem.liner.support import Fixed
from wearfem.loads import in_one_block, in_sequence, on_facets, without_classes
from wearfem.material import Material
from wearfem.proofs.cycle import differences, untold, whole_life
from wearfem.proofs.cycle import plate as wearing_plate
from wearfem.surface import Surface
from wearfem.wear.effects import Overlay
from wearfem.wear.jump import Goal, Jump
from wearfem.wear.laws import Archard
from wearfem.wear.metal import Metal
from wearfem.wear.sampling import Sample

STEEL = Material("steel", 7850.0, 80e9, 0.3)
RATE = 1e-9  # [m/s] of the flow below


def plate(cells=(4, 2, 2), thickness=20e-3, kind=Hexahedra):
    return Liner(block((0, 0, 0), (0.2, 0.1, thickness), cells, kind, name="plate"), STEEL)


def life_case(liner=None, **changes):
    liner = plate() if liner is None else liner
    facets = len(liner.mesh.wear)
    kept = {
        "name": "plate",
        "flow": FormulaFlow(),
        "sampler": Sliding(1e4, 1.0),
        "liner": liner,
        "wear_law": Archard(1e-13),
        "goal": Goal(np.full(facets, 10e-3), tolerance=0.01),
        "window": Window(10.0, 20),
    }
    return LifeCase(**(kept | changes))


def test_a_cycle_changes_nothing_that_it_was_given():
    case = life_case()
    state = first_state(case)
    before = differences(state, first_state(case))
    new, report = cycle(case, state)
    again, twin = cycle(case, state)
    assert before == differences(state, first_state(case)) == 0
    assert differences(new, again) == differences(report, twin) == 0
    assert new.cycle == report.cycle == 1


def test_a_rejected_jump_leaves_no_trace():
    """Unforeseen, the flow wears three times as fast from 4.3 mm on: jumps across are taken back, and depths come out as by formula."""
    case = untold(life_case(effects=(Overlay(4.3e-3, 3.0),)))
    state, reports = first_state(case), []
    while not state.ended:
        before = state
        state, report = cycle(case, state)
        reports.append(report)
        if not report.kept:
            assert before.kept is not None
            assert differences(state.kept, before.kept) == 0
            assert state.now.liner.service_time < before.now.liner.service_time
    history = history_of(state, reports)
    assert history.rejected > 0
    assert (np.diff(history.service_time) > 0.0).all()
    life = (4.3e-3 + (10e-3 - 4.3e-3) / 3.0) / RATE
    assert history.life[-1].time == pytest.approx(
        life, rel=0.02
    )  # twice what is asked: the border lies within a jump
    assert history.simulated == pytest.approx(sum(r.window + r.warm_up for r in reports))


def test_the_stop_is_met_to_the_second():
    case = life_case(stop=Stop(service_time=3.0e6), throughput_rate=2.0)
    state, reports = whole_life(case)
    assert state.ended == "service time"
    assert reports[-1].service_time == pytest.approx(3.0e6, rel=1e-9)  # ROUNDING of the cycle
    assert reports[-1].throughput == pytest.approx(6.0e6, rel=1e-9)


def test_a_life_that_was_stopped_early_is_unsure_of_its_end():
    """What is foretold from a tenth of a life is as unsure as the rate that it is foretold with, wherever the run was stopped."""
    noisy = Sliding(1e4, 1.0, noise=0.3, memory=0.0, seed=5)
    wide = {"sampler": noisy, "goal": Goal(np.full(8, 10e-3), tolerance=0.05), "window": Window(10.0, 40)}
    _, reports = whole_life(life_case(stop=Stop(service_time=1.0e6), **wide))
    last = reports[-1]
    place = last.life.facet
    over = last.error[place] / last.rate[place] * (last.life.time - 1.0e6)
    assert last.service_time == pytest.approx(1.0e6, rel=1e-9)  # rounding
    assert (
        last.end_error(1.0) >= over > 3.0 * last.life.noise
    )  # of the tenth that has passed: by far not all of it
    _, reports = whole_life(life_case(**wide))
    assert reports[-1].end_error(2.0) == pytest.approx(
        reports[-1].life.error(2.0), rel=1e-6
    )  # nothing is left


def test_the_sample_is_as_long_as_planned_and_the_noisy_first_one_longer():
    case = life_case(sampler=Sliding(1e4, 1.0, noise=0.5, memory=0.5, delay=1.0, seed=3), warm_up=2.0)
    state, first = cycle(case, first_state(case))
    assert first.warm_up >= 2.0
    assert first.window > 10.0
    assert first.jump.limited_by != "noise"
    _, second = cycle(case, state)
    assert second.warm_up >= first.jump.warm_up > 0.0
    assert second.window >= first.jump.window - 0.5  # a block


def test_a_noise_that_no_window_tames_is_refused():
    case = life_case(sampler=Sliding(1e4, 1.0, noise=3.0), goal=Goal(np.full(8, 10e-3), tolerance=1e-3))
    with pytest.raises(
        UserError,
        match=r"would have to be .* s long, with a window of 10 s given: give the case a longer window",
    ):
        cycle(case, first_state(case))


def test_histograms_are_summed_and_blocks_kept():
    case = life_case(warm_up=3.0)
    state = first_state(case)
    surface = wear_surface(case.liner)
    goal, bounds = case.goal, bounds_of(case, case.liner, surface)
    _, measured = sample_rate(case, state, surface, goal, bounds)
    assert measured.loads.block_count == 1
    assert measured.by_block.block_count == 20
    assert measured.loads.duration.sum() == pytest.approx(10.0)  # the warm-up is not in it
    np.testing.assert_allclose(
        measured.loads.load_distance[0],
        measured.by_block.load_distance.sum(axis=0),
        rtol=1e-13,  # another order of the sum
    )


def test_loads_in_sequence_and_on_facets():
    surface = wear_surface(plate())
    _, loads = Sliding(1e4, 1.0, noise=0.1, facet_noise=0.1).sample(FormulaFlow(), surface, Window(4.0, 8))
    first, second = loads, without_classes(loads)
    joined = in_sequence([first, second])
    assert joined.block_count == 16 and joined.normal_impulse.shape == (16, 8)
    np.testing.assert_array_equal(joined.normal_impulse[8:], loads.normal_impulse)
    assert in_one_block(loads).duration.tolist() == [4.0]
    part = on_facets(loads, 2, 3)
    np.testing.assert_array_equal(part.tangential_impulse, loads.tangential_impulse[:, 2:5])
    assert part.facet_count == 3


def test_two_samples_are_one_long_one():
    """Blocks do not care how they are asked for: the flow is a value."""
    sliding, surface = (
        Sliding(1e4, 1.0, noise=0.1, facet_noise=0.2, memory=0.5, delay=1.0),
        wear_surface(plate()),
    )
    flow, whole = sliding.sample(FormulaFlow(), surface, Window(4.0, 8))
    half, first = sliding.sample(FormulaFlow(), surface, Window(2.0, 4))
    end, second = sliding.sample(half, surface, Window(2.0, 4))
    assert differences(flow, end) == 0
    np.testing.assert_array_equal(in_sequence([first, second]).load_distance, whole.load_distance)


def test_strength_is_told():
    structure = Structure((Fixed("bottom"),), yield_stress=400e6)
    _, report = cycle(life_case(structure=structure), first_state(life_case()))
    strain = report.strain
    assert strain is not None and strain.von_mises.shape == (8,)
    assert strain.least_reserve == pytest.approx(400e6 / strain.largest_von_mises)
    assert (
        5e3 < strain.largest_von_mises < 50e3
    )  # [Pa] of 10 kPa pressure and 5 kPa shear: sqrt(p^2 (1-2n)^2/(1-n)^2 + 3 t^2) = 10 kPa


def test_a_hole_ends_the_life_or_is_opened():
    liner = plate(cells=(12, 6, 2))
    x, y, _ = liner.mesh.node[liner.mesh.wear].mean(axis=1).T
    depth = 22e-3 * np.exp(-((x - 0.1) ** 2 + (y - 0.05) ** 2) / (2.0 * 0.03**2))
    worn = Worn(liner, np.zeros(72), np.full(72, np.inf), (Sample(0.0, np.full((4, 72), RATE), 1.0),))
    jump = Jump(1e7, "asked", 0.0, 0.0, 1.0, depth)
    case = life_case(liner, goal=Goal(np.full(72, 19e-3)), throughput_rate=100.0)
    moved, taken, event = move(case, worn, jump)
    assert event.startswith("worn through at") and not event.endswith("opened")
    spare = 20e-3 - 0.05 * np.sqrt(0.02 * 0.1 / 6)  # all but a twentieth of a facet's length
    assert taken == pytest.approx(
        spare / depth.max(), rel=0.1
    )  # in several rounds: the mesh spreads the deepest places
    assert moved.liner.service_time == pytest.approx(taken * 1e7, rel=1e-9)
    assert moved.liner.throughput == pytest.approx(100.0 * moved.liner.service_time, rel=1e-12)  # rounding
    assert moved.receded.max() == pytest.approx(
        taken * depth.max(), rel=1e-9
    )  # sums of parts, also on new elements
    on = replace(case, stop=Stop(breakthrough=False))
    for _ in range(20):
        moved, taken, event = move(on, worn, jump)
        if event.endswith("opened"):
            break
        worn = moved
    left = len(moved.liner.mesh.wear)
    whole = np.sum(wear_surface(worn.liner).facet_area)
    assert 0.0 < np.sum(wear_surface(moved.liner).facet_area) < whole
    assert moved.receded.shape == moved.allowed_depth.shape == moved.samples[0].mean.shape == (left,)


def test_what_is_told_by_facet_follows_a_new_mesh():
    pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    liner = plate(cells=(8, 4, 4), kind=Tetrahedra)
    facets = len(liner.mesh.wear)
    allowed = np.where(liner.mesh.node[liner.mesh.wear].mean(axis=1)[:, 0] < 0.1, 10e-3, np.inf)
    metal = Metal.known_by((Overlay(4.3e-3, 3.0),), np.full(facets, 1e-3), allowed)
    worn = Worn(liner, np.full(facets, 4e-3), allowed, (Sample(0.0, np.full((4, facets), RATE), 1.0),), metal)
    case = life_case(liner, goal=Goal(allowed), element_size=20e-3)
    moved, carried, event = _meshed_again(case, worn)
    assert event == f"meshed again, {len(moved.liner.mesh.element)} elements"
    np.testing.assert_allclose(carried(np.full(facets, 3.0)), 3.0, rtol=1e-12)  # constants stay
    new = len(moved.liner.mesh.wear)
    assert moved.samples[0].rate.shape == (4, new)
    np.testing.assert_allclose(moved.samples[0].mean, RATE, rtol=1e-12)  # constants stay
    np.testing.assert_allclose(moved.receded, 4e-3, rtol=1e-9)  # constants stay
    np.testing.assert_allclose(moved.metal.begun, 1e-3, rtol=1e-9)
    np.testing.assert_allclose(moved.metal.factor(moved.receded), 3.0, rtol=1e-9)  # 5 mm: through the layer
    x = moved.liner.mesh.node[moved.liner.mesh.wear].mean(axis=1)[:, 0]
    assert np.isinf(moved.allowed_depth[x > 0.13]).all()
    np.testing.assert_allclose(moved.allowed_depth[x < 0.07], 10e-3, rtol=1e-9)


def test_curvature_of_a_cylinder_and_of_a_plane():
    def bent(node):
        angle = (node[:, 0] - 0.1) / 0.5
        radius = 0.5 - node[:, 2]
        return np.column_stack([radius * np.sin(angle), node[:, 1], 0.5 - radius * np.cos(angle)])

    flat = sheet((0, 0), (0.2, 0.1), (20, 10), 10e-3)
    np.testing.assert_allclose(largest_curvature(wear_surface(Liner(flat, STEEL))), 0.0, atol=1e-9)
    curved = wear_surface(Liner(mapped(flat, bent), STEEL))
    # 1 / 0.495 m on the worn face, 5 mm inside the reference surface; 1 % is the square of the facet's share of the radius and more
    told = largest_curvature(curved)
    assert np.median(told[told > 0.0]) == pytest.approx(1.0 / 0.495, rel=0.01)


def test_curvature_of_a_sphere():
    from scipy.spatial import ConvexHull

    points = 0.3 * _even_directions(2000)
    hull = ConvexHull(points)
    corner = points[hull.simplices]
    inward = (
        np.einsum(
            "ti,ti->t", np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), corner[:, 0]
        )
        < 0
    )
    triangle = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    told = largest_curvature(Surface(points, triangle, STEEL))
    assert np.median(told) == pytest.approx(
        1.0 / 0.3, rel=0.2
    )  # H is right to 1 %; sqrt(H^2 - K) is rounding and scatter


def _even_directions(count):
    """(count, 3) unit vectors on a spiral of golden angle"""
    number = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * number / count, np.pi * (1.0 + np.sqrt(5.0)) * number
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def test_goals_by_thickness():
    goal = worn_to(plate(), 5e-3, tolerance=0.1)
    np.testing.assert_allclose(goal.allowed_depth, 15e-3, rtol=1e-12)  # rounding
    with pytest.raises(UserError, match=r"facet 0 is 20 mm thick, the limit is 25 mm; give a limit below"):
        worn_to(plate(), 25e-3)
    with pytest.raises(UserError, match=r"12 without a unit is metres: 12\*mm is meant\?"):
        worn_to(plate(), 12.0)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"goal": Goal(np.full(3, 1e-3))}, "but its liner wears on 8 facets"),
        ({"warm_up": -1.0}, "warm_up = -1.0 s: it must be 0 or more"),
        ({"particle_radius": 0.0}, "particle_radius = 0.0 m: it must be above 0"),
        ({"stop": Stop(service_time=0.0)}, "stops at 0 s of service"),
        ({"effects": (object(),)}, "the effect object, which does not say what it needs"),
    ],
)
def test_a_case_that_cannot_run_is_refused(changes, sentence):
    with pytest.raises(UserError, match=sentence):
        life_case(**changes)


def test_a_model_without_the_worn_face_is_refused():
    from wearfem.dem.flow import Domain, Flow, Model, Wall
    from wearfem.dem.particles import spheres

    other = wear_surface(plate(cells=(2, 2, 2)))

    def model(surface):
        return Model((STEEL,), 1e-6, Domain((-1, -1, -1), (1, 1, 1)), (Wall(other),))

    with pytest.raises(UserError, match="but not the worn face plate"):
        Particles(model).sample(
            Flow(spheres(np.zeros((0, 3)), 0.0, 1.0)), wear_surface(plate()), Window(1e-5)
        )


def test_a_stop_that_shortens_the_first_jump_does_not_end_the_life_for_noise():
    """The first sample is as long as the jump after it needs, and that jump ends at the stop; with this seed a life ended in cycle 1."""
    case, _ = wearing_plate(law="constant", seed=19, cells=1)
    state, report = cycle(replace(case, stop=Stop(3e6)), first_state(case))
    assert report.jump.limited_by != "noise" and report.jump.duration > 0.0 and not state.ended
