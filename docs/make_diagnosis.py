"""Draw docs/pictures/diagnosis_degrades.png: what a diagnosis says as noise grows and readings get fewer.

python docs/make_diagnosis.py
"""

from pathlib import Path

from wearfem.proofs.diagnosis import Degraded, degradation

GREEN, GREY, RED = "#2e7d4f", "#c9c9c9", "#b3352b"
NOISES = tuple((noise, 24, 6) for noise in (0.1, 0.2, 0.5, 1.0))
READINGS = tuple((0.1, points, occasions) for points, occasions in ((8, 3), (12, 3), (24, 6)))


def main() -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(11.0, 4.0), constrained_layout=True, sharey=True)
    by_noise, by_readings = told(NOISES), told(READINGS)
    draw(panels[0], by_noise, [f"{d.noise:g}" for d in by_noise])
    draw(panels[1], by_readings, [f"{d.points} x {d.occasions}" for d in by_readings])
    panels[0].set_xlabel("gauge error [mm] (24 points, 6 occasions; liners lose 5 to 25 mm)")
    panels[1].set_xlabel("points x occasions (gauge error 0.1 mm)")
    panels[0].set_ylabel("share of 14 plants, one of each kind [%]")
    panels[1].legend(frameon=False, loc="lower right")
    target = Path(__file__).parent / "pictures" / "diagnosis_degrades.png"
    figure.savefig(target, dpi=140)
    print(f"wrote {target}")


def told(designs) -> list[Degraded]:
    found = []
    for one in degradation(designs):
        print(one, flush=True)
        found.append(one)
    return found


def draw(panel, found: list[Degraded], labels: list[str]) -> None:
    place, bottom = range(len(found)), [0.0] * len(found)
    for name, colour, words in (
        ("named", GREEN, "right effect named"),
        ("refused", GREY, "refused: cannot tell, unexplained, or called adequate"),
        ("wrong", RED, "another effect named"),
    ):
        height = [100.0 * getattr(one, name) for one in found]
        panel.bar(place, height, bottom=bottom, color=colour, label=words, width=0.7)
        bottom = [b + h for b, h in zip(bottom, height, strict=True)]
    panel.set_xticks(list(place), labels)
    panel.set_ylim(0.0, 100.0)
    panel.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
