"""A factor as a free curve of one quantity: what carries the residual, where no formula of the library does."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from wearfem.errors import UserError
from wearfem.wear.effect import FactorEffect, require_steps


@dataclass(frozen=True)
class FactorCurve(FactorEffect):
    """A tabulated effect: straight lines between points over one feature, constant beyond.

    **Source** a diagnosis, or a test. **Valid for** the range of the feature that it was found in.
    """

    feature: str  # of `wearfem.wear.features`, or a column of the survey
    at: tuple[float, ...]  # in SI, rising
    ratio: tuple[float, ...]  # [-]
    axis: int = -1  # of a position: 0, 1 or 2

    def __post_init__(self) -> None:
        if not self.feature:
            raise UserError(
                "a FactorCurve was given no feature; name the quantity that the factor depends on."
            )
        require_steps("FactorCurve", self.at, self.ratio, least=0.0)

    @property
    def needs(self) -> tuple[str, ...]:  # type: ignore[override]
        """The one feature"""
        return (self.feature,)

    def factor(self, **known: Any) -> Any:
        """[-] by the feature"""
        value = np.asarray(known[self.feature])
        return np.interp(value if self.axis < 0 else value[..., self.axis], self.at, self.ratio)
