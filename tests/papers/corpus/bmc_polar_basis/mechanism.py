"""A particle in space, and a basis that turns about the third axis with the direction of the
particle.
"""

from sympy import atan2, sqrt

from derive import Mechanism

m = Mechanism("polar_basis", spatial=True)
x, y, z = (m.coordinate(axis, "m", f"place of the particle, {axis}") for axis in "xyz")
polar = m.frame("polar", atan2(y, x))
m.name_("R", "m", "distance from the third axis", sqrt(x**2 + y**2))
m.name_("theta", "rad", "direction, from the first axis to the second", atan2(y, x))
P = m.point("P", m.O, m.world, x, y, z)
flat = m.point("flat", m.O, m.world, x, y)
