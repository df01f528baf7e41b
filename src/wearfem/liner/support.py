"""What holds the liner: fixed directions, bolts and elastic beds; and which rigid motion they leave free."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from wearfem.errors import UserError, in_words
from wearfem.liner.body import Body
from wearfem.liner.mesh import group_of

Direction = tuple[float, float, float]
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
EVERY = (X, Y, Z)


@dataclass(frozen=True)
class Fixed:
    """The points of a group do not move along `directions`; `Fixed("x_low", (X,))` on a face normal to x is a plane of symmetry.

    `rotations` are the axes about which the points of a shell do not turn: `Fixed("edge", rotations=())` is simply supported. The
    points of a solid do not turn by themselves: there `rotations` says nothing.
    """

    group: str
    directions: tuple[Direction, ...] = EVERY
    rotations: tuple[Direction, ...] = EVERY

    def __post_init__(self) -> None:
        for direction in (*self.directions, *self.rotations):
            if np.shape(direction) != (3,) or not np.isfinite(direction).all() or not np.any(direction):
                raise UserError(
                    f"the support of '{self.group}' names the direction {direction!r}; give three numbers, not all zero, such as X."
                )

    def held(self, freedom: int) -> np.ndarray:
        """(m, m) sum of d d^T over the directions held"""
        block = np.zeros((freedom, freedom))
        for first, directions in ((0, self.directions), (3, self.rotations))[: freedom // 3]:
            for direction in np.array(directions, float).reshape(-1, 3):
                unit = direction / np.linalg.norm(direction)
                block[first : first + 3, first : first + 3] += np.outer(unit, unit)
        return block


@dataclass(frozen=True)
class Bed:
    """An elastic bed under a group: stress [Pa] per displacement [m] along and across its normal (Winkler 1867)."""

    group: str
    normal: float  # [N/m3]
    tangential: float = 0.0  # [N/m3]

    def __post_init__(self) -> None:
        _check_stiffness(self.group, self.normal, self.tangential)

    def spring(self, area: float) -> tuple[float, float]:
        """Stiffness [N/m] along and across the normal of a part of the bed [m2]."""
        return self.normal * area, self.tangential * area


@dataclass(frozen=True)
class ElasticBolt:
    """A bolt to ground, spread evenly over the patch of its group: force [N] per mean displacement [m] of the patch.

    `axial` acts along the mean normal of the patch, `transverse` across it. A shank of length L, section A and modulus E
    has axial = E A / L. A patch that tilts is held too, by axial times its second moment over its area.
    """

    group: str
    axial: float  # [N/m]
    transverse: float  # [N/m]

    def __post_init__(self) -> None:
        _check_stiffness(self.group, self.axial, self.transverse)


Support = Fixed | Bed | ElasticBolt


def _check_stiffness(group: str, *stiffness: float) -> None:
    if not all(0.0 <= value < np.inf for value in stiffness) or not any(stiffness):
        raise UserError(
            f"the support of '{group}' has the stiffnesses {stiffness}; they must be 0 or more, finite and not all zero; for a rigid "
            "support use Fixed."
        )


def spring(body: Body, support: Bed | ElasticBolt) -> np.ndarray:
    """(p, 3, 3) [N/m] the support's springs at the points: k_a n n^T + k_t (1 - n n^T) by each point's share of the area"""
    share, area = body.share(support.group)
    normal = facet_normal(body, support.group)
    if isinstance(support, ElasticBolt):
        axial, transverse = support.axial / area.sum(), support.transverse / area.sum()
        normal = np.broadcast_to(area @ normal / np.linalg.norm(area @ normal), normal.shape)
    else:
        axial, transverse = support.normal, support.tangential
    along = np.einsum("ka,kb->kab", normal, normal)
    block = area[:, None, None] * (axial * along + transverse * (np.eye(3) - along))
    return (share @ block.reshape(-1, 9)).reshape(-1, 3, 3)


def facet_normal(body: Body, group: str) -> np.ndarray:
    """(k, 3) unit normals of the facets of a group, from their diagonals or sides"""
    corner = body.mesh.node[group_of(body.mesh, group)]
    if corner.shape[1] == 2:
        raise UserError(f"'{group}' holds edges; bolts and beds need facets: name a group of facets.")
    vector = np.cross(corner[:, -2] - corner[:, 0], corner[:, -1] - corner[:, 1 - corner.shape[1] % 2])
    return vector / np.linalg.norm(vector, axis=1, keepdims=True)


def grow(held: np.ndarray, block: np.ndarray) -> np.ndarray:
    """(k, m, m) projectors on the directions of `held` (k, m, m) and of `block` (m, m) together"""
    value, vector = np.linalg.eigh(held + block)
    vector = (
        vector * (value > 1e-9)[:, None, :]
    )  # both are sums of unit projectors: others are zero to rounding
    return vector @ np.swapaxes(vector, 1, 2)


def free_motions(body: Body, held: np.ndarray, springs: np.ndarray) -> list[str]:
    """The rigid motions that supports leave free, in words; none for a liner that is held.

    Parameters
    ----------
    body
        Each part of it that hangs together is asked by itself.
    held
        (p, m, m) projectors on the directions in which each point is fixed.
    springs
        (p, 3, 3) [N/m] stiffness of springs to ground.

    A rigid motion r is free where r^T (sum of held + springs / largest spring) r vanishes.
    """
    count, freedom = held.shape[:2]
    matrix = body.stiffness.tobsr((freedom, freedom))
    pattern = sparse.csr_matrix((np.ones(len(matrix.indices)), matrix.indices, matrix.indptr), (count, count))
    parts, part = connected_components(pattern, directed=False)
    ground = held.copy()
    ground[:, :3, :3] += springs / max(springs.max(initial=0.0), np.finfo(float).tiny)
    free = []
    for number in range(parts):
        inside = part == number
        centre = body.point[inside].mean(axis=0)
        size = np.linalg.norm(np.ptp(body.point[inside], axis=0))
        motion = body.rigid_motions[inside]
        turn = (motion[:, :, 3:] - motion[:, :, :3] @ _about(centre)) / size
        motion = np.concatenate([motion[:, :, :3], turn], axis=2)
        value, vector = np.linalg.eigh(np.einsum("pam,pab,pbn->mn", motion, ground[inside], motion))
        loose = vector[
            :, value <= 1e-12 * np.trace(ground[inside].sum(axis=0))
        ]  # far above rounding of a sum
        where = "" if parts == 1 else f" of the part around {_numbers(centre)} m"
        free += [words + where for words in _in_words(loose[:3].T, loose[3:].T / size, centre)]
    return free


def require_held(body: Body, held: np.ndarray, springs: np.ndarray) -> None:
    """Refuse a liner that could move as a rigid body."""
    if free := free_motions(body, held, springs):
        raise UserError(
            f"{body.mesh.name} is not held: its supports leave free the {in_words(free)}. It has the groups "
            f"{in_words(sorted(body.mesh.group))}: add a support on one of them."
        )


def _about(centre: np.ndarray) -> np.ndarray:
    """(3, 3) columns are the velocities at `centre` of unit rotations about x, y, z through the origin"""
    return np.cross(np.eye(3), centre).T


def _in_words(shift: np.ndarray, turn: np.ndarray, centre: np.ndarray) -> list[str]:
    """Rigid motions of velocities `shift` (k, 3) at the centre and rates `turn` (k, 3), as the simplest that span the same."""
    if not len(shift):
        return []
    value, vector = np.linalg.eigh(turn @ turn.T)
    still = value <= 1e-12 * max(value.max(), 1.0)
    translation = _simplest(vector[:, still].T @ shift)
    words = [f"translation along {_axis(direction)}" for direction in translation]
    mixed = _simplest(np.hstack([vector[:, ~still].T @ turn, vector[:, ~still].T @ shift]))
    unit = np.linalg.qr(translation.T)[0] if len(translation) else np.zeros((3, 0))
    for row in mixed:
        rate, velocity = row[:3], row[3:] - unit @ (unit.T @ row[3:])
        through = centre + np.cross(rate, velocity) / (rate @ rate)
        words.append(f"rotation about {_axis(rate)} through {_numbers(through)} m")
    return words


def _simplest(rows: np.ndarray) -> np.ndarray:
    """The reduced row echelon form: vectors of the same span with as many zeros as can be"""
    rows, done = rows.copy(), 0
    for column in range(rows.shape[1]):
        if done == len(rows):
            break
        best = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[best, column]) < 1e-6 * np.abs(rows[done:]).max():
            continue
        rows[[done, best]] = rows[[best, done]]
        rows[done] /= rows[done, column]
        rows -= np.outer(np.where(np.arange(len(rows)) == done, 0.0, rows[:, column]), rows[done])
        done += 1
    return rows[:done]


def _axis(direction: np.ndarray) -> str:
    unit = direction / np.linalg.norm(direction)
    for name, axis in zip("xyz", np.eye(3), strict=True):
        if abs(unit @ axis) > 1.0 - 1e-9:
            return name
    return _numbers(unit)


def _numbers(vector: np.ndarray) -> str:
    return "(" + ", ".join(f"{value + 0.0:.3g}" for value in np.round(vector, 9)) + ")"
