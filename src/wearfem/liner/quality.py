"""The shape of elements: 1 for the regular triangle and tetrahedron and for the cube, 0 for one without volume."""

import numpy as np

from wearfem.liner.mesh import LinerMesh

POOR = 0.1  # [-] quality of the worst element below which a liner should be meshed again

# The three neighbours of each corner of a hexahedron, in right-handed order
_NEIGHBOUR = np.array(
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]]
)


def quality(mesh: LinerMesh) -> np.ndarray:
    """(e,) mean ratio of each element, in [0, 1]; 0 for an element that is flat or inverted.

    With the edges l at an element, its area A or volume V, and the determinant d of the three edges at a corner of a hexahedron,

    - triangle: 4 sqrt(3) A / sum l^2,
    - tetrahedron: 12 (3 V)^(2/3) / sum l^2,
    - hexahedron: least over the corners of 3 d^(2/3) / sum of l^2 at the corner.

    It does not change with size, place or rotation. A box with sides a, b, c has 3 (a b c)^(2/3) / (a^2 + b^2 + c^2).

    Source
    ------
    Liu and Joe 1994, BIT 34, 268-287 (tetrahedron); Knupp 2001, SIAM J. Sci. Comput. 23, 193-218, and Stimpson et al. 2007, "The
    Verdict geometric quality library", SAND2007-1751, metric "shape" (all three).

    Valid for
    ---------
    straight elements; a triangle of a shell has no sign, so its quality is 0 only where it is flat.
    """
    corner = mesh.node[mesh.element]
    count = mesh.element.shape[1]
    if count == 8:
        edge = corner[:, _NEIGHBOUR] - corner[:, :, None]
        size = 3.0 * np.cbrt(np.maximum(np.linalg.det(edge), 0.0)) ** 2
        return (size / np.einsum("ecij,ecij->ec", edge, edge)).min(axis=1)
    first, second = np.triu_indices(count, 1)
    length = ((corner[:, first] - corner[:, second]) ** 2).sum(axis=(1, 2))
    if count == 4:
        return 12.0 * np.cbrt(np.maximum(0.5 * determinant(mesh)[:, 0], 0.0)) ** 2 / length
    twice = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return 2.0 * np.sqrt(3.0) * twice / length


def worst(mesh: LinerMesh) -> float:
    """The least `quality` of all elements."""
    return float(quality(mesh).min())


def determinant(mesh: LinerMesh) -> np.ndarray:
    """[m3] of the three edges at the corners of solid elements: (e, 1) for tetrahedra (6 V), (e, 8) for hexahedra.

    All above zero: not inverted. For a hexahedron that is necessary and, short of extreme shapes, sufficient (Knupp 1990, "On the
    invertibility of the isoparametric map", Comput. Methods Appl. Mech. Eng. 78, 313-329).
    """
    corner = mesh.node[mesh.element]
    if mesh.element.shape[1] == 8:
        return np.linalg.det(corner[:, _NEIGHBOUR] - corner[:, :, None])
    return np.linalg.det(corner[:, 1:] - corner[:, :1])[:, None]
