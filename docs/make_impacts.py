"""Draw docs/pictures/impacts.png: oblique impacts in the engine beside theory, experiment and finite elements.

python docs/make_impacts.py
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from wearfem.errors import in_a_sentence
from wearfem.proofs import impacts
from wearfem.proofs._impact_rig import MESH, Rig
from wearfem.verification import impact_tests as published
from wearfem.verification.impact_tests import ImpactTest
from wearfem.verification.oblique_theory import partial_slip_impact, partial_slip_rebound
from wearfem.verification.rigid_impact import Impact, Rebound

BLUE, ORANGE, GREY, BLACK = "#1f5f99", "#c8641b", "#9a9a9a", "#222222"


def main() -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(13.2, 4.6), constrained_layout=True)
    test_five(panels[0])
    test_four(panels[1])
    test_six(panels[2])
    for panel in panels:
        panel.axhline(0.0, color=GREY, linewidth=0.5)
        panel.spines[["top", "right"]].set_visible(False)
        panel.legend(frameon=False, fontsize=8)
    target = Path(__file__).parent / "pictures" / "impacts.png"
    target.parent.mkdir(exist_ok=True)
    figure.savefig(target, dpi=160)
    print(f"wrote {target}")


def engine_points(panel, x: list[float], on_plane: list[float], on_mesh: list[float]) -> None:
    panel.plot(x, on_plane, "o", color=BLUE, markersize=6, label="wearfem, plane", zorder=4)
    panel.plot(x, on_mesh, ".", color="white", markersize=4, zorder=5)
    panel.plot([], [], "o", markerfacecolor="white", markeredgecolor=BLUE, label="wearfem, mesh (white dots)")


def both(one: Rig, list_of: tuple[Impact, ...]) -> tuple[list[Rebound], list[Rebound]]:
    mesh = replace(one, cut=MESH)
    return [one.rebound(impact) for impact in list_of], [mesh.rebound(impact) for impact in list_of]


def test_five(panel) -> None:
    """psi_2 over psi_1, steel, elastic: where micro-slip counts."""
    test = published.OBLIQUE_SPEEDS
    one = impacts.rig(test, test.variants[0])
    chosen = tuple(i for i in test.impacts if impacts.angle_of(one, i) < 7.0)
    extra = tuple(Impact(5.0, (speed, 0.0)) for speed in (5.5, 7.0, 8.0, 10.0, 11.0, 12.0))
    chosen = tuple(sorted(chosen + extra, key=lambda i: i.tangential_velocity[0]))
    after = both(one, chosen)
    x = [impacts.angle_of(one, impact) for impact in chosen]
    points = [[impacts.reflection_of(one, i, r) for i, r in zip(chosen, rows, strict=True)] for rows in after]
    engine_points(panel, x, *points)
    fine = [Impact(5.0, (speed, 0.0)) for speed in np.linspace(0.05, 12.5, 90)]
    angle = np.array([impacts.angle_of(one, i) for i in fine])
    same = [impacts.reflection_of(one, i, impacts.spring_law(one, i)) for i in fine]
    rigid = [impacts.reflection_of(one, i, impacts.theory_of(one, i)) for i in fine]
    panel.plot(angle, same, color=BLUE, linewidth=1.2, label="same law, other integrator")
    panel.plot(
        angle, partial_slip_impact(one.pair.chi, angle).reflection, color=ORANGE, label="Maw, Barber, Fawcett"
    )
    panel.plot(angle, rigid, "--", color=BLACK, linewidth=1.0, label="rigid bodies")
    panel.set(
        title="Test 5: steel, e = 1",
        xlabel=r"incidence $\psi_1 = \kappa v_s/(\mu v_n)$",
        ylabel=r"reflection $\psi_2 = \kappa v_s'/(\mu v_n)$",
    )


def patch_angle(after: Rebound) -> float:
    return math.degrees(math.atan2(after.slip_velocity, after.separation_speed))


def test_four(panel) -> None:
    """Rebound angle of the patch over incidence angle, aluminium oxide: the experiment."""
    test: ImpactTest = published.OBLIQUE_ANGLES
    one = impacts.rig(test, test.variants[0])
    first, second = one.variant.first, one.variant.second
    x = list(published.INCIDENCE_DEGREES)
    on_plane, on_mesh = both(one, test.impacts)
    engine_points(panel, x, [patch_angle(r) for r in on_plane], [patch_angle(r) for r in on_mesh])
    degrees = np.linspace(0.5, 86.0, 90)
    fine = [Impact(3.9 * math.cos(a), (3.9 * math.sin(a), 0.0)) for a in np.radians(degrees)]
    panel.plot(
        degrees,
        [patch_angle(impacts.spring_law(one, i)) for i in fine],
        color=BLUE,
        linewidth=1.2,
        label="same law, other integrator",
    )
    micro = [patch_angle(partial_slip_rebound(first, second, i, one.friction)) for i in fine]
    panel.plot(degrees, micro, color=ORANGE, label="Maw, Barber, Fawcett (e = 1)")
    panel.plot(
        degrees,
        [patch_angle(impacts.theory_of(one, i)) for i in fine],
        "--",
        color=BLACK,
        linewidth=1.0,
        label="rigid bodies",
    )
    measured = np.array(test.published[0].points)
    panel.plot(*measured.T, "x", color=BLACK, label="experiment, Kharaz et al. (2001)")
    panel.set(
        title="Test 4: aluminium oxide, e = 0.98",
        xlabel="incidence angle [degree]",
        ylabel="rebound angle of the contact patch [degree]",
        xlim=(0, 62),
        ylim=(-18, 55),
    )


def test_six(panel) -> None:
    """Slip after over rebound speed, spinning aluminium sphere, strongly damped."""
    test = published.SPINNING_PLANE
    one = impacts.rig(test, test.variants[0])
    radius = one.variant.first.radius
    chosen = test.impacts[:14]

    def ratio(after: Rebound) -> float:
        return after.slip_velocity / after.separation_speed

    x = [impact.angular_velocity[0] * radius / 0.2 for impact in chosen]
    on_plane, on_mesh = both(one, chosen)
    engine_points(panel, x, [ratio(r) for r in on_plane], [ratio(r) for r in on_mesh])
    spin = np.linspace(0.1, x[-1] * 0.2 / radius * 1.02, 80)
    fine = [Impact(0.2, angular_velocity=(w, 0.0)) for w in spin]
    line = spin * radius / 0.2
    panel.plot(
        line,
        [ratio(impacts.spring_law(one, i)) for i in fine],
        color=BLUE,
        linewidth=1.2,
        label="same law, other integrator",
    )
    panel.plot(
        line,
        [ratio(impacts.theory_of(one, i)) for i in fine],
        "--",
        color=BLACK,
        linewidth=1.0,
        label="rigid bodies",
    )
    panel.set(
        title="Test 6: spinning aluminium sphere, e = 0.5",
        xlabel=r"surface speed over normal speed $R\omega/v_n$",
        ylabel=r"slip after over rebound speed $v_s'/v_n'$",
    )


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
