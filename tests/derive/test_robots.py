"""Robots of URDF files: energies by matrices of the file's own numbers, and Pinocchio."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray

from derive.robots import RobotError, read_robot, write_statement
from planter.mechanism.state_space.model import DynamicsModel, load_dynamics
from tests.support.cli import answer, refusal

Array = NDArray[np.float64]
ARM = """<robot name="arm-3">
 <link name="base"/>
 <link name="upper"><inertial><origin xyz="0.05 0.01 0.2" rpy="0.3 -0.2 0.1"/><mass value="2.5"/>
  <inertia ixx="0.03" ixy="0.001" ixz="-0.002" iyy="0.025" iyz="0.0005" izz="0.01"/></inertial></link>
 <link name="fore"><inertial><origin xyz="0 0 0.15"/><mass value="1.2"/>
  <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.011" iyz="0" izz="0.002"/></inertial></link>
 <link name="tool"><inertial><origin xyz="0.02 0 0.03"/><mass value="0.4"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.0005"/></inertial></link>
 <link name="rod"><inertial><origin xyz="0 0 0.1" rpy="0 0.5 0"/><mass value="0.6"/>
  <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.0003"/></inertial></link>
 <link name="finger"><inertial><origin xyz="0.01 0.02 0"/><mass value="0.1"/>
  <inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0002" iyz="0" izz="0.0001"/></inertial></link>
 <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
  <origin xyz="0 0 0.1" rpy="0 0 0.4"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" effort="40" velocity="3"/>
  <dynamics damping="0.3" friction="0.1"/></joint>
 <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/>
  <origin xyz="0 0.05 0.4" rpy="1.5707963 0.2 -0.7"/><axis xyz="1.2 0 1.6"/></joint>
 <joint name="wrist" type="fixed"><parent link="fore"/><child link="tool"/>
  <origin xyz="0 0 0.3" rpy="0.1 0.2 0.3"/></joint>
 <joint name="slide" type="prismatic"><parent link="tool"/><child link="rod"/>
  <origin xyz="0 0.01 0.05" rpy="0 0.3 0"/><axis xyz="0 0 -1"/>
  <limit lower="0" upper="0.1" effort="20" velocity="1"/></joint>
 FOLLOWER
</robot>"""
FOLLOWER = """<joint name="grip" type="revolute"><parent link="rod"/><child link="finger"/>
  <origin xyz="0 0 0.2"/><axis xyz="0 0 1"/><mimic joint="elbow" multiplier="-0.5" offset="0.2"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
FIXED = FOLLOWER.replace('type="revolute"', 'type="fixed"')


def write_robot(follower: str) -> Path:
    path = Path(mkdtemp()) / "robot.urdf"
    path.write_text(ARM.replace("FOLLOWER", follower), encoding="utf-8")
    return path


@cache
def model(follower: str) -> DynamicsModel:
    return load_model(write_robot(follower))


def load_model(path: Path) -> DynamicsModel:
    out = path.parent / "own"
    answer("derive", str(path), "--out", str(out))
    (file,) = out.glob("*.toml")
    return load_dynamics(file)


QUARTER = "1.57079632679"
ROBOTS = {
    "seven axes": f"""0 0 0.33,0 0 0; 0 0 0,-{QUARTER} 0 0; 0 -0.32 0,{QUARTER} 0 0
        0.08 0 0,{QUARTER} 0 0; -0.08 0.38 0,-{QUARTER} 0 0; 0 0 0,{QUARTER} 0 0
        0.09 0 0,{QUARTER} 0 0""",
    "parallel axes": f"""0 0 0.09,0 0 0; 0 0.14 0,0 {QUARTER} 0,0 1 0; 0 -0.12 0.43,0 0 0,0 1 0
        0 0 0.39,0 {QUARTER} 0,0 1 0; 0 0.09 0,0 0 0; 0 0 0.09,0 0 0,0 1 0""",
    "oblique axes": """0 0 0.1,0.1 0.2 0.3,1 2 3; 0.1 0 0.1,-0.4 0.2 1.3,0 1 0.5
        0.1 0 0.1,-0.4 0.2 1.3,0.3 1 0.5; 0.1 0.2 0.1,0 0 0,1 0 0
        0.1 0.2 0.1,1 0 0,0 0.6 0.8; 0 0.2 0.1,1 1 0,-1 1 0""",
}
"""Origins, rolls with pitch and yaw, and axes of joints, along z unless given: small robots of six
and seven axes. The third of the oblique ones slides.
"""


def write_chain(name: str) -> Path:
    """The file of a robot whose links have any inertia."""
    rng, parts, before = np.random.default_rng(2), ['<link name="base"/>'], "base"
    for k, joint in enumerate(ROBOTS[name].replace("\n", ";").split(";")):
        place, angles, axis = (*joint.strip().split(","), "0 0 1")[:3]
        root = 0.05 * rng.normal(size=(3, 3))
        tensor, centroid = root @ root.T + 0.01 * np.eye(3), rng.uniform(-0.1, 0.1, 3)
        entries = " ".join(
            f'i{"xyz"[i]}{"xyz"[j]}="{tensor[i, j]}"' for i in range(3) for j in range(i, 3)
        )
        kind = "prismatic" if (name, k) == ("oblique axes", 2) else "revolute"
        parts.append(
            f'<link name="link{k}"><inertial><origin xyz="{" ".join(map(str, centroid))}"/>'
            f'<mass value="{rng.uniform(0.5, 3)}"/><inertia {entries}/></inertial></link>'
            f'<joint name="joint{k}" type="{kind}"><parent link="{before}"/>'
            f'<child link="link{k}"/><origin xyz="{place}" rpy="{angles}"/><axis xyz="{axis}"/>'
            '<limit lower="-2" upper="2" effort="80" velocity="3"/></joint>'
        )
        before = f"link{k}"
    path = Path(mkdtemp()) / "robot.urdf"
    path.write_text(f'<robot name="chain">{"".join(parts)}</robot>', encoding="utf-8")
    return path


def numbers(element: ElementTree.Element | None, key: str, default: str) -> list[float]:
    text = default if element is None else element.get(key, default)
    return [float(word) for word in text.split()]


def turn(axis: Array, angle: float) -> Array:
    """Rodrigues' rotation."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def roll(angles: list[float]) -> Array:
    r, p, y = angles
    x_axis, y_axis, z_axis = np.eye(3)
    return turn(z_axis, y) @ turn(y_axis, p) @ turn(x_axis, r)


def place_links(path: Path, values: dict[str, float]) -> dict[str, tuple[Array, Array]]:
    """Rotation and place of each link, by the file's own tree."""
    root = ElementTree.parse(path).getroot()
    placed = {"base": (np.eye(3), np.zeros(3))}
    for joint in root.findall("joint"):
        origin, name = joint.find("origin"), joint.get("name")
        rotation, at = placed[joint.find("parent").get("link")]
        at = at + rotation @ numbers(origin, "xyz", "0 0 0")
        rotation = rotation @ roll(numbers(origin, "rpy", "0 0 0"))
        axis, mimic = np.array(numbers(joint.find("axis"), "xyz", "1 0 0")), joint.find("mimic")
        value = values.get(name, 0.0)
        if mimic is not None:
            value = float(mimic.get("multiplier")) * values["elbow"] + float(mimic.get("offset"))
        if joint.get("type") == "prismatic":
            at = at + rotation @ axis * value
        elif joint.get("type") != "fixed":
            rotation = rotation @ turn(axis, value)
        placed[joint.find("child").get("link")] = rotation, at
    return placed


def find_energies(path: Path, names: list[str], state: Array) -> tuple[float, float]:
    """Kinetic energy by differences of positions and rotations, potential energy of weights."""
    root, count, step = ElementTree.parse(path).getroot(), len(names), 1e-6
    moments = {}
    for side in (-1, 0, 1):
        q = state[:count] + side * step * state[count:]
        moments[side] = place_links(path, dict(zip(names, q, strict=True)))
    kinetic = potential = 0.0
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        (mass,) = numbers(inertial.find("mass"), "value", "0")
        origin, name = inertial.find("origin"), link.get("name")
        centroid = np.array(numbers(origin, "xyz", "0 0 0"))
        tensor = np.zeros((3, 3))
        for i, a in enumerate("xyz"):
            for j, b in enumerate("xyz"):
                key = "i" + "".join(sorted(a + b))
                tensor[i, j] = numbers(inertial.find("inertia"), key, "0")[0]
        turned = roll(numbers(origin, "rpy", "0 0 0"))
        at = {side: part[name][1] + part[name][0] @ centroid for side, part in moments.items()}
        velocity = (at[1] - at[-1]) / (2 * step)
        rate = (moments[1][name][0] - moments[-1][name][0]) / (2 * step) @ moments[0][name][0].T
        spin = np.array([rate[2, 1], rate[0, 2], rate[1, 0]])
        local = (moments[0][name][0] @ turned).T @ spin
        kinetic += mass * velocity @ velocity / 2 + local @ tensor @ local / 2
        potential += mass * 9.81 * at[0][2]
    return kinetic, potential


@pytest.mark.parametrize("follower", [FIXED, FOLLOWER], ids=["fixed", "mimic"])
def test_energies_are_those_of_the_file(follower: str) -> None:
    subject, path = model(follower), write_robot(follower)
    names = [state.name for state in subject.states][:3]
    assert names == ["shoulder", "elbow", "slide"]
    outputs = [output.name for output in subject.outputs]
    rng = np.random.default_rng(3)
    rest = np.zeros(6)
    zero = subject.outputs_at(0.0, rest)[outputs.index("potential")]
    level = find_energies(path, names, rest)[1]
    for _ in range(5):
        state = rng.uniform(-1, 1, 6)
        values = dict(zip(outputs, subject.outputs_at(0.0, state), strict=True))
        kinetic, potential = find_energies(path, names, state)
        assert values["kinetic"] == pytest.approx(kinetic, rel=1e-8)
        assert values["potential"] - zero == pytest.approx(potential - level, rel=1e-9)


def test_drives_have_the_efforts_of_the_file_and_friction_resists() -> None:
    subject = model(FIXED)
    limits = {entry.name: (entry.unit, entry.high) for entry in subject.inputs}
    assert limits["T_shoulder"] == ("N m", 40)
    assert limits["T_slide"] == ("N", 20)
    state = np.zeros(6)
    state[3] = 0.5
    parameters = subject.p.copy()
    drag = [index for index, x in enumerate(subject.parameters) if x.name in ("d_shoulder",)]
    parameters[drag] = 0.0
    slower = subject.rates(0.0, state) - subject.rates(0.0, state, p=parameters)
    assert slower[3] < 0


def test_accelerations_are_those_of_pinocchio() -> None:
    pin = pytest.importorskip("pinocchio")
    subject, tree = model(FIXED), pin.buildModelFromUrdf(str(write_robot(FIXED)))
    data, rng = tree.createData(), np.random.default_rng(1)
    parameters = subject.p.copy()
    names = [parameter.name for parameter in subject.parameters]
    for name in ("d_shoulder", "F_shoulder"):
        parameters[names.index(name)] = 0.0
    for _ in range(20):
        q, rates, efforts = (rng.uniform(-1, 1, 3) for _ in range(3))
        q_pin = np.array([q[0], np.cos(q[1]), np.sin(q[1]), q[2]])
        expected = pin.aba(tree, data, q_pin, rates, efforts)
        accelerations = subject.rates(0.0, np.concatenate([q, rates]), efforts, parameters)[3:]
        np.testing.assert_allclose(accelerations, expected, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_of_many_axes_move_as_pinocchio_says(name: str) -> None:
    pin = pytest.importorskip("pinocchio")
    path = write_chain(name)
    subject, tree = load_model(path), pin.buildModelFromUrdf(str(path))
    data, rng = tree.createData(), np.random.default_rng(1)
    for _ in range(20):
        q, rates, efforts = (rng.uniform(-1, 1, tree.nv) for _ in range(3))
        expected = pin.aba(tree, data, q, rates, efforts)
        accelerations = subject.rates(0.0, np.concatenate([q, rates]), efforts)[tree.nv :]
        np.testing.assert_allclose(accelerations, expected, atol=1e-13 * np.abs(expected).max())


GRIPPER = """<link name="hand"><inertial><origin xyz="0 0.01 0.04" rpy="0.1 0 0.2"/>
 <mass value="0.7"/><inertia ixx="0.002" ixy="0" ixz="0.0001" iyy="0.001" iyz="0" izz="0.0015"/>
 </inertial></link>
 <joint name="flange" type="fixed"><parent link="link6"/><child link="hand"/>
  <origin xyz="0 0 0.107" rpy="0 0 -0.785"/></joint>
 FINGERS
 </robot>"""
FINGER = """<link name="finger{n}"><inertial><origin xyz="0 {side}0.02 0.02"/><mass value="0.06"/>
 <inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.00005"/></inertial></link>
 <joint name="finger_joint{n}" type="prismatic"><parent link="hand"/><child link="finger{n}"/>
  <origin xyz="0 0 0.06"/><axis xyz="0 {side}1 0"/>
  <limit lower="0" upper="0.04" effort="20" velocity="0.2"/>{more}</joint>"""


def write_gripper() -> Path:
    """Seven axes with damping and friction, a hand that is fixed, fingers that move alike."""
    path = write_chain("seven axes")
    text = path.read_text(encoding="utf-8")
    rubbing = '<dynamics damping="0.4" friction="0.3"/></joint>'
    text = text.replace("</joint>", rubbing)
    sliding = '<dynamics damping="5"/>'
    following = '<mimic joint="finger_joint1"/>'
    fingers = FINGER.format(n=1, side="", more=sliding)
    fingers += FINGER.format(n=2, side="-", more=following)
    text = text.replace("</robot>", GRIPPER.replace("FINGERS", fingers))
    path.write_text(text, encoding="utf-8")
    return path


def test_damped_arm_with_a_gripper_moves_as_pinocchio_says() -> None:
    pin = pytest.importorskip("pinocchio")
    path = write_gripper()
    subject, tree = load_model(path), pin.buildModelFromUrdf(str(path), mimic=True)
    data, rng, count = tree.createData(), np.random.default_rng(1), 8
    assert len(subject.states) == 2 * count
    damping = np.array([*7 * [0.4], 5.0])
    friction = np.array([*7 * [0.3], 0.0])
    for _ in range(20):
        q, rates, efforts = (rng.uniform(-1, 1, count) for _ in range(3))
        inertia = pin.crba(tree, data, q)
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        drag = damping * rates + friction * rates / np.hypot(rates, 0.01)
        loads = efforts - drag - pin.nonLinearEffects(tree, data, q, rates)
        expected = np.linalg.solve(inertia, loads)
        accelerations = subject.rates(0.0, np.concatenate([q, rates]), efforts)[count:]
        np.testing.assert_allclose(accelerations, expected, atol=1e-13 * np.abs(expected).max())
        free = np.linalg.solve(inertia, loads + drag)
        assert np.abs(accelerations - free).max() > 1e-3


def test_joint_that_follows_another_moves_as_pinocchio_says() -> None:
    """Its coordinate moves two links, so that articulated inertias would be wrong."""
    pin = pytest.importorskip("pinocchio")
    follower = FOLLOWER.replace('mimic joint="elbow"', 'mimic joint="shoulder"')
    subject = model(follower)
    assert subject.equations.accelerations is None
    tree = pin.buildModelFromUrdf(str(write_robot(follower)), mimic=True)
    data, rng = tree.createData(), np.random.default_rng(1)
    names = [parameter.name for parameter in subject.parameters]
    parameters = subject.p.copy()
    for name in ("d_shoulder", "F_shoulder"):
        parameters[names.index(name)] = 0.0
    for _ in range(20):
        q, rates, efforts = (rng.uniform(-1, 1, 3) for _ in range(3))
        q_pin = np.array([q[0], np.cos(q[1]), np.sin(q[1]), q[2]])
        inertia = pin.crba(tree, data, q_pin)
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        loads = efforts - pin.nonLinearEffects(tree, data, q_pin, rates)
        expected = np.linalg.solve(inertia, loads)
        accelerations = subject.rates(0.0, np.concatenate([q, rates]), efforts, parameters)[3:]
        np.testing.assert_allclose(accelerations, expected, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (("<robot", "<machine"), "XML"),
        (('type="continuous"', 'type="floating"'), "elbow: type floating"),
        (('link="fore"/>', 'link="for"/>'), "link for"),
        (('xyz="1.2 0 1.6"', 'xyz="0 0 0"'), "elbow"),
        (('value="2.5"', 'value="heavy"'), "upper"),
        (('<child link="rod"/>', '<child link="fore"/>'), "tree"),
        (('mimic joint="elbow"', 'mimic joint="hip"'), "grip: mimic joint=.hip.*shoulder, elbow"),
        (('mimic joint="elbow"', 'mimic joint="grip"'), "grip: mimic"),
        (('mimic joint="elbow"', 'mimic joint="wrist"'), "grip: mimic"),
        (('<link name="rod">', '<link name="tool">'), "link tool: two"),
        (('<link name="rod">', '<link name="up er"/><link name="up_er">'), "up er and up_er"),
        (('joint name="slide"', 'joint name="elbow"'), "joint elbow: two"),
        (('value="1.2"', 'value="-1.2"'), "fore: mass: value=.-1.2"),
        (('izz="0.0003"', 'izz="-0.0003"'), "rod: izz"),
        (('friction="0.1"', 'friction="-0.1"'), "shoulder: friction"),
        (('effort="40"', 'effort="-40"'), "shoulder: effort"),
        (('lower="0"', 'lower="0.2"'), "slide: lower=.0.2. is above upper=.0.1"),
        (('damping="0.3"', 'damping="thick"'), "damping=.thick.: it must be a number"),
    ],
)
def test_what_states_no_mechanism_is_refused(change: tuple[str, str], named: str) -> None:
    path = write_robot(FOLLOWER)
    text = path.read_text(encoding="utf-8")
    assert change[0] in text
    path.write_text(text.replace(*change), encoding="utf-8")
    with pytest.raises(RobotError, match=named) as refused:
        write_statement(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert str(path) in refusal("derive", str(path))


def test_fixed_links_are_parts_of_one_body() -> None:
    robot = read_robot(write_robot(FIXED))
    assert list(robot.links) == ["base", "upper", "fore", "rod"]
    assert len(robot.links["fore"]) == len(robot.links["rod"]) == 2
