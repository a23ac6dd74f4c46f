"""Compliant teeth that separate, against rigid teeth, conservation laws and the closed law of an
impact.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
import sympy as sp

from derive import GearContact, Mechanism, quantities
from derive.mechanics.statement import MechanismError
from planter.kernels import Array
from planter.mechanism.dynamics import MotionRun
from tests.support import own

GEARED_CRANK = """
from sympy import asin, sin
from derive import GearContact, Mechanism, quantities
q = quantities('''
    phi   | rad   | pinion         | 0
    omega | rad/s | its speed      | 100
    r     | m     | pinion         | 0.03
    R     | m     | wheel          | 0.06
    alpha | rad   | pressure angle | 0.35
    c     | m     | crank          | 0.02
    l     | m     | rod            | 0.12
    m_w   | kg    | wheel          | 1.5
    J     | kg m2 | wheel          | 2e-3
    m_s   | kg    | slider         | 0.8
    T     | N m   | load           | 12
    K     | N/m   | teeth          | 1e6
    C     | N s/m | their damping  | 800
''')
RIGID = True
m = Mechanism("own", q, angle=q.phi, speed=q.omega) if RIGID else Mechanism("own", q)
turned = q.phi if RIGID else q.omega * m.time
rigid = -turned * q.r / q.R
theta = rigid if RIGID else m.coordinate("theta", "rad", "wheel")
D = m.point("D", m.O, m.world, q.r + q.R)
wheel_frame, rod_frame = m.frame("wheel", theta), m.frame("rod", -asin(q.c / q.l * sin(theta)))
A = m.point("A", D, wheel_frame, q.c)
B = m.point("B", A, rod_frame, q.l)
pinion, wheel = m.body("pinion", m.frame("pinion", turned)), m.body("wheel", wheel_frame, q.m_w, D, q.J)
rod, slider = m.body("rod", rod_frame), m.body("slider", m.world, q.m_s, B)
m.pin("O", pinion, m.ground, m.O)
m.pin("D", wheel, m.ground, D)
m.pin("A", rod, wheel, A)
m.pin("B", slider, rod, B)
m.slide("guide", slider, m.ground, B)
m.torque("load", wheel, m.ground, q.T)
m.motor("M_in", pinion, m.ground, m.O)
teeth = GearContact(m.world, D, q.R, q.alpha)
if RIGID:
    m.mesh("P", pinion, wheel, teeth)
else:
    m.compliant_mesh("P", pinion, wheel, teeth, rigid - theta, lambda depth, rate: q.K * depth + q.C * rate)
    m.begin({m.rate(theta): -q.omega * q.r / q.R})
SYSTEM = m.system()
"""
LIMACON = """
from derive import GearContact, Mechanism, gear_pair, quantities, tangent_angle
q = quantities('''
    phi   | rad   | driver         | 0
    omega | rad/s | its speed      | 12
    l     | mm    | mean radius    | 20
    b     | mm    | swing          | 4
    alpha | deg   | pressure angle | 20
    m     | kg    | mate           | 1.8
    J     | kg m2 | mate           | 0.004
    T     | N m   | resistance     | 6
    K     | N/m   | teeth          | 5e6
    C     | N s/m | their damping  | 5600
''')
RIGID = True
m = Mechanism("own", q, angle=q.phi, speed=q.omega) if RIGID else Mechanism("own", q)
turned = q.phi if RIGID else q.omega * m.time
pair = gear_pair("limacon", -turned, l=q.l, b=q.b)
psi = m.coordinate("psi", "rad", "mate", **({"equals": pair.turned} if RIGID else {}))
D = m.point("D", m.O, m.world, pair.distance)
driver, mate = m.body("driver", m.frame("driver", turned)), m.body("mate", m.frame("mate", psi), q.m, D, q.J)
m.pin("O", driver, m.ground, m.O)
m.pin("D", mate, m.ground, D)
m.torque("resistance", mate, m.ground, q.T)
m.motor("M_in", driver, m.ground, m.O)
tangent = tangent_angle(m.motion, m.world, driver.frame, -turned, pair.radius, pair.slope)
teeth = GearContact(m.world, D, pair.distance - pair.radius, q.alpha, tangent=tangent)
if RIGID:
    m.mesh("P", driver, mate, teeth)
else:
    m.compliant_mesh("P", driver, mate, teeth, pair.turned - psi, lambda depth, rate: q.K * depth + q.C * rate)
    m.begin({m.rate(psi): -q.omega * 2 / 3})
SYSTEM = m.system()
"""
PAIR = """
from derive import GearContact, Mechanism, quantities
q = quantities('''
    r     | m     | pinion         | 0.03
    R     | m     | wheel          | 0.06
    alpha | rad   | pressure angle | 0.35
    m     | kg    | each gear      | 1
    J_1   | kg m2 | pinion         | 4e-4
    J_2   | kg m2 | wheel          | 3e-3
    j     | m     | backlash       | 1e-4
    K     | N/m   | teeth          | 1e6
    H     | s/m   | their damping  | 0
    w     | rad/s | pinion         | 10
''')
m = Mechanism("own", q)
a, b = m.coordinate("a", "rad", "pinion"), m.coordinate("b", "rad", "wheel")
D = m.point("D", m.O, m.world, q.r + q.R)
pinion = m.body("pinion", m.frame("pinion", a), q.m, m.O, q.J_1)
wheel = m.body("wheel", m.frame("wheel", b), q.m, D, q.J_2)
m.pin("O", pinion, m.ground, m.O)
m.pin("D", wheel, m.ground, D)
m.compliant_mesh(
    "P", pinion, wheel, GearContact(m.world, D, q.R, q.alpha), -a * q.r / q.R - b,
    lambda depth, rate: q.K * depth * (1 + q.H * rate), q.j,
)
m.begin({m.rate(a): q.w})
SYSTEM = m.system()
"""
FREE_LIMACON = """
from derive import GearContact, Mechanism, gear_pair, quantities, tangent_angle
q = quantities('''
    l     | mm    | mean radius    | 20
    b     | mm    | swing          | 4
    alpha | deg   | pressure angle | 20
    m     | kg    | each gear      | 1.8
    J_1   | kg m2 | driver         | 0.002
    J_2   | kg m2 | mate           | 0.004
    J_c   | kg m2 | carrier        | 0.01
    j     | mm    | backlash       | 0.4
    K     | N/m   | teeth          | 5e6
    w     | rad/s | driver         | 12
    w_c   | rad/s | carrier        | -5
''')
m = Mechanism("own", q)
c, phi, psi = (m.coordinate(name, "rad", name) for name in ("c", "phi", "psi"))
line = m.frame("line", c)
pair = gear_pair("limacon", c - phi, l=q.l, b=q.b)
D = m.point("D", m.O, line, pair.distance)
carrier = m.body("carrier", line, q.m, m.O, q.J_c)
driver = m.body("driver", m.frame("driver", phi), q.m, m.O, q.J_1)
mate = m.body("mate", m.frame("mate", psi), q.m, D, q.J_2)
m.pin("C", carrier, m.ground, m.O)
m.pin("O", driver, m.ground, m.O)
m.pin("D", mate, carrier, D)
tangent = tangent_angle(m.motion, line, driver.frame, c - phi, pair.radius, pair.slope)
teeth = GearContact(line, D, pair.distance - pair.radius, q.alpha, tangent=tangent)
m.compliant_mesh("P", driver, mate, teeth, pair.turned - (psi - c), lambda depth, rate: q.K * depth, q.j)
m.begin({m.rate(phi): q.w, m.rate(c): q.w_c})
SYSTEM = m.system()
"""
RADII, INERTIAS = np.array([0.03, 0.06]), np.array([4e-4, 3e-3])
APPROACH = 10 * 0.03 * np.cos(0.35)
"""Speed [m/s] of the flanks along the line of action at the start."""


def run_pair(damping: float, until: float) -> MotionRun:
    return own.dynamics(PAIR, "own", H_s_m=damping).run(np.linspace(0, until, 400), tolerance=1e-11)


def compute_energy(run: MotionRun, stiffness: float = 1e6) -> Array:
    """Return the kinetic energy (n,) of the gears and what their flanks store [J]."""
    gaps = np.array([run.results["gap_P_ahead"], run.results["gap_P_behind"]])
    energy: Array = run.results["kinetic"] + 0.5 * stiffness * (np.minimum(gaps, 0) ** 2).sum(
        axis=0
    )
    return energy


@pytest.mark.parametrize(
    ("statement", "forces", "speed", "stiffness", "damping"),
    [
        (GEARED_CRANK, ("F_Dx", "F_Dy", "F_Ox", "F_Oy", "F_Bx", "F_By", "F_NP"), 100, 5e5, 560),
        (LIMACON, ("F_Dx", "F_Dy", "F_Ox", "F_Oy", "F_NP"), 12, 5e6, 5600),
    ],
    ids=["geared crank", "limacon"],
)
def test_stiff_teeth_approach_rigid_ones_in_first_order(
    statement, forces, speed, stiffness, damping
):
    times = np.linspace(5, 12, 41) / speed
    rigid = own.evaluate_lane(own.file(statement, "own"), speed * times)
    largest = max(np.abs(rigid[name]).max() for name in forces)
    errors = []
    for factor in (1, 4):
        values = {"K_N_m": factor * stiffness, "C_N_s_m": np.sqrt(factor) * damping}
        motion = own.dynamics(statement.replace("RIGID = True", "RIGID = False"), "own", **values)
        run = motion.run(np.array([0, *times]), tolerance=1e-9)
        errors.append(
            max(np.abs(run.results[name][1:] - rigid[name]).max() for name in forces) / largest
        )
    assert errors[1] < 1e-3
    assert np.log(errors[0] / errors[1]) / np.log(4) == pytest.approx(1, abs=0.02)


def test_pair_without_damping_keeps_energy_and_momentum():
    run = run_pair(0, 0.01)
    assert len(run.events) >= 6
    assert {event.event for event in run.events} == {"teeth at P, ahead", "teeth at P, behind"}
    momentum = (INERTIAS / RADII * [1, -1]) @ run.states[2:]
    assert np.ptp(momentum) < 1e-9 * abs(momentum[0])
    energy = compute_energy(run)
    assert np.ptp(energy) < 1e-6 * energy[0]


def measure_free_drift(text: str, tolerance: float) -> float:
    """Return the largest change of the energy of gears on a free carrier, as a share of it."""
    run = own.dynamics(text, "own").run(np.linspace(0, 0.15, 200), tolerance)
    assert {event.event for event in run.events} == {"teeth at P, ahead", "teeth at P, behind"}
    energy = compute_energy(run, 5e6)
    return float(np.ptp(energy) / energy[0])


def test_noncircular_teeth_keep_energy_to_the_tolerance():
    assert measure_free_drift(FREE_LIMACON, 1e-8) < 1e-6
    assert measure_free_drift(FREE_LIMACON, 1e-10) < 1e-8


def test_force_of_the_pitch_point_alone_changes_energy(monkeypatch):
    monkeypatch.setattr("derive.mechanics.joints.slope_by_turning", lambda *_: sp.S.Zero)
    assert measure_free_drift(f"{FREE_LIMACON}# without the slope of the lever\n", 1e-8) > 1e-3


@pytest.mark.parametrize("damping", [0.1, 0.5])
def test_impact_has_the_restitution_of_its_damping(damping):
    run = run_pair(damping, 0.003)
    closing, opening = run.events[:2]
    assert closing.time == pytest.approx(0.5e-4 / APPROACH, rel=1e-9)
    assert (closing.rising, opening.rising) == (False, True)
    after = run.states[2:, np.searchsorted(run.times, opening.time) + 1]
    separation = -np.cos(0.35) * (RADII @ after)

    def impact_residual(speed: float) -> float:
        before, behind = damping * APPROACH, -damping * speed
        return float((before - np.log1p(before)) - (behind - np.log1p(behind)))

    expected = scipy.optimize.brentq(
        impact_residual, 1e-6, min(APPROACH, (1 - 1e-9) / damping), xtol=1e-14
    )
    assert separation == pytest.approx(expected, rel=1e-6)
    assert np.diff(compute_energy(run)).max() < 1e-9


def test_damping_of_the_wrong_sign_adds_energy():
    energy = compute_energy(run_pair(-0.1, 0.003))
    assert energy[-1] > 1.01 * energy[0]


def test_compliant_rack_is_refused():
    q = quantities("s | m | play | 0\nK | N/m | stiffness | 1e6")
    m = Mechanism("rack", q)
    body = m.body("gear", m.world)
    with pytest.raises(MechanismError, match="rack"):
        m.compliant_mesh(
            "P",
            body,
            m.ground,
            GearContact(m.world, m.O, sp.oo, sp.Rational(1, 3)),
            q.s,
            lambda d, _: d,
        )


def test_lag_against_another_frame_is_refused():
    text = FREE_LIMACON.replace("pair.turned - (psi - c)", "pair.turned - psi")
    with pytest.raises(MechanismError, match="lag changes with c_dot"):
        exec(text, {})
