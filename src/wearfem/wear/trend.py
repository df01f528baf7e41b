r"""How the rates of wear go on between and beyond their samples, as draws that carry sampling noise and what nobody has seen yet.

A zone wears by its mean depth s, and each of its facets by its own share of it:

    life = int_0^s* ds / r(s),        facet f worn out at s_f:  int_0^s_f q_f(s) ds = allowed depth of f,        s* = min s_f

with the zone's rate r = ds/dt and the ratios q_f of the facets' rates to it. The rate is known at samples, each with its noise, over
geometries that are known exactly. ln r(s) and ln q_f(s) are Gaussian processes whose slope is remembered for a while (`Course`); how
steep and for how long is weighed by what the samples say. So a rate that is seen to change is carried on with a doubt that grows with the
distance, one that is not stays, and ratios that differ by no more than their noise are taken for one: the first of many equal facets
to fail is not the one with the luckiest noise.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.linalg import eigh

from wearfem.wear.sampling import Sample, inefficiency, lag_products

STAYS = 0.5  # probability, before anything is sampled, that a rate stays as it is
SLOPES = (0.1, 0.3, 1.0, 3.0)  # [-] of ln r over a life where it does not: from hardly any to a factor 20
LENGTHS = (0.3, 1.0, 3.0)  # [lives] in which a slope is forgotten: a rise may turn within a life, or last
FREE = 1.0  # [-] deviation of the level from its first sample, hundreds of times what the noise of one may be
DIFFER = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)  # [-] deviation of ln q from facet to facet
SPREADS = (0.0, 2.0, 8.0, 32.0)  # [facets] over which ratios are alike; 0: each facet by itself
DRIFTS = (0.0, 0.3, 1.0, 3.0)  # [1/life] slope of ln q over its own deviation
EXACT = 1e-5  # [-] noise below which a rate is known
FINE, COARSE = np.linspace(0.0, 2.0, 81), np.linspace(0.0, 2.0, 17)  # [lives] where ln r and ln q are drawn


@dataclass(frozen=True)
class Course:
    """A prior for ln r over the depth u, in lives: a level, and a slope that is forgotten exponentially.

        cov(ln r(u), ln r(v)) = level^2 + slope^2 l (2 min(u,v) - l (1 - e^(-u/l) - e^(-v/l) + e^(-|u-v|/l)))

    with l the length: twice the integral of the slope's covariance slope^2 exp(-|u-v|/l).

    **Source** the integrated Ornstein-Uhlenbeck process: J. M. G. Taylor, W. G. Cumberland and J. P. Sy, J. Am. Stat. Assoc. 89 (1994)
    727-736.
    """

    level: float  # [-]
    slope: float  # [-] of ln r over a life
    length: float  # [lives]

    def covariance(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(n, m) between the depths u (n,) and v (m,)"""
        u, v, length = u[:, None], v[None, :], self.length
        remembered = 1.0 - np.exp(-u / length) - np.exp(-v / length) + np.exp(-np.abs(u - v) / length)
        return self.level**2 + self.slope**2 * length * (2.0 * np.minimum(u, v) - length * remembered)


@dataclass(frozen=True)
class Draws:
    """Courses drawn over depths: their mean, and how far each goes off it for want of samples and for their noise."""

    at: np.ndarray  # (g,) [lives] depths, from 0; beyond the last, rates stay
    mean: np.ndarray  # (d, g, k)
    unseen: np.ndarray  # (d, g, k) what the rates may do where they were not sampled
    noise: np.ndarray  # (d, g, k) what the samples may be off by

    @classmethod
    def of(cls, course: Course, scale: np.ndarray, u: np.ndarray, value: np.ndarray, variance: np.ndarray,
           at: np.ndarray, random: np.random.Generator, count: int) -> "Draws":  # fmt: skip
        """Draws of independent quantities k of one kind of course, each with the prior's covariance times its scale.

        With K the covariance at the samples, k that of the grid with them, N their noise and G = k (K + N)^-1: a course drawn from the
        prior, x at the samples and x* on the grid, and noise e make the draw G y + (x* - G x) + G e.

        **Source** Matheron's rule: J. T. Wilson et al., J. Mach. Learn. Res. 22 (2021) 105.
        """
        both = np.concatenate([at, u])
        prior = course.covariance(both, both)
        grid, seen = slice(len(at)), slice(len(at), None)
        back = scale[:, None, None] * prior[seen, grid]
        gain = np.linalg.solve(scale[:, None, None] * prior[seen, seen] + np.diag(variance), back).swapaxes(
            1, 2
        )
        size, vector = np.linalg.eigh(prior)
        root = vector * np.sqrt(np.maximum(size, 0.0))
        free = np.sqrt(scale)[:, None, None] * (root @ random.normal(size=(len(scale), len(both), count)))
        off = np.sqrt(variance)[:, None] * random.normal(size=(len(scale), len(u), count))
        mean = np.einsum("kgn,nk->gk", gain, value)
        unseen, noise = free[:, grid] - gain @ free[:, seen], gain @ off
        return cls(at, np.broadcast_to(mean, (count, *mean.shape)), _by_draw(unseen), _by_draw(noise))

    @classmethod
    def together(cls, parts: "Sequence[Draws]", random: np.random.Generator) -> "Draws":
        """Draws of several kinds, mixed"""
        mixed = random.permutation(sum(len(part.mean) for part in parts))
        return cls(
            parts[0].at,
            *(
                np.concatenate([getattr(part, name) for part in parts])[mixed]
                for name in ("mean", "unseen", "noise")
            ),
        )

    def value(self, *, unseen: bool, noise: bool) -> np.ndarray:
        """(d, g, k) with or without each source of doubt"""
        return self.mean + unseen * self.unseen + noise * self.noise


def _by_draw(value: np.ndarray) -> np.ndarray:
    """(k, g, d) -> (d, g, k)"""
    return value.transpose(2, 1, 0)


def zone_courses(
    u: np.ndarray,
    value: np.ndarray,
    variance: np.ndarray,
    freedom: float,
    random: np.random.Generator,
    count: int,
) -> Draws:
    """Draws of ln r of a zone, over `FINE`; k = 1.

    Parameters
    ----------
    u
        (n,) [lives] depth of the zone at each sample.
    value, variance
        (n,) [-] ln r of each sample, and its variance by sampling.
    freedom
        [-] independent blocks behind that variance, which is itself drawn from them (scaled inverse chi-squared).
    random, count
        What to draw with, and how often.
    """
    variance, level = np.maximum(variance, EXACT**2), value[0]
    changes = [Course(FREE, slope, length) for slope, length in product(SLOPES, LENGTHS)]
    courses = [Course(FREE, 0.0, 1.0), *changes]
    before = np.log([STAYS, *[(1.0 - STAYS) / len(changes)] * len(changes)])
    told = before + [_evidence(course.covariance(u, u), value - level, variance) for course in courses]
    one, y = np.ones(1), (value - level)[:, None]
    draws = Draws.together(
        [
            Draws.of(courses[number], one, u, y, variance, FINE, random, times)
            for number, times in _shared_out(told, random, count)
        ],
        random,
    )
    doubt = np.sqrt(freedom / random.chisquare(freedom, size=(count, 1, 1)))
    return replace(draws, mean=draws.mean + level, noise=draws.noise * doubt)


def ratio_courses(
    u: np.ndarray,
    value: np.ndarray,
    window: np.ndarray,
    density: np.ndarray,
    place: np.ndarray,
    random: np.random.Generator,
    count: int,
) -> Draws:
    """Draws of ln q, the logarithms of the rates of facets k over the zone's, over `COARSE`.

    The prior is a level and a drift that are alike over a distance L,

        cov(ln q(u, x), ln q(v, y)) = differ^2 exp(-|x - y| / L) c(u, v),        c a `Course` of level 1

    and the noise of sample i is density / window_i. Both are products of space and time, so both are diagonal in the same modes of
    space: each mode is a course of its own.

    Parameters
    ----------
    u, window
        (n,) [lives] and [s] of each sample.
    value
        (n, k) [-] ln q as sampled.
    density
        (k, k) [s] of its noise.
    place
        (k, 3) [facets] of the facets' centres, in lengths of a facet.
    random, count
        What to draw with, and how often.
    """
    facets, root = len(place), np.sqrt(window)[:, None]
    density = density + EXACT**2 * window.mean() * np.eye(facets)
    apart = np.linalg.norm(place[:, None] - place[None, :], axis=2)
    told, way = [], []
    for spread in SPREADS:
        alike = np.exp(-apart / spread) if spread else np.eye(facets)
        signal, mode = eigh(alike, density)  # mode' alike mode = diag(signal), mode' density mode = 1
        for drift in DRIFTS:
            course = Course(1.0, drift, 1.0)
            memory, turned = np.linalg.eigh(root * course.covariance(u, u) * root.T)
            seen = turned.T @ (root * value) @ mode
            for differ in DIFFER:
                strength = 1.0 + differ**2 * np.outer(memory, signal)
                told.append(-0.5 * float((np.square(seen) / strength + np.log(strength)).sum()))
                way.append((course, differ**2 * signal, mode))
    found = []
    for number, times in _shared_out(told, random, count):
        course, scale, mode = way[number]
        draws = Draws.of(course, scale, u, value @ mode, 1.0 / window, COARSE, random, times)
        back = (density @ mode).T
        found.append(Draws(COARSE, draws.mean @ back, draws.unseen @ back, draws.noise @ back))
    return Draws.together(found, random)


def _evidence(prior: np.ndarray, value: np.ndarray, variance: np.ndarray) -> float:
    """Log probability of the samples, up to a constant"""
    root = np.linalg.cholesky(prior + np.diag(variance))
    return -0.5 * float(np.square(np.linalg.solve(root, value)).sum()) - float(np.log(np.diag(root)).sum())


def _shared_out(
    told: Sequence[float] | np.ndarray, random: np.random.Generator, count: int
) -> Iterator[tuple[int, int]]:
    """How many of the draws fall to each candidate, by its evidence"""
    weight = np.exp(np.asarray(told) - max(told))
    for number, times in enumerate(random.multinomial(count, weight / weight.sum())):
        if times:
            yield number, int(times)


@dataclass(frozen=True)
class Noise:
    """What the blocks of all samples say of the noise of a zone: relative variances times window."""

    zone: float  # [s] of the zone's rate
    ratio: np.ndarray  # (k, k) [s] of the ratios of its facets to it
    freedom: float  # [-] independent blocks in all samples, less one for each

    @classmethod
    def seen_in(cls, samples: Sequence[Sample], facet: np.ndarray, weight: np.ndarray) -> "Noise":
        """The noise of facets (k,) whose rates, times the weights (k,), make the zone's.

        With no more blocks than facets a covariance is mostly chance; its correlations are shrunk by the part of them that is.

        **Source** J. Schafer and K. Strimmer, Stat. Appl. Genet. Mol. Biol. 4 (2005) 32, for the shrinkage.
        """
        together = [sample.rate[:, facet] @ weight / (sample.mean[facet] @ weight) for sample in samples]
        apart = [
            sample.rate[:, facet] / np.where(sample.mean[facet] > 0.0, sample.mean[facet], 1.0) - one[:, None]
            for sample, one in zip(samples, together, strict=True)
        ]
        # one short series hides its memory, and now and then tells it many times too long: all of them together do not
        memory = inefficiency([lag_products(one[:, None]) for one in together])
        memory_apart = inefficiency([lag_products(others) for others in apart])
        zone, ratio, freedom = 0.0, np.zeros((len(facet), len(facet))), 0.0
        whole = sum(sample.window for sample in samples)
        for sample, one, others in zip(samples, together, apart, strict=True):
            blocks, share = len(one), sample.window**2 / whole
            zone += share * memory / (blocks - memory) * float(one.var())
            ratio += share * memory_apart / (blocks - memory_apart) * (others.T @ others) / blocks
            freedom += blocks / memory - 1.0
        return cls(zone, _shrunk(ratio, freedom), max(freedom, 1.0))


def _shrunk(covariance: np.ndarray, freedom: float) -> np.ndarray:
    """The covariance with its correlations shrunk towards none by the part of their squares that is chance"""
    size = np.sqrt(np.diag(covariance))
    correlation = np.divide(
        covariance, np.outer(size, size), out=np.eye(len(size)), where=np.outer(size, size) > 0.0
    )
    off = correlation[~np.eye(len(size), dtype=bool)]
    chance = float(np.square(1.0 - np.square(off)).sum()) / freedom
    part = min(chance / max(float(np.square(off).sum()), chance, 1e-300), 1.0)
    np.fill_diagonal(correlation, 1.0)
    return covariance * np.where(np.eye(len(size), dtype=bool), 1.0, 1.0 - part)
