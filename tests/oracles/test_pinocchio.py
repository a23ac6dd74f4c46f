"""All joint forces against Pinocchio's recursive Newton-Euler (Carpentier et al., SII 2019), which
is given the motion.

Frame, carrier, two middle bodies, two planets and four nozzle halves are built from the machine
file's numbers; the motion comes from the geometry alone; tooth, cam and spring forces act at their
points, with only their sizes taken from the model. Where the model is right, free joints need no
torque and all reactions agree.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from planter.papers.planting.file import PlantingMachine
from tests.support import kinematics, machines, model

pin = pytest.importorskip("pinocchio")

Vector = NDArray[np.float64]
TOLERANCE = 1e-9
SIDES = (0, 1)
HALVES = ("inner", "outer")
NAMES = (*machines.BUILT_IN, *machines.RANDOM)
MIRROR = 0.123
"""Where the plane between the nozzle halves lies is not disclosed; it must not matter."""


@dataclass
class Engine:
    """The device as a tree of Pinocchio joints. Side 2 is mounted half a turn round the carrier."""

    numbers: PlantingMachine
    motion: kinematics.Device
    tree: pin.Model = field(default_factory=pin.Model)

    def __post_init__(self) -> None:
        si = self.numbers.si
        self.tree.gravity.linear = np.array([0, -si("gravity_m_s2"), 0])
        sun = si("centroid.sun_radius_mm") * _direction(si("centroid.sun_angle_deg"))
        self._body(
            "sun", 0, pin.JointModelRZ(), pin.SE3.Identity(), (si("sun_kg"), sun, np.ones(3))
        )
        carrier = self._body(
            "carrier",
            0,
            pin.JointModelRZ(),
            pin.SE3.Identity(),
            (si("carrier_kg"), np.zeros(3), np.ones(3)),
        )
        for side in SIDES:
            self._side(side, carrier)
        self.data = self.tree.createData()

    def _body(
        self,
        name: str,
        parent: int,
        joint: object,
        place: pin.SE3,
        *parts: tuple[float, Vector, Vector],
    ) -> int:
        """A body hung on a joint: parts are mass, centroid and centroidal moments of inertia."""
        index = self.tree.addJoint(parent, joint, place, name)
        for mass, centroid, moments in parts:
            self.tree.appendBodyToJoint(
                index, pin.Inertia(mass, centroid, np.diag(moments)), pin.SE3.Identity()
            )
        return index

    def _side(self, side: int, carrier: int) -> None:
        si, turned = self.numbers.si, -np.pi * side
        a1, a2 = self.motion.sun.distance, self.motion.gear6.distance
        radius, mass = si("centroid.middle_radius_mm"), si("middle_kg")
        middle = np.array([1, 1, si("J56_about_A1_kg_m2") - mass * radius**2])
        centroid = radius * _direction(si("centroid.middle_angle_deg"))
        A1 = a1 * _direction(np.pi / 2 + turned)
        place = pin.SE3(_turn(turned), A1)
        self._body(f"middle {side}", carrier, pin.JointModelRZ(), place, (mass, centroid, middle))
        centroid, mass = (
            np.array([si("planet_xy_mm[0]"), si("planet_xy_mm[1]"), 0]),
            si("planet_kg"),
        )
        B1 = A1 + a2 * _direction(np.pi / 2 + turned + si("design.gamma_deg"))
        moments = np.array([1, 1, si("J7_about_B1_kg_m2") - mass * centroid @ centroid])
        place = pin.SE3(_turn(turned + si("design.theta_deg") - np.pi), B1)
        planet = self._body(
            f"planet {side}", carrier, pin.JointModelRZ(), place, (mass, centroid, moments)
        )
        for half in HALVES:
            hinge = pin.SE3(np.eye(3), self.hinge(half))
            parts = [self._part(part, half) for part in ("C1", "C2")]
            self._body(f"{half} {side}", planet, pin.JointModelRY(), hinge, *parts)

    def point(self, name: str, half: str) -> Vector:
        """A point of the inner half, or its mirror image."""
        return np.array([self.numbers.si(f"nozzle.{name}_mm[{i}]") for i in range(3)]) * _mirrored(
            half
        )

    def hinge(self, half: str) -> Vector:
        return self.point("hinge_A", half) + (
            0 if half == "inner" else np.array([0, 0, 2 * MIRROR])
        )

    def _part(self, name: str, half: str) -> tuple[float, Vector, Vector]:
        moments = [
            self.numbers.si(f"inertia.{name}_centroidal_xx_yy_zz_kg_m2[{i}]") for i in range(3)
        ]
        return self.numbers.si(f"mass.half_{name}_kg"), self.point(name, half), np.array(moments)

    def run(self, sides: tuple[kinematics.Side, kinematics.Side], loads: list[Load]) -> None:
        """Inverse dynamics in the given motion, under forces between bodies."""
        q, v, a = (self._state(sides, order) for order in range(3))
        pin.forwardKinematics(self.tree, self.data, q)
        total = [pin.Force.Zero() for _ in self.data.f]
        for load in loads:
            for name, sign in ((load.on, 1), (load.by, -1)):
                index = self.tree.getJointId(name)
                total[index] += self.data.oMi[index].actInv(load.wrench(sign))
        pin.rnea(self.tree, self.data, q, v, a, total)

    def _state(self, sides: tuple[kinematics.Side, kinematics.Side], order: int) -> Vector:
        state = np.zeros(self.tree.nq)

        def put(name: str, coordinate: object) -> None:
            state[self.tree.joints[self.tree.getJointId(name)].idx_q] = np.asarray(
                coordinate
            ).item()

        put("carrier", sides[0].phi.parts[order])
        for i, side in enumerate(sides):
            put(f"middle {i}", side.phi52.parts[order])
            put(f"planet {i}", side.phi72.parts[order])
            put(f"inner {i}", side.theta1.parts[order])
            put(f"outer {i}", -side.theta1.parts[order])
        return state

    def torque(self, name: str) -> float:
        """What the joint's drive gives about its axis."""
        return float(self.data.tau[self.tree.joints[self.tree.getJointId(name)].idx_v])

    def reaction(self, name: str) -> Vector:
        """Force that a body feels from its joint, in the global frame."""
        index = self.tree.getJointId(name)
        return np.array(self.data.oMi[index].rotation @ self.data.f[index].linear)

    def planet_axes(self, side: int) -> Vector:
        """x', y', z' as columns."""
        return np.array(self.data.oMi[self.tree.getJointId(f"planet {side}")].rotation)

    def place(self, side: int, local: Vector) -> Vector:
        """A point given in x'y'z' of a side, in the global frame."""
        return np.array(self.data.oMi[self.tree.getJointId(f"planet {side}")].act(local))


@dataclass(frozen=True)
class Load:
    """A force on one body by another, at a point of the global frame."""

    on: str
    by: str
    at: Vector
    force: Vector

    def wrench(self, sign: int) -> pin.Force:
        return pin.Force(sign * self.force, sign * np.cross(self.at, self.force))


def _direction(angle: float) -> Vector:
    return np.array([np.cos(angle), np.sin(angle), 0])


def _turn(angle: float) -> Vector:
    return np.array(pin.utils.rotate("z", angle))


def _mirrored(half: str) -> Vector:
    return np.array([1, 1, 1 if half == "inner" else -1])


def _plane(*components: object) -> Vector:
    return np.array([*(np.asarray(c).item() for c in components), 0])


@dataclass(frozen=True)
class Case:
    """The model's outputs at one angle beside the engine's."""

    outputs: model.Outputs
    sides: tuple[kinematics.Side, kinematics.Side]
    engine: Engine

    def loads(self, cam_turned: float = 0.0) -> list[Load]:
        return [load for i in SIDES for load in (*self._teeth(i), *self._nozzle(i, cam_turned))]

    def _teeth(self, i: int) -> list[Load]:
        side, values = self.sides[i], self.outputs.sides[i]
        P, Q = side.mesh(1), side.mesh(2)
        return [
            Load("sun", f"middle {i}", _plane(*P.place), _plane(*P.force(values["M_P"]))),
            Load(f"middle {i}", f"planet {i}", _plane(*Q.place), _plane(*Q.force(values["M_Q"]))),
        ]

    def _nozzle(self, i: int, cam_turned: float) -> list[Load]:
        side, values, axes = self.sides[i], self.outputs.sides[i], self.engine.planet_axes(i)
        x, z = (np.asarray(c).item() for c in side.cam_direction)
        turned = np.array(
            [[np.cos(cam_turned), np.sin(cam_turned)], [-np.sin(cam_turned), np.cos(cam_turned)]]
        )
        x, z = turned @ (x, z) * values["F_E"]
        roller = np.array([np.asarray(c.value).item() for c in side.roller])
        pull = np.array([0, 0, np.asarray(side.spring).item()])
        hook = self._hook(i)
        return [
            Load(f"inner {i}", "carrier", self.engine.place(i, roller), axes @ (x, 0, z)),
            Load(f"inner {i}", f"outer {i}", hook, axes @ pull),
        ]

    def _hook(self, i: int) -> Vector:
        index = self.engine.tree.getJointId(f"inner {i}")
        return np.array(self.engine.data.oMi[index].act(self.engine.point("hook_F", "inner")))


def at(
    name: str, phi: float, numbers: PlantingMachine | None = None, cam_turned: float = 0.0
) -> Case:
    """Model and engine at one angle; `numbers` may give the engine another machine than the
    model's.
    """
    motion = kinematics.Device(machines.machine(name))
    sides = motion.side(np.array([phi])), motion.side(np.array([phi - np.pi]))
    outputs = model.cycle(machines.device(name), phi)
    item = model.Outputs(
        *({k: v.item() for k, v in part.items()} for part in (*outputs.sides, outputs.totals))
    )
    case = Case(item, sides, Engine(numbers or machines.machine(name), motion))
    case.engine.run(sides, [])
    case.engine.run(sides, case.loads(cam_turned))
    return case


def differences(case: Case) -> dict[str, float]:
    """Model less engine for all joint forces and driving torques; torques that must vanish as they
    are.
    """
    engine, totals = case.engine, case.outputs.totals
    moments = {
        "M_1": totals["M_1"] - engine.torque("sun"),
        "M_L": totals["M_L"] - engine.torque("carrier"),
    }
    for force, body in (("F_O", "sun"), ("F_O1", "carrier")):
        for axis, value in zip("xy", engine.reaction(body), strict=False):
            moments[f"{force}{axis}"] = totals[f"{force}{axis}"] - float(value)
    for i in SIDES:
        moments |= {f"{key}, side {i + 1}": gap for key, gap in _side_differences(case, i).items()}
    return moments


def _side_differences(case: Case, i: int) -> dict[str, float]:
    engine, side = case.engine, case.outputs.sides[i]
    side_moments = {
        "middle free": engine.torque(f"middle {i}"),
        "planet free": engine.torque(f"planet {i}"),
        "coupling without work": engine.torque(f"inner {i}") - engine.torque(f"outer {i}"),
    }
    joints = (
        ("F_A1", f"middle {i}", np.eye(3)),
        ("F_B1", f"planet {i}", np.eye(3)),
        ("F_A", f"inner {i}", engine.planet_axes(i)),
        ("F_Ao", f"outer {i}", engine.planet_axes(i)),
    )
    for force, body, axes in joints:
        for axis, value in zip("xy", engine.reaction(body) @ axes, strict=False):
            side_moments[f"{force}{axis}"] = side[f"{force}{axis}"] - float(value)
    return side_moments


def worst(case: Case) -> float:
    return max(abs(gap) for gap in differences(case).values())


def angles(name: str, count: int = 20) -> Vector:
    return np.random.default_rng(NAMES.index(name)).uniform(0, 2 * np.pi, count)


@pytest.mark.parametrize("name", machines.sampled(1, 4))
def test_all_joint_forces_agree(name: str) -> None:
    for phi in angles(name):
        for key, gap in differences(at(name, phi)).items():
            assert abs(gap) < TOLERANCE, f"{key} at {np.degrees(phi):.3f} deg"


@pytest.mark.parametrize(
    "path", [p for p in machines.machine("wang2017").numbers() if p.startswith("mass.")]
)
def test_mass_error_of_a_percent_is_detected(path: str) -> None:
    case = at("wang2017", 1.0, numbers=machines.tampered("wang2017", path))
    assert worst(case) > 1e3 * TOLERANCE


@pytest.mark.parametrize(
    "path",
    [
        "nozzle.C2_mm[0]",
        "nozzle.C1_mm[2]",
        "centroid.middle_angle_deg",
        "centroid.sun_angle_deg",
        "inertia.C2_centroidal_xx_yy_zz_kg_m2[1]",
        "inertia.J56_about_A1_kg_m2",
    ],
)
def test_centroid_or_inertia_error_of_a_percent_is_detected(path: str) -> None:
    case = at("wang2017", np.radians(165), numbers=machines.tampered("wang2017", path))
    assert worst(case) > 1e3 * TOLERANCE


def test_cam_force_turned_by_a_degree_is_detected() -> None:
    assert worst(at("wang2017", 1.0, cam_turned=np.radians(1))) > 1e3 * TOLERANCE


def test_the_directions_of_tooth_and_cam_forces_are_the_models() -> None:
    for name in NAMES:
        case = at(name, 2.0)
        for i in SIDES:
            side, values = case.sides[i], case.outputs.sides[i]
            expected = (
                *side.mesh(1).force(values["M_P"]),
                *side.mesh(2).force(values["M_Q"]),
                *(values["F_E"] * c for c in side.cam_direction),
            )
            forces = (values[key] for key in ("F_Px", "F_Py", "F_Qx", "F_Qy", "F_Ex", "F_Ez"))
            for force, its in zip(expected, forces, strict=True):
                assert np.asarray(force).item() == pytest.approx(its, abs=TOLERANCE)
