"""What particles did to each facet, as loads on the liner: the mean of the flow, and its peak."""

from dataclasses import dataclass

import numpy as np

from wearfem.errors import UserError
from wearfem.liner.body import Body
from wearfem.liner.liner import Liner
from wearfem.liner.mesh import WEAR, triangles
from wearfem.liner.solve import Load, body_of, checked_force
from wearfem.loads import FacetLoads


@dataclass(frozen=True)
class LoadCases:
    """The loads that a liner is designed for."""

    mean: Load  # impulse of all blocks over their time
    peak: Load  # the block whose resultant force is at the percentile asked for
    peak_block: int  # its number


def nodal_traction(liner: Liner, force_by_facet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Facet forces as consistent nodal loads: of the same work in every displacement that the elements can follow.

    Parameters
    ----------
    liner
        Whose worn face is loaded.
    force_by_facet
        (f, 3) [N] on the facets of `wear`, spread evenly over each: t = F / A. Its resultant acts at the facet's centroid, for
        `FacetLoads` does not know where on a facet the particles pressed.

    Returns
    -------
    point : (p, 3) [m]
        Where the loads act: nodes, then edge, face and cell centres of quadratic elements.
    load : (p, 3) or (p, 6) [N, N m]
        int phi_i t dA. Force and moment are those of the facet forces to rounding, because shape functions sum to one and
        reproduce positions. Loads of a shell have moments: of the lever from the worn face to the nodes.
    """
    body = body_of(liner)
    return body.point, body.load(WEAR, checked_force(body, WEAR, force_by_facet))


def resultant(body: Body, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force (3,) [N] and moment (3,) [N m] about the origin of loads (p, m) at the points: their work in rigid motions"""
    work = np.einsum("pa,pam->m", load, body.rigid_motions)
    return work[:3], work[3:]


def facet_force(loads: FacetLoads, liner: Liner) -> np.ndarray:
    """(b, f, 3) [N] mean force on each facet in each block: -n (normal impulse) / time + (tangential impulse) / time

    n is the mean normal of the facet; a warped facet of four corners has two normals, of which `FacetLoads` keeps no account.

    Raises
    ------
    UserError
        for loads of another number of facets than the liner wears.
    """
    facet = liner.mesh.wear
    if loads.facet_count != len(facet):
        raise UserError(
            f"loads of {loads.facet_count} facets were given for {liner.mesh.name}, which wears on {len(facet)}: use loads sampled on the "
            "surface of this liner."
        )
    corner, owner = triangles(facet)
    a, b, c = np.moveaxis(liner.mesh.node[corner], 1, 0)
    vector = np.zeros((len(facet), 3))
    np.add.at(vector, owner, np.cross(b - a, c - a))
    normal = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    impulse = loads.tangential_impulse - loads.normal_impulse[:, :, None] * normal
    return impulse / loads.duration[:, None, None]


def load_cases(loads: FacetLoads, liner: Liner, percentile: float = 95.0) -> LoadCases:
    """Mean and peak load case of a sample.

    Parameters
    ----------
    loads
        Of one sample, in blocks.
    liner
        On whose facets they act.
    percentile
        [%] of the blocks that press no harder than the peak case. Blocks are ranked by the length of their resultant force on the liner;
        the peak is the block at that rank (the next higher between two), so it is a load that occurred, not one put together of the
        worst of each facet. A block is a mean over its duration: shorter shocks are not seen.
    """
    if not 0.0 <= percentile <= 100.0:
        raise UserError(f"the percentile of the peak load is {percentile!r}; it must be between 0 and 100.")
    force = facet_force(loads, liner)
    total = np.linalg.norm(force.sum(axis=1), axis=1)
    peak = int(np.argsort(total, kind="stable")[int(np.ceil(percentile / 100.0 * (len(total) - 1)))])
    mean = np.einsum("b,bfa->fa", loads.duration, force) / loads.duration.sum()
    return LoadCases(Load({WEAR: mean}), Load({WEAR: force[peak]}), peak)
