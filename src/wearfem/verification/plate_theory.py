"""Square plates under even pressure by Mindlin's theory, solved without finite elements: what shells are measured against."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

SHEAR_CORRECTION = 5.0 / 6.0


@dataclass(frozen=True)
class Plate:
    """A square plate under an even pressure."""

    side: float  # [m]
    thickness: float  # [m]
    young_modulus: float  # [Pa]
    poisson_ratio: float  # [-]
    pressure: float  # [Pa]

    @property
    def bending_stiffness(self) -> float:
        """D = E h^3 / 12 (1 - nu^2) [N m]"""
        return self.young_modulus * self.thickness**3 / (12.0 * (1.0 - self.poisson_ratio**2))

    @property
    def shear_stiffness(self) -> float:
        """kappa G h [N/m]"""
        return SHEAR_CORRECTION * self.young_modulus / (2.0 + 2.0 * self.poisson_ratio) * self.thickness


def supported_plate(plate: Plate, terms: int = 401) -> tuple[float, float]:
    """Deflection [m] and moment [N] at the centre of a plate whose edges neither sink nor twist (hard simple support).

    w = sum 16 q / (pi^2 m n) (1 / (D k^4) + 1 / (kappa G h k^2)) sin sin,  k^2 = pi^2 (m^2 + n^2) / a^2, m and n odd

    **Source** Navier's series (Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 1959, art. 30); the shear term follows
    as each sine satisfies Mindlin's equations.
    """
    m = np.arange(1, terms + 1, 2)
    sign = (-1.0) ** ((m - 1) // 2)
    load = 16.0 * plate.pressure / math.pi**2 * np.outer(sign / m, sign / m)
    along = (math.pi * m / plate.side) ** 2
    square = along[:, None] + along
    deflection = load * (1.0 / (plate.bending_stiffness * square**2) + 1.0 / (plate.shear_stiffness * square))
    moment = load * (along[:, None] + plate.poisson_ratio * along) / square**2
    return float(deflection.sum()), float(moment.sum())


def clamped_plate(plate: Plate, functions: int = 14) -> float:
    """Deflection [m] at the centre of a plate with clamped edges, by Ritz's method on Mindlin's energy.

    Deflection and both rotations are sums of products of integrated Legendre polynomials, `functions` of the right symmetry in each
    direction. **Valid for** h/a of 0.01 and more; for thin plates it tends to 0.00126532 q a^4 / D (R. L. Taylor and S. Govindjee,
    Solution of clamped rectangular plate problems, Commun. Numer. Methods Eng. 20 (2004) 757-765).
    """
    count = 2 * functions
    x, weight = legendre.leggauss(count + 8)
    value, slope = np.empty((count, len(x))), np.empty((count, len(x)))
    centre = np.empty(count)
    for k in range(count):  # N_k = (P_k+2 - P_k) / sqrt(4 k + 6), zero at both ends
        series = np.zeros(k + 3)
        series[k], series[k + 2] = -1.0, 1.0
        series /= math.sqrt(4.0 * k + 6.0)
        value[k], slope[k] = legendre.legval(x, series), legendre.legval(x, legendre.legder(series))
        centre[k] = legendre.legval(0.0, series)
    even, odd = slice(0, None, 2), slice(1, None, 2)

    def inner(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return (first * weight) @ second.T

    half = 0.5 * plate.side  # x = half * xi: slopes gain 1 / half, areas half^2
    v, s = value, slope / half
    d, g, nu = plate.bending_stiffness, plate.shear_stiffness, plate.poisson_ratio
    twist = 0.5 * (1.0 - nu)
    # unknowns: w even-even, beta_x odd-even, beta_y even-odd
    ww = np.kron(inner(s[even], s[even]), inner(v[even], v[even]))
    ww = g * (ww + np.kron(inner(v[even], v[even]), inner(s[even], s[even])))
    wx = g * np.kron(inner(s[even], v[odd]), inner(v[even], v[even]))
    wy = g * np.kron(inner(v[even], v[even]), inner(s[even], v[odd]))
    vv_odd, vv_even = inner(v[odd], v[odd]), inner(v[even], v[even])
    ss_odd, ss_even = inner(s[odd], s[odd]), inner(s[even], s[even])
    xx = d * (np.kron(ss_odd, vv_even) + twist * np.kron(vv_odd, ss_even)) + g * np.kron(vv_odd, vv_even)
    yy = d * (np.kron(vv_even, ss_odd) + twist * np.kron(ss_even, vv_odd)) + g * np.kron(vv_even, vv_odd)
    xy = d * nu * np.kron(inner(s[odd], v[even]), inner(v[even], s[odd]))
    xy += d * twist * np.kron(inner(v[odd], s[even]), inner(s[even], v[odd]))
    energy = np.block([[ww, wx, wy], [wx.T, xx, xy], [wy.T, xy.T, yy]])
    one = value[even] @ weight
    load = np.zeros(len(energy))
    load[: functions**2] = plate.pressure * np.kron(one, one)
    size = 1.0 / np.sqrt(np.diag(energy))
    answer = size * np.linalg.solve(energy * np.outer(size, size), load * size)
    return float(answer[: functions**2] @ np.kron(centre[even], centre[even]))


def supported_frequency(plate: Plate, density: float) -> float:
    """[Hz] lowest natural frequency of a simply supported plate by Mindlin's theory, with shear and rotary inertia.

    Its shape is sin sin with k^2 = 2 pi^2 / a^2; deflection and rotation are the two unknowns of
    ((kappa G h k^2, -kappa G h k), (-kappa G h k, D k^2 + kappa G h)) - omega^2 diag(rho h, rho h^3 / 12).

    **Source** Mindlin, J. Appl. Mech. 18 (1951) 31-38; thin: omega = 2 pi^2 / a^2 sqrt(D / rho h).
    """
    k = math.sqrt(2.0) * math.pi / plate.side
    shear, bending = plate.shear_stiffness, plate.bending_stiffness
    stiffness = np.array([[shear * k**2, -shear * k], [-shear * k, bending * k**2 + shear]])
    mass = np.array([density * plate.thickness, density * plate.thickness**3 / 12.0])
    square = np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass)))
    return float(np.sqrt(square[0])) / (2.0 * math.pi)


def clamped_frequency(plate: Plate, density: float) -> float:
    """[Hz] lowest natural frequency of a thin clamped plate: omega = 35.992 / a^2 sqrt(D / rho h).

    **Source** Leissa, J. Sound Vib. 31 (1973) 257-293, by Ritz's method, so an upper bound. **Valid for** thin plates.
    """
    speed = math.sqrt(plate.bending_stiffness / (density * plate.thickness))
    return 35.992 / plate.side**2 * speed / (2.0 * math.pi)
