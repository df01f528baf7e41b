"""Draw docs/pictures/shell_obstacle_course.png: the shell on the obstacle course, from coarse to fine meshes.

python docs/make_shell.py
"""

from pathlib import Path

import numpy as np

from wearfem.errors import in_a_sentence
from wearfem.liner.block import Falling, Rising
from wearfem.proofs._shell_problems import OBSTACLES
from wearfem.report import draw_lines, picture

CELLS = np.array([4, 8, 16, 32])


def main() -> None:
    target = Path(__file__).parent / "pictures" / "shell_obstacle_course.png"
    with picture(target, columns=2) as panels:
        for axes, (name, cut) in zip(panels, (("rising", Rising), ("falling", Falling)), strict=True):
            lines = {
                one.name: np.array([one.computed(int(n), cut) for n in CELLS]) / one.reference
                for one in OBSTACLES
            }
            axes.axhspan(0.98, 1.02, color="0.88", zorder=0)
            draw_lines(axes, CELLS, lines, "cells along each side", "displacement over published value", "o-")
            axes.set(
                title=f"{name} diagonals", xscale="log", xticks=CELLS, xticklabels=CELLS, ylim=(0.0, 1.15)
            )
            axes.minorticks_off()
            for label, value in lines.items():
                print(f"{name:8} {label:45}", *(f"{x:.4f}" for x in value))
            axes.get_legend().remove()
        handles, names = panels[0].get_legend_handles_labels()
        panels[0].figure.legend(handles, names, loc="outside lower center", ncols=4, frameon=False)
    print(f"wrote {target}")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
