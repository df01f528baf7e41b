"""A simply supported square plate under even pressure as a body in three dimensions: what thick solids are measured against."""

import math

import numpy as np
from scipy.linalg import expm


def supported_block(
    side: float,
    thickness: float,
    shear_modulus: float,
    poisson_ratio: float,
    pressure: float,
    terms: int = 19,
) -> tuple[float, float]:
    """Deflection [m] of the middle surface and largest tension [Pa], both in the centre of the plate, exact but for the terms left out.

    The edges neither sink nor move along themselves, and are free of normal stress; pressure is on the top. With u = U(z) cos ax sin by,
    v = V(z) sin ax cos by, w = W(z) sin ax sin by, and tractions X, Y, S on planes z = const of the same shapes, Hooke's law and
    equilibrium are six linear equations of first order in z for each pair a = m pi / side, b = n pi / side with m, n odd.

    **Source** the method of initial functions, after S. Srinivas and A. K. Rao, Bending, vibration and buckling of simply supported thick
    orthotropic rectangular plates and laminates, Int. J. Solids Structures 6 (1970) 1463-1481. **Valid for** thickness x terms below
    some 5 sides: beyond, the exponentials outgrow the digits.
    """
    g, lame = shear_modulus, 2.0 * shear_modulus * poisson_ratio / (1.0 - 2.0 * poisson_ratio)
    stiff = lame + 2.0 * g
    deflection = tension = 0.0
    for m in range(1, terms + 1, 2):
        for n in range(1, terms + 1, 2):
            a, b = m * math.pi / side, n * math.pi / side
            swelling = np.array([lame * a, lame * b, 0, 0, 0, 1]) / stiff  # W'
            along = np.array([-stiff * a, -lame * b, 0, 0, 0, 0]) + lame * swelling  # sigma_xx
            across = np.array([-lame * a, -stiff * b, 0, 0, 0, 0]) + lame * swelling  # sigma_yy
            twist = np.array([g * b, g * a, 0, 0, 0, 0])  # sigma_xy
            rate = np.array(
                [
                    [0, 0, -a, 1 / g, 0, 0],
                    [0, 0, -b, 0, 1 / g, 0],
                    swelling,
                    b * twist - a * along,
                    a * twist - b * across,
                    [0, 0, 0, a, b, 0],
                ]
            )
            scale = np.array([1, 1, 1, g / side, g / side, g / side])  # so that the six are of one size
            half = expm(0.5 * thickness * rate * scale / scale[:, None])
            whole = half @ half
            load = -16.0 * pressure / (math.pi**2 * m * n) / scale[5]
            below = np.zeros(6)
            below[:3] = np.linalg.solve(whole[3:, :3], [0.0, 0.0, load])
            sign = math.sin(0.5 * m * math.pi) * math.sin(0.5 * n * math.pi)
            deflection -= sign * (half @ below)[2]
            tension += sign * float(along @ (below * scale))
    return float(deflection), tension
