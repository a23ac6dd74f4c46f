"""The stiff flyball governor (IFToMM library of computational benchmarks, A05) against Pinocchio.

M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, "A benchmarking system for MBS simulation software",
Multibody Syst. Dyn. 16 (2006) 179-190; its numbers as in RehabEngGroup's MBSbenchmarksInOpenSim.
The reference trajectory is in print as a figure alone, so the slider's height is held against that
which the forward dynamics of Pinocchio (Carpentier et al., SII 2019) give to another integrator,
and the turning momentum against its start.
"""

import numpy as np
import pytest
import scipy.integrate

from tests.support import own

pin = pytest.importorskip("pinocchio")

GOVERNOR = '''
from sympy import pi

from derive import Mechanism, Y, Z, quantities

q = quantities("""
    g   | m/s2  | free fall                    | 9.81
    L   | m     | shaft and rods               | 1
    w   | m     | side of shaft and rods       | 0.01
    b   | m     | side of the slider           | 0.1
    m_r | kg    | shaft, rods                  | 0.3
    m_s | kg    | slider                       | 3
    m_b | kg    | balls                        | 5
    k   | N/m   | couplers                     | 800000
    c   | N s/m | couplers, damping            | 40000
    l_0 | m     | couplers without load        | 0.5
    s_0 | m     | slider at the start          | 0.5
    n   | rad/s | speed at the start           | 6.283185307179586
""")
m = Mechanism("governor", q, gravity=(0, 0, -q.g), spatial=True)
turn, s = m.coordinate("turn", "rad", "shaft"), m.coordinate("s", "m", "slider's height")
shaft, slim = m.frame("shaft", turn, Z), q.m_r * q.w**2 / 6
thin = q.m_r * (q.L**2 + q.w**2) / 12
m.body("shaft", shaft, q.m_r, m.point("C", m.O, m.world, 0, 0, q.L / 2), (thin, thin, slim))
middle = m.point("S", m.O, m.world, 0, 0, s)
slider = m.body("slider", shaft, q.m_s, middle, (q.m_s * q.b**2 / 6,) * 3)
for i, side in enumerate((1, -1)):
    drop = m.coordinate(f"drop{i}", "rad", f"rod {i} below the horizontal")
    frame = m.frame(f"rod {i}", side * drop, Y, shaft)
    hinge = m.point(f"A{i}", m.O, shaft, side * q.b / 2, 0, q.L)
    centre = m.point(f"B{i}", hinge, frame, side * q.L / 2)
    rod = m.body(f"rod {i}", frame, q.m_r, centre, (slim, thin, thin))
    m.body(f"ball {i}", frame, q.m_b, m.point(f"P{i}", hinge, frame, side * q.L))
    m.spring(f"coupler{i}", rod, slider, (centre, m.point(f"E{i}", middle, shaft, side * q.b / 2)), q.k, q.l_0, q.c)
    m.begin({drop: pi / 6})
m.begin({s: q.s_0, m.motion.rates[turn]: q.n})
SYSTEM = m.system(reported=["kinetic", "potential"])
'''
L, W, B, STIFFNESS, DAMPING, FREE = 1.0, 0.01, 0.1, 8e5, 4e4, 0.5
TIMES = np.linspace(0, 10, 101)


class Engine:
    """The governor as a tree of Pinocchio's; q: shaft, slider's height, both rods downwards."""

    def __init__(self) -> None:
        self.tree = pin.Model()
        self.tree.gravity.linear = np.array([0, 0, -9.81])
        thin, slim = 0.3 * (L**2 + W**2) / 12, 0.3 * W**2 / 6
        shaft = self._body(
            0, pin.JointModelRZ(), np.zeros(3), 0.3, [0, 0, L / 2], [thin, thin, slim]
        )
        self.slider = self._body(
            shaft, pin.JointModelPZ(), np.zeros(3), 3.0, [0, 0, 0], [3.0 * B**2 / 6] * 3
        )
        self.rods = []
        for side in (1, -1):
            joint = pin.JointModelRY() if side > 0 else pin.JointModelRevoluteUnaligned(0, -1, 0)
            hinge = np.array([side * B / 2, 0, L])
            rod = self._body(shaft, joint, hinge, 0.3, [side * L / 2, 0, 0], [slim, thin, thin])
            self.tree.appendBodyToJoint(
                rod,
                pin.Inertia(5.0, np.array([side * L, 0, 0]), np.zeros((3, 3))),
                pin.SE3.Identity(),
            )
            self.rods.append((rod, side))
        self.data = self.tree.createData()

    def _body(
        self,
        parent: int,
        joint: object,
        place: object,
        mass: float,
        centroid: object,
        moments: object,
    ) -> int:
        index = self.tree.addJoint(
            parent, joint, pin.SE3(np.eye(3), np.asarray(place)), f"joint {self.tree.njoints}"
        )
        inertia = pin.Inertia(mass, np.array(centroid, dtype=float), np.diag(moments))
        self.tree.appendBodyToJoint(index, inertia, pin.SE3.Identity())
        return index

    def accelerations(self, places: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Of shaft, slider and rods; the couplers pull at the rods' middles and at the slider's
        sides.
        """
        pin.forwardKinematics(self.tree, self.data, places, rates)
        forces = [pin.Force.Zero() for _ in range(self.tree.njoints)]
        for rod, side in self.rods:
            ends = [
                (rod, np.array([side * L / 2, 0, 0])),
                (self.slider, np.array([side * B / 2, 0, 0])),
            ]
            (p, v), (r, u) = (self._point(*end) for end in ends)
            line, long = r - p, np.linalg.norm(r - p)
            pull = (STIFFNESS * (long - FREE) + DAMPING * (line @ (u - v)) / long) * line / long
            for (body, at), force in zip(ends, (pull, -pull), strict=True):
                local = self.data.oMi[body].rotation.T @ force
                forces[body] += pin.Force(local, np.cross(at, local))
        computed: np.ndarray = pin.aba(self.tree, self.data, places, rates, np.zeros(4), forces)
        return computed

    def _point(self, body: int, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pose, twist = self.data.oMi[body], self.data.v[body]
        return pose.act(at), pose.rotation @ (twist.linear + np.cross(twist.angular, at))


def test_accelerations_are_those_of_the_engine() -> None:
    governor, engine, rng = own.dynamics(GOVERNOR, "governor"), Engine(), np.random.default_rng(5)
    assert governor.names[:4] == ["turn", "s", "drop0", "drop1"]
    for _ in range(5):
        state = np.concatenate([rng.uniform(0.2, 0.7, 4), rng.uniform(-1, 1, 4)])
        rates, expected = (
            governor.accelerations(0.0, state)[0],
            engine.accelerations(state[:4], state[4:]),
        )
        assert own.deviation("accelerations", rates, expected) < 1e-11 * np.abs(expected).max()
    heavier = own.dynamics(GOVERNOR, "governor", m_b_kg=5.001).accelerations(0.0, state)[0]
    assert np.abs(heavier - expected).max() > 1e-6 * np.abs(expected).max()


def test_the_slider_moves_as_the_engine_says_over_ten_seconds() -> None:
    governor, engine = own.dynamics(GOVERNOR, "governor"), Engine()
    run = governor.run(TIMES, 1e-6, stiff=True)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[4:], engine.accelerations(y[:4], y[4:])])

    solution = scipy.integrate.solve_ivp(
        rates, (0, 10), governor.start(), "LSODA", TIMES, rtol=1e-9, atol=1e-11
    )
    assert own.deviation("slider's height", run.states[1], solution.y[1]) < 1e-6
    assert np.ptp(run.states[1]) > 0.05
    assert own.deviation("both rods", run.states[2], run.states[3]) < 1e-8
    energy = run.results["kinetic"] + run.results["potential"]
    assert np.all(np.diff(energy) < 1e-6 * energy[0]), "the dampers only take, to the tolerance"
