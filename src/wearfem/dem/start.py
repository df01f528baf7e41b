"""What is refused before the first step: flows and models that cannot go well together."""

import numpy as np
from scipy.spatial import cKDTree

from wearfem.dem.flow import Flow, Model
from wearfem.dem.particles import Particles, spheres
from wearfem.errors import UserError


def check_start(flow: Flow, model: Model) -> None:
    """Refuse what cannot go well: numbers that are none, particles outside or inside one another, a time step too long.

    Raises
    ------
    UserError
        with the particle, the place and what to do.
    """
    particles = flow.particles
    if particles.count:
        _check_numbers(particles, model)
    _check_sizes(particles, model)
    if particles.count:
        _check_places(particles, model)
        if flow.pairs is None:
            _check_overlap(particles, model.period)


def _check_numbers(p: Particles, model: Model) -> None:
    """Refuse what is no number, no size or no material."""
    for what, array in (
        ("position", p.position),
        ("velocity", p.velocity),
        ("angular velocity", p.angular_velocity),
        ("applied force", p.applied_force),
        ("radius", p.radius),
        ("mass", p.mass),
    ):
        good = np.isfinite(array.reshape(len(array), -1)).all(axis=1)
        if not good.all():
            i = int(np.argmin(good))
            raise UserError(
                f"Particle {p.ident[i]}: its {what} is {array[i].tolist()}; it must be a finite number."
            )
    if not (p.radius > 0).all():
        raise UserError(
            f"Particle {p.ident[int(np.argmin(p.radius))]} has the radius {p.radius.min():g} m; it must be above 0."
        )
    if p.material.max(initial=0) >= len(model.materials):
        raise UserError(
            f"A particle has material {p.material.max()}, but materials are numbered 0 to {len(model.materials) - 1}."
        )


def _check_places(p: Particles, model: Model) -> None:
    """Refuse particles outside a domain that keeps them."""
    domain = model.domain
    fixed = ~np.asarray(domain.periodic)
    out = (((p.position < domain.low) | (p.position > domain.high)) & fixed).any(axis=1)
    if out.any() and not domain.outlet:
        i = int(np.argmax(out))
        raise UserError(
            f"Particle {p.ident[i]} starts outside the domain, at {p.position[i].tolist()} m; it runs from {domain.low} to "
            f"{domain.high} m."
        )


def _check_sizes(particles: Particles, model: Model) -> None:
    """Refuse sizes that time step, neighbour search or periodic width do not suit: of particles that are there, and of those to come."""
    inlets = [inlet for inlet in model.inlets if inlet.mass_rate > 0.0]
    density = np.array([material.density for material in model.materials])
    coming = [
        spheres(np.zeros((2, 3)), np.array([i.sizes.smallest, i.sizes.largest]), density[i.material], material=i.material)
        for i in inlets
        if 0 <= i.material < len(density)
    ]  # fmt: skip
    known = [group for group in (particles, *coming) if group.count]
    if not known:
        return
    smallest, largest = min(g.radius.min() for g in known), max(g.radius.max() for g in known)
    if largest > 255.0 * smallest:
        raise UserError(
            f"Radii run from {smallest:g} to {largest:g} m, a ratio above 255; drop the smallest or the largest."
        )
    limit = min(model.rayleigh_time(group) for group in known)
    if model.time_step > limit:
        raise UserError(
            f"The time step {model.time_step:g} s is over the stable limit, the Rayleigh time {limit:.4g} s of the smallest "
            f"particle; use {0.2 * limit:.2g} s (20 %) or lower the shear modulus."
        )
    narrow = (model.period > 0) & (model.period < 3.0 * 2.5 * largest)
    if narrow.any():
        raise UserError(
            f"The periodic width is {model.period[narrow].min():g} m; it must be at least {7.5 * largest:.4g} m, "
            "three particle diameters and a margin."
        )


def _check_overlap(p: Particles, period: np.ndarray) -> None:
    """Refuse particles that overlap by more than a twentieth of the smaller radius at the start."""
    low, high = p.position.min(axis=0), p.position.max(axis=0)
    box = np.where(period > 0, period, 2.0 * (high - low) + 10.0 * p.radius.max())
    tree = cKDTree((p.position - low) % box, boxsize=box)
    worst, names = 0.0, (0, 0)
    pairs = tree.query_pairs(2.0 * p.radius.max(), output_type="ndarray")
    if len(pairs):
        apart = p.position[pairs[:, 0]] - p.position[pairs[:, 1]]
        apart -= np.where(period > 0, period, 0.0) * np.round(apart / box)
        depth = p.radius[pairs].sum(axis=1) - np.linalg.norm(apart, axis=1)
        part = depth / p.radius[pairs].min(axis=1)
        worst, names = part.max(), tuple(p.ident[pairs[part.argmax()]])
    if worst > 0.05:
        raise UserError(
            f"Particles {names[0]} and {names[1]} overlap by {100 * worst:.3g} % of the smaller radius at the start; at most 5 % "
            "is allowed. Spread them out, or let them settle from a loose packing."
        )
