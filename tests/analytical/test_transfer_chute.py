"""The transfer chute beside the closed form of its stream."""

from itertools import pairwise

import numpy as np
import pytest

from wearfem.case import parts_of
from wearfem.liner.chute import angle_of, share_between
from wearfem.liner.liner import wear_surface
from wearfem.proofs import transfer_chute as proof
from wearfem.verification.chute_theory import speed, wear_rate


def test_the_closed_form_and_the_numbers_in_print():
    for claim in proof.closed_form():
        assert claim.holds, claim


def test_without_its_lost_term_the_closed_form_misses_the_printed_rate():
    """What the paper prints as eq. 9, with the printed K: 0.90e-10, and with the term 1.69e-10."""
    begin, end = np.radians((35.34, 64.15))
    angle = np.linspace(begin, end, 2001)

    def rate(lost):
        square = (
            2
            * 9.81
            * 2
            / (4 * 0.47**2 + 1)
            * ((1 - 2 * 0.47**2) * np.sin(angle) + lost * 3 * 0.47 * np.cos(angle))
        )
        square += -4.68 * np.exp(-2 * 0.47 * angle)
        return 3e-13 * 27.78 * np.trapezoid(square + 9.81 * 2 * np.sin(angle), angle)

    assert rate(1.0) == pytest.approx(1.68e-10, rel=0.01)  # printed; K is rounded
    assert rate(0.0) == pytest.approx(0.90e-10, rel=0.01)  # half of it
    given = {"friction": 0.47, "radius": 2.0, "start_angle": np.radians(28.36), "start_speed": 5.34}
    ours = wear_rate(begin, end, mass_rate=27.78, specific_wear_rate=3e-13, **given)
    assert ours == pytest.approx(rate(1.0), rel=2e-3)  # K printed -4.68, by their numbers -4.55


def test_without_friction_the_stream_keeps_its_energy():
    """v^2 / 2 grows by g times the drop."""
    drop = 2.0 * (np.sin(1.0) - np.sin(0.5))
    expected = np.sqrt(4.0**2 + 2 * 9.81 * drop)
    assert speed(1.0, 0.0, 2.0, 0.5, 4.0) == pytest.approx(expected, rel=1e-12)  # rounding


def test_a_stream_that_comes_to_rest_is_told():
    with pytest.raises(ValueError, match="comes to rest before 60 degrees"):
        speed(np.radians(60.0), 3.0, 2.0, np.radians(40.0), 1.0)


def test_one_ball_that_slides():
    for claim in proof.one_ball():
        assert claim.holds, claim


def test_zones_share_the_chute_out():
    """Each facet belongs to the zones in parts that sum to one; zone 2 is as large as its arc."""
    case, chute = proof.chute_case(), parts_of(proof.CASE)
    surface = wear_surface(case.liner)
    borders = pairwise((-np.inf, *chute.ZONE_2, np.inf))
    share = np.array([share_between(surface, low, high) for low, high in borders])
    np.testing.assert_allclose(share.sum(axis=0), 1.0, rtol=1e-12)  # rounding
    arc = chute.RADIUS * (chute.ZONE_2[1] - chute.ZONE_2[0]) * case.settings["slice_width"]
    assert share[1] @ surface.facet_area == pytest.approx(arc, rel=1e-5)  # chords over arcs: (h / R)^2 / 24


def test_the_whole_chute_can_be_built():
    """With sides: the bottom is as wide as printed, sides rise by 45 degrees, normals look into the flow."""
    from wearfem.liner.mesh_check import check_mesh

    case = proof.chute_case(slice_width=0.0, mesh_size=50e-3, coarsening=1.0)
    check_mesh(case.liner.mesh)
    surface = wear_surface(case.liner)
    begin = surface.point[np.isclose(surface.point[:, 0], surface.point[:, 0].min())]
    assert np.ptp(surface.point[:, 1]) == pytest.approx(0.2 + 2 * 0.2 * np.sqrt(0.5), rel=1e-12)  # rounding
    assert len(begin) > 0
    centre = surface.corner.mean(axis=1)
    inward = np.column_stack([-centre[:, 0], np.zeros(len(centre)), -centre[:, 2]])
    flat = np.abs(centre[:, 1]) < 0.1
    cosine = (surface.normal * inward).sum(axis=1) / np.linalg.norm(inward, axis=1)
    arc = angle_of(centre) < proof.zone_2().shape.end
    assert cosine[flat & arc].min() > 0.99
    sides = np.abs(surface.normal[~flat & arc][:, 1])
    np.testing.assert_allclose(sides, np.sqrt(0.5), rtol=2e-3)  # facets of 50 mm on an arc of 2 m


@pytest.mark.slow
def test_a_stream_of_coarse_ore():
    for claim in proof.stream(seconds=1.0, noise=0.01, **proof.COARSE):
        assert claim.holds, claim


@pytest.mark.slow
def test_a_stream_of_ore_twice_as_large():
    for claim in proof.stream(seconds=2.0, noise=0.007, coarsening=2.0, slice_width=0.07):
        assert claim.holds, claim
