"""A row of N four-bars that passes singular poses (IFToMM library of computational benchmarks,
A02).

M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, "A benchmarking system for MBS simulation software",
Multibody Syst. Dyn. 16 (2006) 179-190. Whenever all bars lie in line, the mechanism has N + 1
degrees of freedom for an instant. The place of B0 at 10 s for N = 2: J. Gerstmayr's Exudyn, example
fourBarMechanismIftomm, by steps of 0.25 and 0.125 ms, of second order, carried to the limit.
"""

import numpy as np
import pytest

from tests.support import own

BARS = '''
from sympy import pi

from derive import Mechanism, quantities

N = COUNT
q = quantities("""
    g | m/s2 | free fall          | 9.81
    l | m    | bars               | 1
    m | kg   | each bar           | 1
    v | m/s  | speed of B0, start | 1
""")
m = Mechanism("bars", q, gravity=q.g)
ups = [m.coordinate(f"a{i}", "rad", f"upright {i}") for i in range(N + 1)]
overs = [m.coordinate(f"b{i}", "rad", f"coupler {i}") for i in range(N)]
feet = [m.point(f"A{i}", m.O, m.world, i * q.l) for i in range(N + 1)]
uprights = [m.frame(f"upright {i}", a) for i, a in enumerate(ups)]
couplers = [m.frame(f"coupler {i}", b) for i, b in enumerate(overs)]
tops = [m.point(f"B{i}", foot, frame, q.l) for i, (foot, frame) in enumerate(zip(feet, uprights))]
for i, (base, frame) in enumerate(zip([*feet, *tops], [*uprights, *couplers])):
    m.body(f"bar {i}", frame, q.m, m.point(f"C{i}", base, frame, q.l / 2), q.m * q.l**2 / 12)
for i in range(N):
    m.close(tops[i + 1], m.point(f"E{i}", tops[i], couplers[i], q.l), start={ups[i]: pi / 2, ups[i + 1]: pi / 2})
m.begin({m.motion.rates[a]: -q.v / q.l for a in ups})
for axis, place in zip("xy", m.position(tops[0]).components):
    m.report(f"B0{axis}", "m", f"end of the first upright, {axis}", place)
SYSTEM = m.system(reported=["kinetic", "potential", "B0x", "B0y"])
'''
COARSE, FINE = np.array([0.3284552113, 0.9445195467]), np.array([0.3284573768, 0.9445187937])
END = FINE + (FINE - COARSE) / 3


@pytest.mark.parametrize(
    ("tolerance", "drift", "distance"),
    [(1e-8, 1e-6, 1e-6), pytest.param(1e-10, 1e-8, 2e-8, marks=pytest.mark.long)],
)
def test_two_windows_fall_through_their_singular_poses(
    tolerance: float, drift: float, distance: float
) -> None:
    run = own.dynamics(BARS.replace("COUNT", "2"), "bars").run(np.linspace(0, 10, 101), tolerance)
    energy = run.results["kinetic"] + run.results["potential"]
    assert own.deviation("energy, N = 2", energy / energy[0], 1) < drift
    assert (
        own.deviation("B0 at 10 s", [run.results["B0x"][-1], run.results["B0y"][-1]], END)
        < distance
    )
    assert own.deviation("uprights", run.states[0], run.states[2]) < 1e-6


@pytest.mark.long
def test_forty_windows_fall_through_the_first() -> None:
    """81 bars; 41 degrees of freedom for the instant in which all lie in line."""
    run = own.dynamics(BARS.replace("COUNT", "40"), "bars").run(np.linspace(0, 1, 11), 1e-7)
    energy = run.results["kinetic"] + run.results["potential"]
    assert run.states[0, 0] > 0 > run.states[0, -1]
    assert own.deviation("energy, N = 40", energy / energy[0], 1) < 1e-6
    assert own.deviation("uprights", run.states[:41], run.states[:1]) < 1e-6
