"""How fast the liner swings by itself: mass of solids and shells, and the lowest natural frequencies on the supports.

K u = omega^2 M u. Loads that change much slower than the lowest of them are followed without inertia (`flexure.py`).
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from wearfem.errors import UserError
from wearfem.liner.body import Body
from wearfem.liner.shell import Shell, middle_surface
from wearfem.liner.shell_element import area_of, axes_of, thickness_moments
from wearfem.liner.solid import Solid
from wearfem.liner.solve import Factorised


def lowest_frequencies(ready: Factorised, count: int = 1) -> np.ndarray:
    """(count,) [Hz] natural frequencies of a liner on its supports, lowest first.

    Parameters
    ----------
    ready
        From `factorise`; its factors are used again.
    count
        How many.

    Raises
    ------
    UserError
        for fewer than one or as many as there are degrees of freedom, and where the iteration does not converge.

    Source
    ------
    Lanczos on K^-1 M (ARPACK in shift-invert mode about 0: Lehoucq, Sorensen and Yang 1998, section 3.2).

    Valid for
    ---------
    small vibrations without damping; the mass of the ore that lies on the liner is not counted, and lowers them.
    """
    body = ready.body
    size = len(body.point) * body.freedom
    if not 1 <= count < size - 1:
        raise UserError(
            f"{count} natural frequencies of {body.mesh.name} were asked for; there are 1 to {size - 2}."
        )
    free, shape = ready.free, (len(body.point), body.freedom)
    mass = free @ mass_matrix(body) @ free
    inverse = LinearOperator(
        (size, size), matvec=lambda force: ready.respond(force.reshape(shape)).ravel(), dtype=float
    )
    start = free @ np.random.default_rng(0).standard_normal(size)  # any will do; the same gives the same bits
    try:
        square = eigsh(
            ready.stiffness,
            count,
            mass,
            sigma=0.0,
            OPinv=inverse,
            v0=start,
            tol=1e-6,
            ncv=min(size - 1, 2 * count + 6),
            return_eigenvectors=False,
        )
    except ArpackNoConvergence as error:
        raise UserError(
            f"{body.mesh.name}: {count} natural frequencies did not converge; ask for fewer, or hold the liner better."
        ) from error
    return np.sqrt(np.sort(square)) / (2.0 * np.pi)


def mass_matrix(body: Body) -> sparse.csr_matrix:
    """(m p, m p) consistent mass of a solid or a shell: u^T M u / 2 is the kinetic energy of velocities u.

    - Solid: int rho phi_i phi_j dV for each direction.
    - Shell: int rho h zeta_i zeta_j dA of its middle surface, which moves with u + theta x lever, and the rotary inertia
      int rho h^3 / 12 zeta_i zeta_j dA of its normal. Turning about the normal costs none.
    """
    if isinstance(body, Shell):
        return _shell_mass(body)
    if isinstance(body, Solid):
        return sparse.kron(_solid_mass(body), sparse.identity(3), format="csr")
    raise TypeError(f"the mass of a {type(body).__name__} is not known")


def _solid_mass(body: Solid) -> sparse.csr_matrix:
    size = len(body.point)
    total = sparse.csr_matrix((size, size))
    for part in body.elements(order=4):
        shape = np.stack([np.broadcast_to(np.asarray(one[0]), part.dx.shape) for one in part.basis])
        block = body.material.density * np.einsum("ieq,jeq,eq->eij", shape, shape, part.dx, optimize=True)
        number = part.element_dofs.T
        row, column = np.broadcast_arrays(number[:, :, None], number[:, None, :])
        total += sparse.csr_matrix((block.ravel(), (row.ravel(), column.ravel())), shape=(size, size))
    return total


def _shell_mass(body: Shell) -> sparse.csr_matrix:
    mesh, density = body.mesh, body.material.density
    middle, corner = middle_surface(mesh), mesh.element
    axes, xy = axes_of(middle[corner])
    area, normal = area_of(xy), axes[:, 2]
    once, cubed = (thickness_moments(area, mesh.thickness[corner], power) for power in (1, 3))
    lever = (middle - mesh.node)[corner]
    motion = np.zeros((*corner.shape, 3, 6))  # of the middle surface: u + theta x lever
    motion[..., :3] = np.eye(3)
    motion[..., 3:] = np.cross(np.eye(3), lever[..., None, :]).swapaxes(-1, -2)
    block = np.einsum("eij,eiac,ejad->eicjd", density * once, motion, motion, optimize=True)
    tilt = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    block[:, :, 3:, :, 3:] += np.einsum("eij,ecd->eicjd", density / 12.0 * cubed, tilt)
    number = (6 * corner[:, :, None] + np.arange(6)).reshape(len(corner), 18)
    row, column = np.broadcast_arrays(number[:, :, None], number[:, None, :])
    size = 6 * len(mesh.node)
    return sparse.csr_matrix((block.ravel(), (row.ravel(), column.ravel())), shape=(size, size))
