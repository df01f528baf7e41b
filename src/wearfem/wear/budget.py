"""How a tolerance is divided between jumps that are too long and samples that are too short, so that a life costs least."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import ndtr

LEAST = 8  # blocks of a sample
LARGEST_SHARE = 0.5  # of the tolerance for bias, which is known from estimates only


@dataclass(frozen=True)
class Plan:
    """The cheapest way through a life: jumps of one length, what is thrown away after each, and what noise may do."""

    jump: float  # [s] service time
    warm_up: float  # [s] of flow
    variance: float  # [s2] of the end of life, from sampling
    sampling: float  # [s] of steady flow in the whole life


def cheapest_plan(
    life: float,
    longest: float,
    *,
    change: float,
    bend: float,
    noise_density: float,
    memory: float,
    block: float,
    tolerance: float,
    confidence: float,
) -> Plan:
    """How many jumps, and how much to throw away after each, so that warm-ups and samples cost least.

    N jumps with a warm-up W each and S seconds of samples in all cost N W + S. They make the end of life err by the parts

        k / (12 N^2)                    trapezoid rule; it is taken off in the end, so far as it is known, and counted in full here
        g m exp(-W/m) / S               samples that still see some of the surface before the jump

    which add up to b times the tolerance e. S = s / (q e)^2, q the standard deviation with which a normal error around b stays within
    1 with the confidence asked. Derived in docs/decisions/0006-how-long-a-sample-may-be-trusted.md.

    Parameters
    ----------
    life, longest
        [s] service time of the whole life, and of the longest jump allowed.
    change, bend
        [-] g = r' L / r and k = r'' L^2 / r of the rate r over the life L; not negative.
    noise_density
        [s] s, the relative variance of a mean rate times the length of its window.
    memory
        [s] m, in which the flow forgets all but 1/e of the surface before.
    block
        [s] of a sample; the one in which the surface moves is thrown away always, and a sample has `LEAST` of them.
    tolerance, confidence
        [-] see `wearfem.wear.jump.Goal`.

    **Valid for** a flow that forgets exponentially and a rate whose slope and bend stay what they are over the life.
    """
    fewest = max(life / longest, 1.0)
    jumps = np.geomspace(fewest, max(np.sqrt(bend / (0.12 * tolerance)), 2.0 * fewest), 60)[:, None]
    faded = np.linspace(0.0, 10.0, 61)
    warm_up = block + memory * faded

    shares, deviations = _deviations(confidence)
    samples = np.maximum(noise_density / (deviations[0] * tolerance) ** 2, jumps * LEAST * block)
    bias = bend / (12.0 * jumps**2)
    share = (bias + change * memory * np.exp(-faded) / samples) / tolerance
    deviation = np.interp(share, shares, deviations)
    sampling = np.maximum(noise_density / (deviation * tolerance) ** 2, jumps * LEAST * block)
    cost = np.where(share <= LARGEST_SHARE, jumps * warm_up + sampling, np.inf)
    row, column = np.unravel_index(np.argmin(cost), cost.shape)
    return Plan(
        jump=life / float(jumps[row, 0]),
        warm_up=float(warm_up[column]),
        variance=(float(deviation[row, column]) * tolerance * life) ** 2,
        sampling=float(sampling[row, column]),
    )


@cache
def _deviations(confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """Shares of bias, and `deviation_beside` each: asked for every cycle."""
    shares = np.linspace(0.0, LARGEST_SHARE, 51)
    return shares, deviation_beside(shares, confidence)


def deviation_beside(bias: np.ndarray, confidence: float) -> np.ndarray:
    """The standard deviation s with which b + s N lies within -1 and 1 with the confidence, N normal and 0 <= b < 1; by bisection."""
    low, high = np.full_like(bias, 1e-3), np.full_like(bias, 100.0)
    for _ in range(60):
        middle = np.sqrt(low * high)
        inside = ndtr((1.0 - bias) / middle) - ndtr((-1.0 - bias) / middle) > confidence
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return low
