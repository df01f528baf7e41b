"""Smoothing: the Helmholtz filter beside its theory, what it must keep, and the mesh sensitivity of raw depth that it cures."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial import Delaunay
from scipy.special import k0

from wearfem.material import Material
from wearfem.proof import Claim
from wearfem.surface import Surface, rectangle
from wearfem.wear.smooth import HelmholtzFilter

STEEL = Material("steel", 7850.0, 80e9, 0.3)
EQUATION = "w - l^2 Lap w = depth"
SENSITIVITY_LENGTH = 0.05  # [m] on a plate of 1 m
IMPACTS = 2000
CELLS = (16, 32, 64, 128, 256)  # along the plate's sides
PATCHES = 16  # along the sides: fixed squares of 62.5 mm, whose mean depth is compared


def claims() -> Iterator[Claim]:
    """Response to waves and points, what is kept, what does not cross, and impacts on finer and finer meshes."""
    yield from _theory()
    yield from _kept()
    yield from _edges()
    yield from _sensitivity()


def _theory() -> Iterator[Claim]:
    length = 0.1
    wave = 2.0 * np.pi
    exact = 1.0 / (1.0 + (length * wave) ** 2)
    error = []
    for cells in (16, 32, 64):
        surface = uneven(cells)
        shape = np.cos(wave * surface.corner.mean(axis=1)[:, 0])
        smooth = HelmholtzFilter(surface, length)(shape)
        error.append(np.sqrt(surface.area @ (smooth - exact * shape) ** 2))
        amplitude = float((surface.area * shape) @ smooth / ((surface.area * shape) @ shape))
    yield Claim(
        "amplitude of a cosine of 10 lengths, uneven mesh of 64 cells", f"1 / (1 + l^2 k^2), from {EQUATION}", exact, amplitude,
        "-", 5e-3, True, "the error of the mesh is (k h)^2 / 4 = 0.24 % and half of that by the facet's mean",
    )  # fmt: skip
    yield Claim(
        "order of its error in the edge length", "linear elements", 2.0, float(np.log2(error[-2] / error[-1])), "-", 0.15,
        False, "the triangles are not similar from mesh to mesh",
    )  # fmt: skip
    surface = uneven(96)
    centre = surface.corner.mean(axis=1)
    start = int(np.argmin(((centre[:, :2] - 0.5) ** 2).sum(axis=1)))
    point = np.zeros(len(centre))
    point[start] = 1.0 / surface.area[start]
    length = 0.05
    smooth = HelmholtzFilter(surface, length)(point)
    away = centre - centre[start]
    for lengths in (1.0, 2.0, 4.0):
        ring = np.abs(np.hypot(away[:, 0], away[:, 1]) / length - lengths) < 0.2
        theory = k0(np.hypot(away[ring, 0], away[ring, 1]) / length) / (2.0 * np.pi * length**2)
        ratio = float((surface.area[ring] @ smooth[ring]) / (surface.area[ring] @ theory))
        yield Claim(
            f"volume of a point found {lengths:g} lengths away", "K0(r / l) / (2 pi l^2)", 1.0, ratio, "-", 0.02, True,
            "edges are a fifth of the length: (h / l)^2 / 4 = 1 %, and as much by the size of the facet",
        )  # fmt: skip
    variance = float((surface.area * smooth) @ away[:, 0] ** 2) / length**2
    yield Claim(
        "variance of a point's volume along an axis, in l^2", "that of a Gaussian with standard deviation sqrt(2) l", 2.0, variance,
        "-", 0.03, True, "edges of a fifth of the length add (h / l)^2 / 3 or so; the border cuts off 0.1 %",
    )  # fmt: skip


def _kept() -> Iterator[Claim]:
    volume, constant, least, beyond = 0.0, 0.0, np.inf, 0.0
    for seed in range(20):
        surface = needles(seed)
        smooth = HelmholtzFilter(surface, 10.0 ** np.random.default_rng(seed).uniform(-3.0, 1.0))
        point = np.zeros(len(surface.triangle))
        point[np.random.default_rng(seed).integers(len(point), size=3)] = 1.0
        spread = smooth(point)
        volume = max(volume, abs(float(surface.area @ spread / (surface.area @ point)) - 1.0))
        constant = max(constant, float(np.abs(smooth(np.ones(len(point))) - 1.0).max()))
        least, beyond = min(least, float(spread.min())), max(beyond, float(spread.max()))
    what = "20 random triangulations with needles, heights to 1/1000 of their length, lengths from 1 mm to 10 m on 1 m"
    yield Claim(
        "change of the volume", what, 0.0, volume, "-", 1e-12, False, "rounding of a sum over 600 facets"
    )
    yield Claim("change of a constant", what, 0.0, constant, "-", 1e-10, False,
                "rounding times the condition of needles, (l / h)^2")  # fmt: skip
    yield Claim(
        "least value from points of 1 on 0, if negative",
        what,
        0.0,
        min(least, 0.0),
        "-",
        0.0,
        False,
        "exact: see _factor",
    )
    yield Claim("largest value, if above 1", what, 0.0, max(beyond - 1.0, 0.0), "-", 1e-10, False, "rounding")


def _edges() -> Iterator[Claim]:
    surface = folded(8)
    wall = surface.corner.mean(axis=1)[:, 2] > 0.0
    field = np.where(wall, 0.0, np.random.default_rng(1).random(len(wall)))
    smooth = HelmholtzFilter(surface, 0.3)(field)
    yield Claim(
        "largest depth that crosses a sharp edge of 90 degrees", "no exchange", 0.0, float(np.abs(smooth[wall]).max()), "m", 0.0,
        False, "exact: the two sides share no unknown",
    )  # fmt: skip
    bent = HelmholtzFilter(surface, 0.3, sharp=np.pi)(field)
    yield Claim(
        "depth on the wall where 90 degrees count as smooth", "for comparison", float(bent[wall].max()), float(bent[wall].max()),
        "m", np.inf, False,
    )  # fmt: skip
    surface = uneven(16)
    field = np.random.default_rng(2).random(len(surface.triangle))
    smooth = HelmholtzFilter(surface, 0.1)(field)
    order = np.random.default_rng(3).permutation(len(field))
    turned = np.roll(surface.triangle, 1, axis=1)[order]
    again = HelmholtzFilter(replace(surface, triangle=turned, facet=np.arange(len(order))), 0.1)(field[order])
    yield Claim(
        "change by another numbering of the facets and their corners", "invariance", 0.0, float(np.abs(again - smooth[order]).max()),
        "-", 1e-13, False, "rounding",
    )  # fmt: skip


def _sensitivity() -> Iterator[Claim]:
    rows = sensitivity()
    edge, raw, smooth, raw_error, error, patch_error = rows.T
    what = f"{IMPACTS} impacts at random places, edges {1e3 * edge[0]:g} to {1e3 * edge[-1]:.3g} mm, l = {1e3 * SENSITIVITY_LENGTH:g} mm"
    yield Claim(
        "largest raw depth on the finest mesh over that on the second finest", "one or two impacts on facets of a quarter: 2 to 4",
        3.0, float(raw[-1] / raw[-2]), "-", 1.0, False,
        f"{what}; it grows without end: {listed(raw)} of the mean depth",
    )  # fmt: skip
    yield Claim(
        "mean-square error of raw depth over the last halving, order", "points have no square: -1", -1.0,
        float(np.log2(raw_error[-2] / raw_error[-1])), "-", 0.1, False, f"{listed(raw_error)} of the mean depth",
    )  # fmt: skip
    orders = np.log2(error[:-1] / error[1:])
    yield Claim(
        "smoothed depth: error over that on the mesh before, largest of all halvings", "it converges: below 1, by 1/2 in the limit", 0.5,
        float((error[1:] / error[:-1]).max()), "-", 0.5, False, f"{listed(error)} of the mean depth",
    )  # fmt: skip
    yield Claim(
        "order of the last halving", "linear elements loaded by points: 1 (Scott 1973)", 1.0, float(orders[-1]), "-", np.inf, False,
        f"orders {listed(orders)}, still rising, as edges are not yet small against the length",
    )  # fmt: skip
    yield Claim(
        "largest error of the mean depth of 256 patches, order over all meshes", "a facet knows the place of an impact to its size: 1",
        1.0, float(np.polyfit(np.log(edge), np.log(patch_error), 1)[0]), "-", 0.25, False,
        f"{listed(patch_error)} of the mean depth; places are random, so the order scatters from mesh to mesh",
    )  # fmt: skip
    tip = np.log(2.0) / (2.0 * np.pi * SENSITIVITY_LENGTH**2 * IMPACTS)
    yield Claim(
        "growth of the largest smoothed depth over the last halving", "tip of K0 at one impact: v ln 2 / (2 pi l^2)", float(tip),
        float(smooth[-1] - smooth[-2]), "mean depth", np.inf, False,
        f"{listed(smooth)} of the mean depth: it goes on as a logarithm at each impact, less the more of them a length holds",
    )  # fmt: skip


def listed(values: np.ndarray) -> str:
    """Numbers in a sentence."""
    return ", ".join(f"{value:.3g}" for value in values)


def sensitivity() -> np.ndarray:
    """Impacts of equal volume, at random places with a smooth density, on finer and finer meshes of one plate.

    Returns
    -------
    numpy.ndarray
        (meshes, 6): edge length [m]; largest raw and smoothed depth; distance of the cells' raw and smoothed depth from the exact
        smoothed depth, in the mean square; largest distance of the mean smoothed depth of a patch. Depths in parts of the mean depth.
    """
    place = impacts()
    rows = []
    for cells in CELLS:
        surface = rectangle((0.0, 0.0), (1.0, 1.0), (cells, cells), STEEL)
        raw = raw_depth(place, cells)
        smooth = HelmholtzFilter(surface, SENSITIVITY_LENGTH)(raw)
        exact = exact_means(place, cells).ravel()
        distance = [
            np.sqrt(np.mean((field.reshape(-1, 2).mean(axis=1) - exact) ** 2)) for field in (raw, smooth)
        ]
        mean = smooth.reshape(PATCHES, cells // PATCHES, PATCHES, -1).mean(axis=(1, 3))
        off = np.abs(mean - exact_means(place, PATCHES)).max()
        rows.append([1.0 / cells, raw.max(), smooth.max(), *distance, off])
    return np.array(rows)


def impacts() -> np.ndarray:
    """(i, 2) [m] places with the density 1 + 0.8 cos(pi x) cos(pi y) on a square of 1 m, by rejection"""
    random = np.random.default_rng(20)
    trial = random.random((4 * IMPACTS, 2))
    density = 1.0 + 0.8 * np.cos(np.pi * trial).prod(axis=1)
    return trial[1.8 * random.random(len(trial)) < density][:IMPACTS]


def raw_depth(place: np.ndarray, cells: int) -> np.ndarray:
    """(2 cells^2,) depth of the triangles of `rectangle`: volume of the impacts in each over its area, mean 1"""
    column, row = np.minimum((place * cells).astype(int), cells - 1).T
    x, y = (place * cells - np.stack([column, row], axis=1)).T
    triangle = 2 * (column * cells + row) + (y > x)  # cut from the lower left to the upper right
    return np.bincount(triangle, minlength=2 * cells**2) * 2.0 * cells**2 / len(place)


def exact_means(place: np.ndarray, cells: int, waves: int = 1500) -> np.ndarray:
    """(cells, cells) means over square cells of the solution with natural borders, by its cosine series; mean 1"""
    number = np.arange(waves)
    norm = np.where(number == 0, 1.0, 2.0)
    x, y = (np.cos(np.pi * number * place[:, axis, None]) for axis in (0, 1))
    damping = 1.0 + (SENSITIVITY_LENGTH * np.pi) ** 2 * (number[:, None] ** 2 + number**2)
    factor = norm[:, None] * norm * (x.T @ y) / len(place) / damping
    middle = (np.arange(cells) + 0.5) / cells
    mean = np.cos(np.pi * number * middle[:, None]) * np.sinc(0.5 * number / cells)
    return mean @ factor @ mean.T


def uneven(cells: int) -> Surface:
    """A square of 1 m with its inner points moved at random by a quarter of a cell."""
    surface = rectangle((0.0, 0.0), (1.0, 1.0), (cells, cells), STEEL)
    point = surface.point.copy()
    inner = ((point[:, :2] > 1e-9) & (point[:, :2] < 1.0 - 1e-9)).all(axis=1)
    point[inner, :2] += np.random.default_rng(cells).uniform(-0.25, 0.25, (inner.sum(), 2)) / cells
    return replace(surface, point=point)


def needles(seed: int, count: int = 300) -> Surface:
    """A triangulation of random points on a square of 1 m, stretched by up to 1000 so that most angles are near 0 or pi."""
    random = np.random.default_rng(seed)
    stretch = 10.0 ** random.uniform(0.0, 3.0)
    place = random.random((count, 2)) * (1.0, 1.0 / stretch)
    triangle = Delaunay(place).simplices
    a, b, c = np.moveaxis(place[triangle], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangle = np.where(area[:, None] < 0.0, triangle[:, ::-1], triangle)
    point = np.column_stack([place * (1.0, stretch**2), np.zeros(count)])
    return Surface(point, triangle[np.abs(area) > 1e-9 / stretch], STEEL)


def folded(cells: int) -> Surface:
    """A floor of 1 m and a wall of 1 m that rises from its far side."""
    floor = rectangle((0.0, 0.0), (2.0, 1.0), (2 * cells, cells), STEEL)
    x = floor.point[:, 0]
    point = np.column_stack([np.minimum(x, 1.0), floor.point[:, 1], np.maximum(x - 1.0, 0.0)])
    return replace(floor, point=point)
