"""By whose axes the actions of joints are told: those of the world, or those that the result
names.
"""

import numpy as np
import pytest

from planter.mechanism import presentation
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from planter.mechanism.motion import compute_motion
from tests.support import own

GYRO = '''
from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    phi   | rad   | turntable
    omega | rad/s | its speed          | 4
    m     | kg    | disc               | 2
    J     | kg m2 | disc, about axle   | 0.03
    Jt    | kg m2 | disc, across       | 0.017
    h     | mm    | disc, above ground | 150
    a     | mm    | disc, off the axis | 200
""")
m = Mechanism("gyro", q, angle=q.phi, speed=q.omega, spatial=True)
turned = m.frame("turned", q.phi, Z)
spinning = m.frame("spinning", 3 * q.phi, X, parent=turned)
P = m.point("P", m.O, turned, q.a, 0, q.h)
table = m.body("table", turned)
disc = m.body("disc", spinning, q.m, P, (q.J, q.Jt, q.Jt))
m.pin("O", table, m.ground, m.O, Z)
m.pin("P", disc, table, P, X)
m.motor("M_in", table, m.ground, m.O, Z)
m.motor("M_spin", disc, table, P, X)
SYSTEM = m.system()
'''
FALLING = '''
from derive import Mechanism, X, Z, quantities

q = quantities("""
    g | m/s2  | free fall | 9.81
    m | kg    | bob       | 2
    l | m     | rod       | 0.3
    J | kg m2 | bob       | 0.01
""")
m = Mechanism("falling", q, spatial=True, gravity=(0, 0, -q.g))
a, b = m.coordinate("a", "rad", "about the vertical"), m.coordinate("b", "rad", "about the arm")
arm = m.frame("arm", a, Z)
rod = m.frame("rod", b, X, parent=arm)
bar = m.body("bar", arm, inertia=0)
bob = m.body("bob", rod, q.m, m.point("C", m.O, rod, 0, 0, -q.l), (q.J, q.J, q.J))
m.pin("O", bar, m.ground, m.O, Z)
m.pin("A", bob, bar, m.O, X)
m.begin({b: 1, m.motion.rates[a]: 3})
SYSTEM = m.system()
'''


def test_gyroscopic_moment_by_axes_of_the_table_and_of_the_world() -> None:
    """Newton and Euler by hand: H = 3 J omega x + Jt omega z turns with the table, so its rate is 3
    J omega^2 y.
    """
    model = Model(own.machine(GYRO, "gyro"))
    phi = np.radians([0.0, 30.0, 100.0, 250.0])
    values, size, pull = model(phi), 3 * 0.03 * 4**2, 2 * 0.2 * 4**2
    assert values["M_Py"] == pytest.approx(np.full(4, size))
    assert values["M_Pz"] == pytest.approx(np.zeros(4), abs=1e-12)
    assert values["M_P_world_x"] == pytest.approx(-size * np.sin(phi), abs=1e-12)
    assert values["M_P_world_y"] == pytest.approx(size * np.cos(phi), abs=1e-12)
    assert values["F_Px"] == pytest.approx(
        -pull * np.cos(phi)
    )  # the world's, as the ground's moments are
    across = size - 0.15 * pull
    assert values["M_Ox"] == pytest.approx(-across * np.sin(phi), abs=1e-12)
    assert values["M_Oy"] == pytest.approx(across * np.cos(phi), abs=1e-12)
    assert "M_O_world_x" not in values


def test_results_name_the_axes() -> None:
    result = compute_cycle(Model(own.machine(GYRO, "gyro")), 8).result
    named = {
        key: quantity.axes
        for key, quantity in result.quantities.items()
        if quantity.axes is not None
    }
    assert named == {"M_Py_Nm": "turned", "M_Pz_Nm": "turned"}
    assert "axes" not in result.table()["quantities"]["F_Px_N"]
    assert presentation.format_unit(result.quantities["M_Py_Nm"]) == "N m, axes of turned"
    assert presentation.format_unit(result.quantities["F_Px_N"]) == "N"


def test_free_motion_names_the_axes_too() -> None:
    """The moments of the hinge are what turns the bob about the vertical: nothing else does."""
    moved = compute_motion(own.dynamics(FALLING, "falling"), 0.3, 31, 1e-10)
    quantities = moved.result.quantities
    assert {key for key, quantity in quantities.items() if quantity.axes == "arm"} == {
        "M_Ay_Nm",
        "M_Az_Nm",
    }
    angle = np.radians(moved.columns["a_deg"])
    across = moved.columns["M_Ay_Nm"]
    assert np.abs(moved.columns["M_A_world_x_Nm"] + across * np.sin(angle)).max() < 1e-9
    assert np.abs(moved.columns["M_A_world_y_Nm"] - across * np.cos(angle)).max() < 1e-9
    assert np.ptp(moved.columns["M_A_world_y_Nm"]) > 0.1
    assert (
        np.abs(moved.columns["M_A_world_z_Nm"]).max() < 1e-9
    )  # the bar has no inertia and its shaft is free
