"""One flat triangle of a thick shell: the optimal membrane triangle and the discrete Kirchhoff-Mindlin plate, as formulas.

Six degrees of freedom a corner: displacements (u, v, w) and rotations (theta_x, theta_y, theta_z) about the triangle's axes.
All functions take e triangles at once. Strains vary linearly over a triangle, so that corner values say everything:
operators have the shape (e, corner, component, 9), and energies follow from the moments of `thickness_moments`.

**Source** of the membrane: C. A. Felippa, A study of optimal membrane triangles with drilling freedoms, Comput. Methods Appl. Mech.
Engrg. 192 (2003) 2125-2168 (the element OPT). Of the plate: I. Katili, A new discrete Kirchhoff-Mindlin element based on
Mindlin-Reissner plate theory and assumed shear strain fields - part I, Int. J. Numer. Methods Eng. 36 (1993) 1859-1883 (DKMT).
Both are derived and judged in docs/decisions/0004-the-shell.md.
"""

import numpy as np
from skfem.quadrature import get_quadrature_tri

MEMBRANE = np.array([0, 1, 5, 6, 7, 11, 12, 13, 17])  # u, v, theta_z of the corners, among the 18
PLATE = np.array([2, 3, 4, 8, 9, 10, 14, 15, 16])  # w, theta_x, theta_y of the corners
ALPHA = 1.5  # of the drilling rotations' share in the sides' displacement: alpha_b of Felippa (2003)
SHEAR_CORRECTION = 5.0 / 6.0  # of the transverse shear of a homogeneous section, Reissner (1945)

_SIDE = ((0, 1), (1, 2), (2, 0))  # from corner, to corner
_SIDES_AT = ((0, 2), (1, 0), (2, 1))  # the two sides that meet in a corner


def axes_of(corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes (e, 3, 3) of triangles as rows, and their corners (e, 3, 2) [m] in them from the first corner on.

    The third axis is the normal, the first is the global x projected on the triangle, or the global y where the normal is within
    18 degrees of x. Nothing but the axes of the resultants depends on this choice.
    """
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    guide = np.where(np.abs(normal[:, :1]) < 0.95, np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
    first = guide - np.einsum("ei,ei->e", guide, normal)[:, None] * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    axes = np.stack([first, np.cross(normal, first), normal], axis=1)
    return axes, np.einsum("eai,eci->eca", axes[:, :2], corner - corner[:, :1])


def area_of(xy: np.ndarray) -> np.ndarray:
    """(e,) [m2]"""
    a, b = xy[:, 1] - xy[:, 0], xy[:, 2] - xy[:, 0]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def plane_stress(young_modulus: float, poisson_ratio: float) -> np.ndarray:
    """(3, 3) [Pa] sigma = C (eps_x, eps_y, gamma_xy) of an isotropic sheet."""
    nu = poisson_ratio
    return (
        young_modulus
        / (1.0 - nu**2)
        * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    )


def thickness_moments(area: np.ndarray, thickness: np.ndarray, power: int) -> np.ndarray:
    """(e, 3, 3) integrals of zeta_i zeta_j h^power over each triangle, h linear between its corners (e, 3); exact to power 3."""
    point, weight = get_quadrature_tri(5)
    zeta = np.stack([1.0 - point[0] - point[1], point[0], point[1]])
    h = (thickness @ zeta) ** power
    return 2.0 * area[:, None, None] * np.einsum("eq,q,iq,jq->eij", h, weight, zeta, zeta)


def membrane_strain(xy: np.ndarray, poisson_ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """The strains (eps_x, eps_y, gamma_xy) of the optimal triangle from (u, v, theta_z): uniform part and linear part.

    eps = (1/V) L^T u + sum_i zeta_i eps_i,  eps_i = 3/2 sqrt(beta_0) T_e Q_i T_theta u

    **Source** Felippa (2003): L in eq. 22, the parameters in eq. 42.

    Returns
    -------
    uniform
        (e, 3, 9) L^T / V, with alpha_b = 3/2.
    linear
        (e, 3, 3, 9) the rest at each corner; it has no mean over a triangle and vanishes under uniform strain.

    **Valid for** isotropic sheets: beta_0 = (1 - 4 nu^2) / 2, not under 0.01, is the optimum for them.
    """
    count = len(xy)
    area = area_of(xy)
    x, y = xy[:, :, 0], xy[:, :, 1]

    uniform = np.zeros((count, 3, 9))
    rotation = np.zeros(
        (count, 3, 9)
    )  # hierarchical corner rotations: theta_i less the rotation of the sides
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        yjk, xkj = y[:, j] - y[:, k], x[:, k] - x[:, j]
        yik, yji = y[:, i] - y[:, k], y[:, j] - y[:, i]
        xki, xij = x[:, k] - x[:, i], x[:, i] - x[:, j]
        uniform[:, 0, 3 * i] = uniform[:, 2, 3 * i + 1] = yjk
        uniform[:, 1, 3 * i + 1] = uniform[:, 2, 3 * i] = xkj
        uniform[:, 0, 3 * i + 2] = ALPHA / 6.0 * yjk * (yik - yji)
        uniform[:, 1, 3 * i + 2] = ALPHA / 6.0 * xkj * (xki - xij)
        uniform[:, 2, 3 * i + 2] = ALPHA / 3.0 * (xki * yik - xij * yji)
        rotation[:, :, 3 * i] = (xkj / (4.0 * area))[:, None]
        rotation[:, :, 3 * i + 1] = (-yjk / (4.0 * area))[:, None]
        rotation[:, i, 3 * i + 2] += 1.0
    uniform /= 2.0 * area[:, None, None]

    along = np.stack([xy[:, b] - xy[:, a] for a, b in _SIDE], axis=1)  # (e, side, 2)
    square = np.einsum("esi,esi->es", along, along)
    direction = np.stack(
        [along[..., 0] ** 2, along[..., 1] ** 2, along[..., 0] * along[..., 1]], axis=2
    )  # eps along a side is direction . eps / square
    from_sides = np.linalg.inv(direction / square[..., None])  # T_e

    b1, b2, b3, b4, b5, b6, b7, b8, b9 = 1.0, 2.0, 1.0, 0.0, 1.0, -1.0, -1.0, -1.0, -2.0
    at_corner = np.array(
        [
            [[b1, b2, b3], [b4, b5, b6], [b7, b8, b9]],
            [[b9, b7, b8], [b3, b1, b2], [b6, b4, b5]],
            [[b5, b6, b4], [b8, b9, b7], [b2, b3, b1]],
        ]
    )  # [corner, side, rotation]
    beta_0 = max(0.5 * (1.0 - 4.0 * poisson_ratio**2), 0.01)
    side_strain = (2.0 * area[:, None] / (3.0 * square))[:, None, :, None] * at_corner  # Q_i
    linear = 1.5 * np.sqrt(beta_0) * (from_sides[:, None] @ side_strain @ rotation[:, None])
    return uniform, linear


def plate_strain(
    xy: np.ndarray, thickness: np.ndarray, poisson_ratio: float
) -> tuple[np.ndarray, np.ndarray]:
    """Curvatures and transverse shear strains of the discrete Kirchhoff-Mindlin triangle from (w, theta_x, theta_y).

    A normal turns by (beta_x, beta_y) = (theta_y, -theta_x), linear between the corners plus 4 zeta_i zeta_j Delta_k along each side k;
    moment equilibrium along the side ties its shear to that, gamma_k = -2/3 phi_k Delta_k, with phi_k = 2 / (kappa (1 - nu)) (h / l_k)^2:

    2/3 l_k (1 + phi_k) Delta_k = w_i - w_j - l_k / 2 (beta_si + beta_sj)      (Katili 1993)

    Returns
    -------
    curvature
        (e, 3, 3, 9) [1/m] (beta_x,x  beta_y,y  beta_x,y + beta_y,x) at each corner.
    shear
        (e, 3, 2, 9) (gamma_xz, gamma_yz) at each corner, from the shears of its two sides.
    """
    count = len(xy)
    area = area_of(xy)
    x, y = xy[:, :, 0], xy[:, :, 1]
    slope = np.stack(
        [np.stack([y[:, j] - y[:, k], x[:, k] - x[:, j]], axis=1) for j, k in ((1, 2), (2, 0), (0, 1))],
        axis=1,
    ) / (2.0 * area[:, None, None])  # (e, corner, 2) gradients of zeta
    tangent, bow, side_shear = [], [], []
    for a, b in _SIDE:
        along = xy[:, b] - xy[:, a]
        length = np.linalg.norm(along, axis=1)
        c, s = (along / length[:, None]).T
        h = 0.5 * (thickness[:, a] + thickness[:, b])
        phi = 2.0 / (SHEAR_CORRECTION * (1.0 - poisson_ratio)) * (h / length) ** 2
        delta = np.zeros((count, 9))
        for corner, sign in ((a, 1.0), (b, -1.0)):
            delta[:, 3 * corner] = sign
            delta[:, 3 * corner + 1] = 0.5 * length * s  # beta_s = c theta_y - s theta_x
            delta[:, 3 * corner + 2] = -0.5 * length * c
        delta *= (1.5 / (length * (1.0 + phi)))[:, None]
        tangent.append((c, s))
        bow.append(delta)
        side_shear.append(-2.0 / 3.0 * phi[:, None] * delta)

    curvature = np.zeros((count, 3, 3, 9))
    for corner in range(3):
        gx, gy = slope[:, None, corner, 0], slope[:, None, corner, 1]
        curvature[:, :, 0, 3 * corner + 2] = gx
        curvature[:, :, 1, 3 * corner + 1] = -gy
        curvature[:, :, 2, 3 * corner + 2] = gy
        curvature[:, :, 2, 3 * corner + 1] = -gx
    for (a, b), (c, s), delta in zip(_SIDE, tangent, bow, strict=True):
        for at, other in ((a, b), (b, a)):  # the gradient of 4 zeta_a zeta_b at corner a is 4 grad zeta_b
            gx, gy = 4.0 * slope[:, other].T
            curvature[:, at, 0] += (gx * c)[:, None] * delta
            curvature[:, at, 1] += (gy * s)[:, None] * delta
            curvature[:, at, 2] += (gy * c + gx * s)[:, None] * delta

    shear = np.empty((count, 3, 2, 9))
    for corner, (p, q) in enumerate(_SIDES_AT):
        (cp, sp), (cq, sq) = tangent[p], tangent[q]
        sine = (cp * sq - cq * sp)[:, None]
        shear[:, corner, 0] = (sq[:, None] * side_shear[p] - sp[:, None] * side_shear[q]) / sine
        shear[:, corner, 1] = (cp[:, None] * side_shear[q] - cq[:, None] * side_shear[p]) / sine
    return curvature, shear


def local_stiffness(
    xy: np.ndarray, thickness: np.ndarray, young_modulus: float, poisson_ratio: float
) -> np.ndarray:
    """(e, 18, 18) stiffness of triangles in their own axes.

    K = int h B_u^T C B_u + int h B_l^T C B_l  +  int h^3/12 B_k^T C B_k + int kappa G h B_s^T B_s

    Parameters
    ----------
    xy
        (e, 3, 2) [m] corners in the triangle's axes, counter-clockwise.
    thickness
        (e, 3) [m] at the corners, linear between them.
    young_modulus, poisson_ratio
        [Pa], [-].
    """
    area = area_of(xy)
    sheet = plane_stress(young_modulus, poisson_ratio)
    shear_modulus = 0.5 * young_modulus / (1.0 + poisson_ratio)
    uniform, linear = membrane_strain(xy, poisson_ratio)
    curvature, shear = plate_strain(xy, thickness, poisson_ratio)
    once, cubed = (thickness_moments(area, thickness, power) for power in (1, 3))

    stiffness = np.zeros((len(xy), 18, 18))
    membrane = once.sum(axis=(1, 2))[:, None, None] * (uniform.transpose(0, 2, 1) @ sheet @ uniform)
    stiffness[:, MEMBRANE[:, None], MEMBRANE] = membrane + _energy(linear, sheet, once)
    stiffness[:, PLATE[:, None], PLATE] = _energy(curvature, sheet / 12.0, cubed) + _energy(
        shear, SHEAR_CORRECTION * shear_modulus * np.eye(2), once
    )
    return stiffness


def _energy(strain: np.ndarray, modulus: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """(e, 9, 9) sum over corners i, j of moment_ij B_i^T modulus B_j"""
    stress = np.einsum("eij,ejkd->eikd", moment, modulus @ strain, optimize=True)
    flat = (len(strain), -1, 9)
    return strain.reshape(flat).transpose(0, 2, 1) @ stress.reshape(flat)
