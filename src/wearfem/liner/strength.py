"""How near the liner is to failing: measures of stress, deflection, reserve, and what the supports carry."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


def von_mises(stress: np.ndarray) -> np.ndarray:
    """(...,) [Pa] sqrt(3/2 s : s) of the deviator s of stress (..., 3, 3): the uniaxial stress of equal distortion energy

    Source: von Mises (1913). Valid for: metals that yield at the same stress in tension and compression.
    """
    deviator = stress - np.eye(3) * (np.trace(stress, axis1=-2, axis2=-1) / 3.0)[..., None, None]
    return np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator))


def principal_stress(stress: np.ndarray) -> np.ndarray:
    """(..., 3) [Pa] eigenvalues of stress (..., 3, 3), largest tension first"""
    return np.linalg.eigvalsh(stress)[..., ::-1]


@dataclass(frozen=True)
class Reaction:
    """What a support does to the liner."""

    force: np.ndarray  # (3,) [N]
    moment: np.ndarray  # (3,) [N m] about the origin


@dataclass(frozen=True)
class Strength:
    """The liner in equilibrium under one load case."""

    displacement: np.ndarray  # (n, 3) [m] of the nodes of the mesh
    stress: np.ndarray  # (n, 3, 3) [Pa] at the nodes; of a shell, on the face where it is more severe
    reaction: Mapping[str, Reaction]  # of each support, by the name of its group
    energy: float  # [J] stored in liner and supports: half the work of the loads
    yield_stress: float  # [Pa]

    @property
    def deflection(self) -> np.ndarray:
        """(n,) [m] length of the displacement"""
        return np.linalg.norm(self.displacement, axis=1)

    @property
    def von_mises(self) -> np.ndarray:
        """(n,) [Pa] see `von_mises`"""
        return von_mises(self.stress)

    @property
    def principal_stress(self) -> np.ndarray:
        """(n, 3) [Pa] largest tension first"""
        return principal_stress(self.stress)

    @property
    def reserve_factor(self) -> np.ndarray:
        """(n,) [-] yield stress over von Mises stress: how many times the load until first yield; infinite without stress"""
        with np.errstate(divide="ignore"):
            return self.yield_stress / self.von_mises

    def at_facets(self, field: np.ndarray, facet: np.ndarray) -> np.ndarray:
        """A field (n, ...) by node as a field (f, ...) by facet: mean of the corners of facets (f, 3 or 4)"""
        return field[facet].mean(axis=1)
