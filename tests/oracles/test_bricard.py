"""Bricard's mechanism (IFToMM library of computational benchmarks, A04): five rods, six hinges,
held once too often.

M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, "A benchmarking system for MBS simulation software",
Multibody Syst. Dyn. 16 (2006) 179-190. Thin rods of 1 m and 1 kg from rest. The reference
trajectory is not in print; held here are the energy, and the turns of the hinges against the same
mechanism opened at another hinge.
"""

import numpy as np

from tests.support import own

HEAD = '''
from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    g | m/s2 | free fall | 9.81
    l | m    | rods      | 1
    m | kg   | each rod  | 1
""")
m = Mechanism("bricard", q, gravity=q.g, spatial=True)
WAYS = [(1, 0, 0), (0, -1, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0)]
CORNERS = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
AXES = [Y, Z, X, Y, Z, X]


def rod(i, frame, start, sign):
    """Rod i from its corner, or to it."""
    centre = m.point(f"C{i}", start, frame, *(sign * w * q.l / 2 for w in WAYS[i]))
    tensor = [0 if w else q.m * q.l**2 / 12 for w in WAYS[i]]
    end = m.point(f"P{i}_", start, frame, *(sign * w * q.l for w in WAYS[i]))
    return m.body(f"rod {i}", frame, q.m, centre, tensor), end


def run(rods, corner, sign):
    """Rods one after the other, each hinged at the corner where it begins."""
    frame, at, last = m.world, m.point(f"Q{corner}", m.O, m.world, *(c * q.l for c in CORNERS[corner])), m.ground
    for i in rods:
        hinge = i if sign > 0 else i + 1
        angle = m.coordinate(f"t{hinge}", "rad", f"hinge {hinge}")
        frame = m.frame(f"rod {i}", angle, AXES[hinge], frame)
        body, end = rod(i, frame, at, sign)
        m.pin(f"P{hinge}", body, last, at, axis=AXES[hinge])
        at, last = end, body
    return frame, at, last
'''
AT_THE_END = (
    HEAD
    + """
frame, end, last = run(range(5), 0, 1)
foot = m.point("foot", m.O, m.world, 0, 0, q.l)
m.close(end, foot, start={})
m.parallel("hinge5", (m.world, X), (frame, X), start={})
m.pin("P5", last, m.ground, foot, axis=X)
SYSTEM = m.system()
"""
)
IN_THE_MIDDLE = (
    HEAD
    + """
first, end, last = run([0, 1, 2], 0, 1)
second, other, held = run([4, 3], 5, -1)
m.close(end, other, start={})
m.parallel("hinge3", (first, Y), (second, Y), start={})
m.pin("P3", last, held, other, axis=Y)
SYSTEM = m.system()
"""
)
TIMES = np.linspace(0, 10, 101)


def test_redundant_constraint_is_reported_with_place() -> None:
    for text in (AT_THE_END, IN_THE_MIDDLE):
        dynamics = own.dynamics(text, "bricard")
        start = dynamics.start()
        assert dynamics.redundant(start) == 1
        print("follow from one another:", ", ".join(dynamics.dependent(start)))
        run = dynamics.run(np.linspace(0, 0.5, 6), 1e-9)
        print("held twice:", ", ".join(run.undetermined))
        assert run.undetermined
        assert not set(run.undetermined) & run.results.keys()
        motion = dynamics.run(np.linspace(0, 0.5, 6), 1e-9, minimum_norm=True)
        assert set(run.undetermined) <= motion.results.keys()


def test_energy_is_conserved_and_both_loop_cuts_agree() -> None:
    runs = [own.dynamics(text, "bricard").run(TIMES, 1e-10) for text in (AT_THE_END, IN_THE_MIDDLE)]
    for run in runs:
        total = run.results["kinetic"] + run.results["potential"]
        moved = np.ptp(run.results["kinetic"])
        assert moved > 1
        assert own.deviation("energy, over what moves", total / moved, total[0] / moved) < 1e-6
    for hinge in range(3):
        first, second = (np.unwrap(run.states[hinge]) for run in runs)
        assert own.deviation(f"hinge {hinge}", first, second) < 1e-6
