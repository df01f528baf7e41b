"""The words of the kernels: products of vectors given as scalars."""

import math

from wearfem.jit import inlined


@inlined
def dot(ax, ay, az, bx, by, bz):
    """a . b"""
    return ax * bx + ay * by + az * bz


@inlined
def cross(ax, ay, az, bx, by, bz):
    """a x b"""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@inlined
def norm(ax, ay, az):
    """|a|"""
    return math.sqrt(ax * ax + ay * ay + az * az)


@inlined
def tangent(ax, ay, az, nx, ny, nz):
    """The part of a across the unit vector n: a - (a . n) n"""
    along = ax * nx + ay * ny + az * nz
    return ax - along * nx, ay - along * ny, az - along * nz


ROUNDING = 1.5 * 2.0**52  # adding and subtracting it rounds a number below 2^51 to the nearest integer


@inlined
def nearest(x):
    """The integer nearest to x, by plain arithmetic so that loops over it vectorise."""
    return (x + ROUNDING) - ROUNDING
