"""A pair of gears whose pitch radius is a table of a CSV file: two lobes, and a mate that turns half as far.

The distance of the shafts follows from the table, so that the mate closes; the pair rolls exactly.
"""

from fractions import Fraction
from pathlib import Path

from derive import GearContact, Mechanism, quantities, read_gear_pair, tangent_angle

table = read_gear_pair(
    Path(__file__).with_name("measured_gears.csv"),
    "t | deg | polar angle\nr | mm | pitch radius",
    Fraction(1, 2),
)
q = quantities(f"""
    phi   | rad   | driver
    omega | r/min | its speed            | 90
    a     | m     | distance of the shafts | {table.distance} | 0.06 0.1
    alpha | deg   | pressure angle       | 20
    m     | kg    | mate, balanced       | 1.8
    J     | kg m2 | mate                 | 0.004
    M_r   | N m   | resistance at the mate | 6
""")
m = Mechanism("measured_gears", q, angle=q.phi, speed=q.omega, source="the example of the guide")
pair = table.pair(-q.phi, q.a)  # the contact passes over a gear against its turning
psi = m.coordinate("psi", "rad", "mate", equals=pair.turned)
centre = m.point("D", m.O, m.world, q.a)
driver, mate = (
    m.body("driver", m.frame("driver", q.phi)),
    m.body("mate", m.frame("mate", psi), q.m, centre, q.J),
)
m.pin("O", driver, m.ground, m.O)
m.pin("D", mate, m.ground, centre)
tangent = tangent_angle(m.motion, m.world, driver.frame, -q.phi, pair.radius, pair.slope)
m.mesh("P", driver, mate, GearContact(m.world, centre, q.a - pair.radius, q.alpha, tangent=tangent))
m.torque("resistance", mate, m.ground, q.M_r)
m.motor("M_in", driver, m.ground, m.O)
SYSTEM = m.system()
