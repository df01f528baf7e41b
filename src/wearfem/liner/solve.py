"""The liner in equilibrium: a structure is factorised once and answers as many load cases as are asked.

K u = f with  u = F u  for F the projector on what the supports leave free:  (F K F + s (1 - F)) u = F f, symmetric and positive. Small
systems are factorised (SuperLU); large ones are solved by conjugate gradients with multigrid: from the quadratic displacements to the
linear ones of the same mesh, and from there by smoothed aggregation with the rigid motions as near null space.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pyamg
from pyamg.multilevel import MultilevelSolver
from pyamg.relaxation.smoothing import change_smoothers
from scipy import sparse
from scipy.sparse.linalg import splu

from wearfem.errors import UserError
from wearfem.liner.body import Body
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import ShellMesh, group_of
from wearfem.liner.shell import Shell
from wearfem.liner.solid import Solid
from wearfem.liner.strength import Reaction, Strength
from wearfem.liner.support import Fixed, Support, grow, require_held, spring

STRONG = 0.08  # [-] coupling above which nodes are aggregated (Vanek, Mandel and Brezina 1996, section 5)
TOLERANCE = 1e-8  # [-] residual over load at which conjugate gradients stop; rounding of K u is 1e-10 of the load on thin plates


@dataclass(frozen=True)
class Structure:
    """What holds the liner, what it weighs and what it bears."""

    supports: Sequence[Support]
    yield_stress: float = np.inf  # [Pa]
    gravity: tuple[float, float, float] = (
        0.0,
        0.0,
        0.0,
    )  # [m/s2] as (0, 0, -9.81); the weight is in every load case

    def __post_init__(self) -> None:
        if not self.yield_stress > 0:
            raise UserError(f"the yield stress is {self.yield_stress!r} Pa; it must be above 0.")


@dataclass(frozen=True)
class Load:
    """Forces by facet (k, 3) [N], each spread evenly over its facet, for groups by name."""

    force: Mapping[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True)
class Factorised:
    """A structure ready to be loaded. It stands as long as the geometry stands: after recession, factorise again."""

    body: Body
    structure: Structure
    held: Mapping[
        str, np.ndarray
    ]  # (p, m, m) of each fixed group: what it holds that no group before it holds
    springs: Mapping[str, np.ndarray]  # (p, 3, 3) [N/m] of each elastic support

    @cached_property
    def free(self) -> sparse.bsr_matrix:
        """(m p, m p) projector F on the free directions"""
        return _blocks(np.eye(self.body.freedom) - _sum(self.held, self.body, self.body.freedom))

    @cached_property
    def stiffness(self) -> sparse.csr_matrix:
        """(m p, m p) of liner and springs, before anything is fixed"""
        spring = np.zeros((len(self.body.point), self.body.freedom, self.body.freedom))
        spring[:, :3, :3] = _sum(self.springs, self.body, 3)
        return (self.body.stiffness + _blocks(spring)).tocsr()

    @cached_property
    def _inverse(self) -> Callable[[np.ndarray], np.ndarray]:
        """Solves for a load of no component in held directions."""
        free, matrix = self.free, self.stiffness
        scale = matrix.diagonal().mean()
        matrix = free @ matrix @ free + scale * (sparse.identity(len(matrix.diagonal())) - free)
        if matrix.shape[0] <= self.body.direct_limit:
            return _refined(matrix.tocsc())
        return _multigrid(self.body, free, matrix, scale)

    def respond(self, force: np.ndarray) -> np.ndarray:
        """(p, m) displacements in equilibrium with loads (p, m) at the points; what acts in held directions goes to the supports."""
        flat = (self.free @ force.ravel()).ravel()
        return self._inverse(flat).reshape(force.shape) if flat.any() else np.zeros(force.shape)

    def solve(self, load: Load | None = None) -> Strength:
        """The liner under its weight and `load`.

        Raises
        ------
        UserError
            for forces of the wrong shape or not finite, and for a group that does not exist.
        """
        body, structure = self.body, self.structure
        force = body.weight(np.array(structure.gravity, float))
        for group, by_facet in (load or Load()).force.items():
            force = force + body.load(group, checked_force(body, group, by_facet))
        displacement = self.respond(force)
        residual = (self.stiffness @ displacement.ravel()).reshape(force.shape) - force
        reaction = {
            group: _reaction(body, np.einsum("pab,pb->pa", block, residual))
            for group, block in self.held.items()
        }
        for group, block in self.springs.items():
            reaction[group] = _reaction(body, -np.einsum("pab,pb->pa", block, displacement[:, :3]))
        return Strength(
            displacement[: len(body.mesh.node), :3],
            body.stress(displacement),
            reaction,
            0.5 * float(np.vdot(force, displacement)),
            structure.yield_stress,
        )


def solve_elastic(liner: Liner, structure: Structure, load: Load | None = None) -> Strength:
    """Displacement, stress and reactions of a liner under one load case; see `factorise` for many."""
    return factorise(liner, structure).solve(load)


def factorise(liner: Liner, structure: Structure) -> Factorised:
    """The liner on its supports, ready for load cases.

    Raises
    ------
    UserError
        where supports leave a rigid motion free (the sentence names it), or name a group that does not exist or twice.
    """
    body = body_of(liner)
    names = [support.group for support in structure.supports]
    if len(set(names)) < len(names):
        raise UserError(f"the groups {names} are supported; name each of them once.")
    total = np.zeros((len(body.point), body.freedom, body.freedom))
    held, springs = {}, {}
    for support in structure.supports:
        if isinstance(support, Fixed):
            point = np.unique(body.share(support.group)[0].tocoo().row)
            before = total[point]
            total[point] = grow(before, support.held(body.freedom))
            held[support.group] = np.zeros_like(total)
            held[support.group][point] = total[point] - before
        else:
            springs[support.group] = spring(body, support)
    ready = Factorised(body, structure, held, springs)
    require_held(body, total, _sum(springs, body, 3))
    return ready


def body_of(liner: Liner) -> Body:
    """The elastic body of a liner: solid or shell, as its mesh is."""
    if isinstance(liner.mesh, ShellMesh):
        return Shell(liner.mesh, liner.material)
    return Solid(liner.mesh, liner.material)


def _refined(matrix: sparse.csc_matrix) -> Callable[[np.ndarray], np.ndarray]:
    """Factors, with one step of iterative refinement against the rounding of unpivoted factors."""
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(force: np.ndarray) -> np.ndarray:
        first = factors.solve(force)
        return first + factors.solve(force - matrix @ first)

    return solve


def _multigrid(
    body: Body, free: sparse.bsr_matrix, matrix: sparse.csr_matrix, scale: float
) -> Callable[[np.ndarray], np.ndarray]:
    """Conjugate gradients with a V-cycle: points, nodes, then aggregates of nodes."""
    size, nodes = body.freedom, body.freedom * len(body.mesh.node)
    fine = matrix.tobsr((size, size))
    coarse_free = free.tocsr()[:nodes, :nodes]
    motions = np.asarray(coarse_free @ body.rigid_motions.reshape(-1, 6)[:nodes])
    levels = []
    if len(body.point) > len(body.mesh.node):
        level = MultilevelSolver.Level()
        raised = sparse.kron(body.interpolation, sparse.identity(size))
        level.A, level.P = fine, (free @ raised @ coarse_free).tobsr((size, size))
        level.R = level.P.T.tobsr((size, size))
        levels, matrix = [level], level.R @ fine @ level.P + scale * (sparse.identity(nodes) - coarse_free)
    rest = pyamg.smoothed_aggregation_solver(
        matrix.tobsr((size, size)),
        B=motions,
        strength=("symmetric", {"theta": STRONG}),
        improve_candidates=None,
        max_coarse=50,
    )
    cycle = MultilevelSolver(levels + rest.levels, coarse_solver="pinv")
    relaxation = ("block_gauss_seidel", {"sweep": "symmetric"})
    change_smoothers(cycle, relaxation, relaxation)

    def solve(force: np.ndarray) -> np.ndarray:
        found, failed = cycle.solve(force, tol=TOLERANCE, accel="cg", maxiter=500, return_info=True)
        if failed:
            raise UserError(
                f"{body.mesh.name}: conjugate gradients did not converge in 500 steps: look for very flat elements or for supports on "
                "single points."
            )
        return found

    return solve


def checked_force(body: Body, group: str, force: np.ndarray) -> np.ndarray:
    """Forces as (k, 3) [N], one for each facet of the group; refuse all others."""
    count, force = len(group_of(body.mesh, group)), np.asarray(force, float)
    if force.shape != (count, 3) or not np.isfinite(force).all():
        raise UserError(
            f"forces of shape {force.shape} were given for '{group}'; finite forces in N of shape ({count}, 3) are needed."
        )
    return force


def _reaction(body: Body, force: np.ndarray) -> Reaction:
    """Resultant of loads (p, m) at the points: by the work that they do in rigid motions"""
    work = np.einsum("pa,pam->m", force, body.rigid_motions[:, : force.shape[1]])
    return Reaction(work[:3], work[3:])


def _sum(blocks: Mapping[str, np.ndarray], body: Body, size: int) -> np.ndarray:
    return sum(blocks.values(), start=np.zeros((len(body.point), size, size)))


def _blocks(block: np.ndarray) -> sparse.bsr_matrix:
    count, size = block.shape[:2]
    return sparse.bsr_matrix(
        (block, np.arange(count), np.arange(count + 1)), shape=(count * size, count * size)
    )
