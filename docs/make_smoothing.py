"""Draw docs/pictures/smoothing.png: impacts on finer and finer meshes, raw and smoothed. Run from anywhere: takes some seconds."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from wearfem.errors import in_a_sentence
from wearfem.proofs.smoothing import (
    IMPACTS,
    SENSITIVITY_LENGTH,
    STEEL,
    exact_means,
    impacts,
    raw_depth,
    sensitivity,
)
from wearfem.surface import rectangle
from wearfem.wear.smooth import HelmholtzFilter

PICTURE = Path(__file__).parent / "pictures" / "smoothing.png"
SHOWN = (16, 64, 256)


def main() -> None:
    """Maps above, convergence below."""
    place = impacts()
    figure, axes = plt.subplots(3, 3, figsize=(11, 10.5), layout="constrained")
    for column, cells in enumerate(SHOWN):
        surface = rectangle((0.0, 0.0), (1.0, 1.0), (cells, cells), STEEL)
        raw = raw_depth(place, cells)
        smooth = HelmholtzFilter(surface, SENSITIVITY_LENGTH)(raw)
        for row, (field, top, name) in enumerate(((raw, 10.0, "raw"), (smooth, 2.2, "smoothed"))):
            ax = axes[row, column]
            picture = ax.tripcolor(*surface.point[:, :2].T, surface.triangle, field, vmin=0.0, vmax=top)
            ax.set_aspect("equal")
            ax.set_xticks([])
            ax.set_yticks([])
            ax.set_title(f"{name}, edges of {1e3 / cells:.3g} mm: largest {field.max():.3g}", fontsize=10)
            if column == 2:
                figure.colorbar(
                    picture, ax=ax, label="depth / mean depth", extend="max" if row == 0 else None
                )
    edge, raw_top, smooth_top, raw_error, error, patch_error = sensitivity().T
    left, middle, right = axes[2]
    left.loglog(1e3 * edge, raw_top, "o-", label="raw")
    left.loglog(1e3 * edge, smooth_top, "s-", label="smoothed")
    left.set_ylabel("largest depth / mean depth")
    left.legend()
    middle.loglog(1e3 * edge, raw_error, "o-", label="raw, mean square")
    middle.loglog(1e3 * edge, error, "s-", label="smoothed, mean square")
    middle.loglog(1e3 * edge, patch_error, "^-", label="smoothed, worst of 256 patches")
    middle.loglog(1e3 * edge, error[-1] * edge / edge[-1], "k:", label="order 1")
    middle.set_ylabel("distance from the exact solution / mean depth")
    middle.legend(fontsize=8)
    for ax in (left, middle):
        ax.set_xlabel("edge length [mm]")
        ax.set_xticks(1e3 * edge, [f"{1e3 * one:.3g}" for one in edge], fontsize=8)
        ax.minorticks_off()
    exact = exact_means(place, 256)
    right.plot((np.arange(256) + 0.5) / 256, exact[:, 128], "k", lw=2, label="exact")
    for cells in SHOWN:
        surface = rectangle((0.0, 0.0), (1.0, 1.0), (cells, cells), STEEL)
        smooth = HelmholtzFilter(surface, SENSITIVITY_LENGTH)(raw_depth(place, cells))
        line = smooth.reshape(cells, cells, 2).mean(axis=2)[:, cells // 2]
        right.plot((np.arange(cells) + 0.5) / cells, line, label=f"edges of {1e3 / cells:.3g} mm", lw=1)
    right.set_xlabel("x [m], along the middle")
    right.set_ylabel("smoothed depth / mean depth")
    right.legend(fontsize=8)
    figure.suptitle(
        f"{IMPACTS} impacts at random places: depth by facet, raw and with a smoothing length of {1e3 * SENSITIVITY_LENGTH:g} mm"
    )
    figure.savefig(PICTURE, dpi=110)
    print(f"wrote {PICTURE}")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
