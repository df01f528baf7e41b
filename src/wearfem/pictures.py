"""The liner in pictures: what is left, what has gone, where it is stressed, how it bends, how good its mesh is."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from wearfem.errors import UserError, in_words
from wearfem.liner.breakthrough import thickness
from wearfem.liner.liner import Liner, worn_face
from wearfem.liner.mesh import LinerMesh, ShellMesh, find_facets, triangles
from wearfem.liner.quality import POOR, quality
from wearfem.liner.strength import Strength
from wearfem.record import whole_file
from wearfem.render import View, paint, round_below, shade
from wearfem.units import day

LARGEST = 0.08  # of the liner's size: how far the deflected shape is drawn from the shape before


@dataclass(frozen=True)
class Picture:
    """One file: a body in colours from one or two sides, its colour bar, and what to know of it."""

    name: str
    title: str
    label: str  # of the colour bar, with unit
    limits: tuple[float, float]
    colours: str
    views: tuple[View, ...]
    note: str
    spread: np.ndarray | None = None  # values to count beside the body


@dataclass(frozen=True)
class Drawn:
    """The files made, and a sentence on how they could look better; empty if they could not."""

    files: tuple[Path, ...]
    message: str


def draw_liner(
    folder: Path,
    liner: Liner,
    *,
    depth: np.ndarray | None = None,
    rate: np.ndarray | None = None,
    strength: Strength | None = None,
    displacement: np.ndarray | None = None,
    names: Sequence[str] = (),
    time_limit: float = 120.0,
) -> Drawn:
    """Draw all that is known of a liner, each as a PNG in `folder`.

    Parameters
    ----------
    folder
        Made if it is not there; files of the same names are replaced.
    liner
        As it is now: `thickness.png` [mm], `depth.png` [mm], `quality.png` [-].
    depth
        (f,) [m] worn off; by default the liner's own.
    rate
        (f,) [m/s] of wear: `rate.png` [mm/day].
    strength
        Of one load case: `stress.png`, von Mises [MPa], of a solid from both sides, and `deflection.png`.
    displacement
        (n, 3) [m] for `deflection.png`, by default that of `strength`; it is drawn larger, and the picture says how much.
    names
        Of the pictures wanted, such as `("thickness", "stress")`; by default all that can be drawn from what is given.
    time_limit
        [s] for pyvista to shade all of them; 0 leaves it out. Where it fails or is late, matplotlib paints.

    Raises
    ------
    UserError
        for fields of the wrong shape or not finite, and for pictures that do not exist or lack their field.
    """
    mesh = liner.mesh
    depth = _by_facet(mesh, "depth", liner.depth if depth is None else depth)
    if displacement is None and strength is not None:
        displacement = strength.displacement
    picture = [_thickness(liner), _depth(liner, depth)]
    if rate is not None:
        picture.append(_rate(liner, _by_facet(mesh, "rate", rate)))
    if strength is not None:
        _by_node(mesh, strength.displacement)
        picture.append(_stress(liner, strength))
    if displacement is not None:
        picture.append(_deflection(liner, _by_node(mesh, displacement)))
    picture.append(_quality(liner))
    known = [one.name for one in picture]
    if unknown := [name for name in names if name not in known]:
        raise UserError(
            f"there is no picture {in_words(unknown, 'or')}: what was given makes {in_words(known)}; rate, strength or displacement "
            "make more."
        )
    picture = [one for one in picture if not names or one.name in names]
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"cannot make the folder {folder} ({error.strerror}): give one that can be written"
        ) from error
    view = [(one, each) for one in picture for each in one.views]
    shaded = shade(
        [each for _, each in view],
        [one.limits for one, _ in view],
        [one.colours for one, _ in view],
        time_limit,
    )
    left = iter(shaded.image)
    return Drawn(
        tuple(_draw(folder, one, [next(left) for _ in one.views]) for one in picture), shaded.trouble
    )


# ---------------------------------------------------------------------------------------------- what is drawn


def _thickness(liner: Liner) -> Picture:
    mesh, left = liner.mesh, 1e3 * thickness(liner.mesh)
    left = np.where(np.isfinite(left), left, np.nan)
    if np.isnan(left).all():
        note, place = "no line across the liner ends on its other side", None
    else:
        facet = int(np.nanargmin(left))
        place = _centre(mesh, mesh.wear[facet])
        note = f"least {left[facet]:.4g} mm at {_place(place)}, greatest {np.nanmax(left):.4g} mm"
        note += "; grey: a line across leaves by a side" if np.isnan(left).any() else ""
    return Picture(
        "thickness", "Thickness left", "thickness [mm]", _limits(left, zero=False), "viridis", (_worn(mesh, left, place),), note
    )  # fmt: skip


def _depth(liner: Liner, depth: np.ndarray) -> Picture:
    return _lost(liner, "depth", "Depth worn off", "depth [mm]", 1e3 * depth, "mm", "nothing has worn yet")


def _rate(liner: Liner, rate: np.ndarray) -> Picture:
    return _lost(liner, "rate", "Rate of wear", "rate [mm/day]", 1e3 * day * rate, "mm/day", "nothing wears")


def _lost(
    liner: Liner, name: str, title: str, label: str, value: np.ndarray, unit: str, nothing: str
) -> Picture:
    mesh, facet = liner.mesh, int(np.argmax(value))
    area = _area(mesh, mesh.wear)
    place = _centre(mesh, mesh.wear[facet]) if value[facet] > 0.0 else None
    note = nothing
    if place is not None:
        mean = float(value @ area / area.sum())
        note = f"greatest {value[facet]:.4g} {unit} at {_place(place)}, mean over the worn face {mean:.4g} {unit}"
    if name == "depth" and liner.service_time:
        note += f", after {liner.service_time / day:.4g} days"
    return Picture(
        name, title, label, _limits(value, zero=True), "inferno_r", (_worn(mesh, value, place),), note
    )


def _stress(liner: Liner, strength: Strength) -> Picture:
    mesh, stress = liner.mesh, strength.von_mises
    factor, unit = (1e-6, "MPa") if stress.max(initial=0.0) >= 1e5 else (1e-3, "kPa")
    value, worst = factor * stress, int(np.argmax(stress))
    node, facet = _skin(mesh)
    seen = view_direction(mesh)
    front = View(node, facet, value, seen, by_node=True, closed=_closed(mesh))
    normal = _normal_at(node, facet, worst)
    views: tuple[View, ...] = (replace(front, mark=node[worst]),)
    if _closed(mesh):
        back = replace(front, direction=-seen, title="from the back")
        on_front = float(normal @ seen) >= float(normal @ back.direction)
        views = (
            replace(front, title="from the worn side", mark=node[worst] if on_front else None),
            replace(back, mark=None if on_front else node[worst]),
        )
    note = f"greatest {value[worst]:.4g} {unit} at {_place(node[worst])}"
    if np.isfinite(strength.yield_stress):
        reserve = strength.reserve_factor.min()
        note += f", yield at {1e-6 * strength.yield_stress:.4g} MPa: reserve factor {reserve:.3g}"
    if isinstance(mesh, ShellMesh):
        note += "; the more severe of worn face and back"
    return Picture(
        "stress",
        "Von Mises stress",
        f"von Mises stress [{unit}]",
        _limits(value, zero=True),
        "plasma",
        views,
        note,
    )


def _deflection(liner: Liner, displacement: np.ndarray) -> Picture:
    mesh = liner.mesh
    node, facet = _skin(mesh)
    length = np.linalg.norm(displacement, axis=1)
    most, worst = float(length.max()), int(np.argmax(length))
    size = float(np.linalg.norm(np.ptp(node[np.unique(facet)], axis=0)))
    scale = round_below(LARGEST * size / most) if most > 0.0 else 1.0
    factor, unit = (1e3, "mm") if most >= 1e-4 else (1e6, "µm")
    still = View(node, facet, factor * length, _oblique(mesh), by_node=True, closed=_closed(mesh))
    moved = node + scale * displacement
    view = replace(still, node=moved, before=node[still.edges], mark=moved[worst] if most > 0.0 else None)
    note = f"greatest {factor * most:.4g} {unit} at {_place(node[worst])}; dashed: without load"
    return Picture(
        "deflection", f"Deflected shape, drawn {scale:,.10g} times larger", f"deflection [{unit}]",
        _limits(view.value, zero=True), "viridis", (view,), note,
    )  # fmt: skip


def _quality(liner: Liner) -> Picture:
    mesh, value = liner.mesh, quality(liner.mesh)
    node, facet = _skin(mesh)
    worst, poor = int(np.argmin(value)), int((value < POOR).sum())
    place = node[mesh.element[worst]].mean(axis=0)
    what = f"{poor} below {POOR:g}: remesh" if poor else f"none below {POOR:g}, where a remesh is due"
    note = (
        f"{len(value)} elements: worst {value[worst]:.3g} at {_place(place)}, mean {value.mean():.3g}, {what}"
    )
    view = View(
        node, facet, value[_owner(mesh, facet)], _oblique(mesh), closed=_closed(mesh), title="elements at the surface"
    )  # fmt: skip
    return Picture(
        "quality", "Quality of the mesh", "mean ratio [-], 1 is regular, 0 is flat", (0.0, 1.0), "RdYlBu", (view,), note, value
    )  # fmt: skip


# -------------------------------------------------------------------------------------------------- how it lies


def _skin(mesh: LinerMesh) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and facets (k, 3 or 4) of what can be seen; of a shell, its worn face."""
    return (worn_face(mesh), mesh.element) if isinstance(mesh, ShellMesh) else (mesh.node, mesh.boundary)


def _closed(mesh: LinerMesh) -> bool:
    return not isinstance(mesh, ShellMesh)


def _owner(mesh: LinerMesh, facet: np.ndarray) -> np.ndarray:
    """(k,) the element that has all corners of each facet of the boundary"""
    at_element = _incidence(mesh.element, len(mesh.node))
    shared = (_incidence(facet, len(mesh.node)) @ at_element.T).tocoo()
    whole = shared.data == facet.shape[1]
    owner = np.empty(len(facet), int)
    owner[shared.row[whole]] = shared.col[whole]
    return owner


def _incidence(cell: np.ndarray, nodes: int) -> csr_array:
    """(k, n) 1 where a cell (k, c) has a node"""
    row = np.repeat(np.arange(len(cell)), cell.shape[1])
    return csr_array((np.ones(cell.size, int), (row, cell.ravel())), shape=(len(cell), nodes))


def _worn(mesh: LinerMesh, value: np.ndarray, mark: np.ndarray | None) -> View:
    """The liner from its worn side with a value (f,) on the facets that wear; all else is grey."""
    node, facet = _skin(mesh)
    colour = np.full(len(facet), np.nan)
    colour[find_facets(mesh.wear, facet)] = value
    return View(node, facet, colour, view_direction(mesh), closed=_closed(mesh), mark=mark)


def _area_vector(mesh: LinerMesh, facet: np.ndarray) -> np.ndarray:
    corner, owner = triangles(facet)
    a, b, c = np.moveaxis(_skin(mesh)[0][corner], 1, 0)
    total = np.zeros((len(facet), 3))
    np.add.at(total, owner, 0.5 * np.cross(b - a, c - a))
    return total


def _area(mesh: LinerMesh, facet: np.ndarray) -> np.ndarray:
    return np.linalg.norm(_area_vector(mesh, facet), axis=1)


def view_direction(mesh: LinerMesh) -> np.ndarray:
    """(3,) unit vector to an eye that looks at the worn face.

    Along its mean normal n if it is flat (|sum A n| > 0.98 sum A); a little from the side if it is bent; obliquely from above if it
    goes all round, so that no side is the right one (< 0.3).
    """
    vector = _area_vector(mesh, mesh.wear)
    mean = vector.sum(axis=0) / np.linalg.norm(vector, axis=1).sum()
    flat = float(np.linalg.norm(mean))
    if flat < 0.3:
        return np.array([0.5, -0.7, 0.5]) / np.linalg.norm([0.5, -0.7, 0.5])
    mean = mean / flat
    return mean if flat > 0.98 else _turned(mean, 0.35, -0.15)


def _oblique(mesh: LinerMesh) -> np.ndarray:
    """(3,) to an eye that sees the worn face and two sides."""
    seen = view_direction(mesh)
    return _turned(seen, 0.55, -0.85)


def _turned(direction: np.ndarray, right: float, up: float) -> np.ndarray:
    """A direction moved to the right and upwards, as somebody sees it who looks against it."""
    axes = View(np.eye(3), np.array([[0, 1, 2]]), np.zeros(1), direction).axes
    turned = direction + right * axes[0] + up * axes[1]
    return turned / np.linalg.norm(turned)


def _normal_at(node: np.ndarray, facet: np.ndarray, number: int) -> np.ndarray:
    corner = triangles(facet)[0]
    a, b, c = np.moveaxis(node[corner[(corner == number).any(axis=1)]], 1, 0)
    return np.cross(b - a, c - a).sum(axis=0)


def _centre(mesh: LinerMesh, facet: np.ndarray) -> np.ndarray:
    return _skin(mesh)[0][facet].mean(axis=0)


def _place(place: np.ndarray) -> str:
    x, y, z = np.round(place, 4) + 0.0
    return f"({x:.4g}, {y:.4g}, {z:.4g}) m"


# ------------------------------------------------------------------------------------------------ how it is drawn


def _limits(value: np.ndarray, *, zero: bool) -> tuple[float, float]:
    """The ends of the colour bar: from zero, or from the least value; never the same."""
    low = 0.0 if zero else float(np.nanmin(value)) if np.isfinite(value).any() else 0.0
    high = float(np.nanmax(value)) if np.isfinite(value).any() else 1.0
    if high - low <= 1e-6 * max(abs(high), abs(low)):
        return (0.0, max(high, 1.0) if high <= 0.0 else high) if zero else (0.99 * low, 1.01 * high)
    return low, high


def _draw(folder: Path, one: Picture, image: Sequence[np.ndarray | None]) -> Path:
    """The picture as a file; returns its path."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    sides = [view.frame[1] for view in one.views]
    shape = float(np.clip(max(half[1] / half[0] for half in sides), 0.25, 1.6))
    each = 7.0 if len(sides) == 1 and one.spread is None else 5.2
    if shape > 1.0:
        each /= shape**0.5
    height = float(np.clip(each * shape, 1.6, 8.0))
    panels = len(sides) + (one.spread is not None)
    head = 0.8 / (height + 1.9)  # for title and note
    layout = ConstrainedLayoutEngine(h_pad=0.08, w_pad=0.12, rect=(0.0, 0.02, 1.0, 0.98 - head))
    figure = Figure(figsize=(each * panels + 1.5, height + 1.9), layout=layout)
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, panels, squeeze=False)[0]
    for place, view, shaded in zip(axes, one.views, image, strict=False):
        scale = paint(place, view, shaded, one.limits, one.colours)
    figure.colorbar(scale, ax=list(axes[: len(sides)]), label=one.label, shrink=0.9, aspect=25, pad=0.02)
    if one.spread is not None:
        _count(axes[-1], one.spread)
    for text, down, style in (
        (one.title, 0.15, {"fontsize": 13, "fontweight": "bold"}),
        (one.note, 0.5, {"fontsize": 9}),
    ):
        figure.text(0.5, 1.0 - down / figure.get_figheight(), text, ha="center", va="top", **style)
    path = folder / f"{one.name}.png"
    with whole_file(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)
    return path


def _count(axes: Any, value: np.ndarray) -> None:
    """How many elements have which quality."""
    axes.hist(value, bins=np.linspace(0.0, 1.0, 41), color="#5b7db1")
    axes.axvline(POOR, color="#c0392b", linestyle="--", label=f"remesh below {POOR:g}")
    axes.set(xlim=(0.0, 1.0), xlabel="mean ratio [-]", ylabel="elements", title="all elements")
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


# -------------------------------------------------------------------------------------------- what is accepted


def _by_facet(mesh: LinerMesh, what: str, field: np.ndarray) -> np.ndarray:
    field = np.asarray(field, float)
    if field.shape != (len(mesh.wear),):
        raise UserError(
            f"{mesh.name}: a {what} of shape {field.shape} was given, but the group 'wear' has {len(mesh.wear)} facets; give one number "
            "for each, in its order."
        )
    if not np.isfinite(field).all():
        bad = int(np.argmin(np.isfinite(field)))
        raise UserError(
            f"{mesh.name}: the {what} of facet {bad} is {field[bad]}; finite numbers can be drawn."
        )
    return field


def _by_node(mesh: LinerMesh, field: np.ndarray) -> np.ndarray:
    field = np.asarray(field, float)
    if field.shape != (len(mesh.node), 3):
        raise UserError(
            f"{mesh.name}: a field of shape {field.shape} was given for {len(mesh.node)} nodes; give displacement and strength of "
            "this liner as it is now."
        )
    if not np.isfinite(field).all():
        bad = int(np.argmin(np.isfinite(field).all(axis=1)))
        raise UserError(f"{mesh.name}: the field at node {bad} is {field[bad]}; finite numbers can be drawn.")
    return field
