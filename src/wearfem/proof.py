"""A claim with its evidence: what a source says, what this machine computed, and how far apart they may be."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """One comparison of a proof.

    Parameters
    ----------
    claim
        What is claimed, in a few words.
    source
        Where the expected value comes from: a formula, a paper with its equation, a published table.
    expected, computed
        The value of the source and the one computed here, in `unit`.
    unit
        Of both values; "-" for pure numbers.
    tolerance
        The largest difference allowed: a part of the expected value if `relative`, in `unit` if not. Infinity for a
        difference that is shown and not judged.
    relative
        How `tolerance` is meant.
    note
        What the reader should know: the reason of the tolerance, or of a difference.
    """

    claim: str
    source: str
    expected: float
    computed: float
    unit: str
    tolerance: float
    relative: bool
    note: str = ""

    @property
    def difference(self) -> float:
        """Distance of computed from expected, measured like the tolerance; zero for equal values."""
        apart = abs(self.computed - self.expected)
        if not self.relative or apart == 0.0:
            return apart
        return apart / abs(self.expected) if self.expected else float("inf")

    @property
    def holds(self) -> bool:
        """Whether the difference is within the tolerance; never for a value that is not a number."""
        return self.difference <= self.tolerance

    @property
    def verdict(self) -> str:
        """`holds`, `FAILS`, or `shown` for a difference that is not judged."""
        if not self.holds:
            return "FAILS"
        return "shown" if self.tolerance == float("inf") else "holds"
