"""A pinion that presses: a rack in a guide, pushed up against a constant force and its own weight."""

from sympy import oo

from derive import GearContact, Mechanism, Y, quantities

q = quantities("""
    phi   | rad   | pinion angle
    omega | r/min | pinion speed                | 60
    g     | m/s2  | free fall                   | 9.81
    r     | mm    | pitch radius of the pinion  | 30   | 20 50
    alpha | deg   | pressure angle of the teeth | 20
    m_r   | kg    | rack                        | 4
    F_p   | N     | force that is pressed against | 500
""")

m = Mechanism(
    "rack_press", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
travel = m.coordinate("s", "m", "travel of the rack, upwards", equals=q.r * q.phi)
pitch = m.point("pitch", m.O, m.world, q.r)
end = m.point("end", pitch, m.world, 0, travel)
pinion, rack = m.body("pinion", m.frame("pinion", q.phi)), m.body("rack", m.world, q.m_r, end)
m.pin("O", pinion, m.ground, m.O)
m.slide("guide", rack, m.ground, pitch, along=Y)
m.mesh("P", pinion, rack, GearContact(m.world, pitch, oo, q.alpha))
m.force("press", rack, end, m.vector(m.world, 0, -q.F_p))
m.motor("M_in", pinion, m.ground, m.O)
SYSTEM = m.system()
