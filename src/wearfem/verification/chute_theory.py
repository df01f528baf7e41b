"""A thin stream of bulk material down a curved chute: its speed and the sliding wear below it, in closed form.

The stream moves along an arc of radius R, at the angle theta from the horizontal through the centre: theta = 0 where it falls straight
down, 90 degrees at the bottom. Along the arc gravity pulls with g cos(theta), into the chute with g sin(theta); the chute presses with

    N / m = v^2 / R + g sin(theta)

and holds back by mu_e times that. So with v dv = a R dtheta

    d(v^2)/dtheta = 2 g R (cos(theta) - mu_e sin(theta)) - 2 mu_e v^2

    v^2 = 2 g R / (4 mu_e^2 + 1) [(1 - 2 mu_e^2) sin(theta) + 3 mu_e cos(theta)] + K exp(-2 mu_e theta)

**Source** A. W. Roberts, Chem. Eng. Technol. 26 (2003) 163-170. G. Chen, D. L. Schott and G. Lodewijks, Numerical prediction on abrasive
wear reduction of bulk solids handling equipment using bionic design, eq. 3-11: their eq. 9 as printed lacks `+ 3 mu_e cos(theta)`,
their eq. 11 has it. With it their numbers give 1.69e-10 m3/s, as they print (1.68e-10); without it 0.90e-10.
"""

import numpy as np
from scipy.integrate import quad

GRAVITY = 9.81  # [m/s2]


def speed(angle: float, friction: float, radius: float, start_angle: float, start_speed: float) -> float:
    """Speed [m/s] of the stream at `angle` [rad] that had `start_speed` [m/s] at `start_angle` [rad].

    Parameters
    ----------
    friction
        mu_e [-]: what holds the stream back over what it presses with.
    radius
        R [m] of the path of the stream's centre of mass.

    Raises
    ------
    ValueError
        where the stream has come to rest before.
    """
    factor = 2.0 * GRAVITY * radius / (4.0 * friction**2 + 1.0)

    def steady(theta: float) -> float:
        return factor * (
            (1.0 - 2.0 * friction**2) * float(np.sin(theta)) + 3.0 * friction * float(np.cos(theta))
        )

    left = (start_speed**2 - steady(start_angle)) * float(np.exp(-2.0 * friction * (angle - start_angle)))
    square = steady(angle) + left
    if square < 0.0:
        raise ValueError(f"the stream comes to rest before {np.degrees(angle):.4g} degrees")
    return float(np.sqrt(square))


def normal_force(
    begin: float,
    end: float,
    *,
    friction: float,
    radius: float,
    start_angle: float,
    start_speed: float,
    mass_rate: float,
) -> float:
    """Force [N] with which a stream of q = `mass_rate` [kg/s] presses between two angles [rad], by quadrature.

    A length R dtheta holds the mass q R dtheta / v, so the force is q times the integral of (v + g R sin(theta) / v) dtheta.
    Parameters are those of `speed`.
    """

    def pressing(theta: float) -> float:
        v = speed(theta, friction, radius, start_angle, start_speed)
        return v + GRAVITY * radius * float(np.sin(theta)) / v

    return mass_rate * float(quad(pressing, begin, end)[0])


def wear_rate(
    begin: float,
    end: float,
    *,
    friction: float,
    radius: float,
    start_angle: float,
    start_speed: float,
    mass_rate: float,
    specific_wear_rate: float,
) -> float:
    """Volume [m3/s] that a stream wears off between two angles [rad]: k q times the integral of (v^2 + g R sin(theta)) dtheta.

    What presses slides with the speed of the stream: a stream that moves as a block. By quadrature.

    Parameters
    ----------
    friction, radius, start_angle, start_speed
        As for `speed`.
    mass_rate
        q [kg/s] of the stream.
    specific_wear_rate
        k [m2/N]: volume worn off by a unit of normal force over a unit of sliding.
    """

    def power(theta: float) -> float:
        return speed(theta, friction, radius, start_angle, start_speed) ** 2 + GRAVITY * radius * float(
            np.sin(theta)
        )

    return specific_wear_rate * mass_rate * float(quad(power, begin, end)[0])
