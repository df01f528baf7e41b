"""Factors to SI: `900 * tonne / hour` is 250.0 kg/s, `3.5 * mm` is 0.0035 m.

Inside wearfem every number is in SI; these names are for cases and for `--set "throughput=900*tonne/hour"`.
"""

from math import pi

# Length [m]
um = 1e-6
"""Micrometre [m]."""
mm = 1e-3
"""Millimetre [m]."""
cm = 1e-2
"""Centimetre [m]."""
m = 1.0
"""Metre [m]."""
km = 1e3
"""Kilometre [m]."""

# Mass [kg]
gram = 1e-3
"""Gram [kg]."""
kg = 1.0
"""Kilogram [kg]."""
tonne = 1e3
"""Metric tonne [kg]."""
kilotonne = 1e6
"""Thousand metric tonnes [kg]."""
kt = kilotonne
"""Thousand metric tonnes, the tonnage book's unit [kg]."""

# Time [s]
millisecond = 1e-3
"""Millisecond [s]."""
second = 1.0
"""Second [s]."""
minute = 60.0
"""Minute [s]."""
hour = 3600.0
"""Hour [s]."""
day = 86400.0
"""Day of 24 hours [s]."""

# Angle [rad] and angular velocity [rad/s]
degree = pi / 180.0
"""Degree of arc [rad]."""
rpm = 2.0 * pi / 60.0
"""Revolution a minute, as an angular velocity [rad/s]."""

# Force [N], energy [J] and pressure [Pa]
newton = 1.0
"""Newton [N]."""
kN = 1e3
"""Kilonewton [N]."""
joule = 1.0
"""Joule [J]."""
Pa = 1.0
"""Pascal [Pa]."""
kPa = 1e3
"""Kilopascal [Pa]."""
MPa = 1e6
"""Megapascal [Pa]."""
GPa = 1e9
"""Gigapascal [Pa]."""

# Pure numbers [-]
percent = 1e-2
"""Hundredth part [-]."""
