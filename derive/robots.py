"""Robots of URDF files as statements of mechanisms.

Links that do not move against each other become one body. A joint's axis may point anywhere; a
joint that follows another one (mimic) is an expression of its coordinate. Efforts are inputs within
their limits, damping and friction are forces between links; friction is smooth below the speed
`creep`. Meshes, colliders, transmissions and limits of travel have no place in a statement: limits
stand beside their coordinates.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mpmath
from mpmath import matrix, mpf

KINDS = ("revolute", "continuous", "prismatic", "fixed")
ENTRIES = ("xx", "yy", "zz", "xy", "xz", "yz")
PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
FALL = 9.81
CREEP = 0.01
"""Speed below which friction is smooth [m/s or rad/s]."""
ALIGNED = 1e-6
"""Axes nearer than this to an axis of the parent's frame name the components of reactions."""
Vector = Sequence[float]


class RobotError(ValueError):
    """A URDF file that states no mechanism."""


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], centroid [m] and tensor about it [kg m2], along the axes of a link's frame."""

    mass: float
    centroid: matrix
    tensor: matrix


@dataclass(frozen=True)
class RobotJoint:
    """A joint from `parent` to `child`; `turn` and `place` lead from the parent's frame to its own."""

    name: str
    kind: str
    parent: str
    child: str
    angles: Vector
    place: matrix
    axis: Vector
    limits: Mapping[str, float]
    damping: float
    friction: float
    mimic: tuple[str, float, float] | None

    @property
    def turn(self) -> matrix:
        """Rotation from the joint's frame to the parent's."""
        return _turn(self.angles)

    @property
    def moves(self) -> bool:
        return self.kind != "fixed"


@dataclass
class Robot:
    """Links by name with their inertial parts, joints in the order from the base."""

    name: str
    links: dict[str, list[Inertial]]
    joints: list[RobotJoint] = field(default_factory=list)


def read_robot(path: Path) -> Robot:
    """Return a robot of a URDF file, without fixed joints. Raises RobotError, which names the place."""
    try:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except (ElementTree.ParseError, UnicodeDecodeError) as error:
        raise RobotError(f"{path}: it is no XML: {error}") from None
    if root.tag != "robot":
        raise RobotError(f"{path}: <{root.tag}>: a URDF file has <robot>")
    for tag in ("link", "joint"):
        _refuse_equal_names([_name(element, path) for element in root.findall(tag)], tag, path)
    links = {_name(link, path): list(_read_inertial(link, path)) for link in root.findall("link")}
    joints = [_read_joint(joint, links, path) for joint in root.findall("joint")]
    _check_followers(joints, path)
    children = [joint.child for joint in joints]
    bases = [link for link in links if link not in children]
    if len(bases) != 1 or len(set(children)) != len(children):
        raise RobotError(f"{path}: links must form a tree with a single base; bases are {bases}")
    return _merge_fixed(Robot(root.get("name") or path.stem, links), joints, bases[0], path)


def _refuse_equal_names(names: Sequence[str], tag: str, path: Path) -> None:
    """Raise RobotError if two names are one in Python, where other signs become a line."""
    by_identifier: dict[str, str] = {}
    for name in names:
        if (before := by_identifier.setdefault(_identifier(name), name)) is not name:
            both = name if before == name else f"{before} and {name}"
            raise RobotError(f"{path}: {tag} {both}: two have this name; rename one of them")


def _check_followers(joints: Sequence[RobotJoint], path: Path) -> None:
    """Raise RobotError for a joint that follows none that has a coordinate of its own."""
    leaders = [joint.name for joint in joints if joint.moves and joint.mimic is None]
    for joint in joints:
        if joint.moves and joint.mimic is not None and joint.mimic[0] not in leaders:
            raise RobotError(
                f'{path}: joint {joint.name}: mimic joint="{joint.mimic[0]}": it must be one of '
                f"{', '.join(leaders) or 'none'}, which move and follow no other"
            )


def _merge_fixed(robot: Robot, joints: list[RobotJoint], base: str, path: Path) -> Robot:
    """Return the robot with fixed links as parts of those that move, joints from the base on."""
    by_parent: dict[str, list[RobotJoint]] = {}
    for joint in joints:
        by_parent.setdefault(joint.parent, []).append(joint)
    merged = Robot(robot.name, {base: []})
    identity = mpmath.eye(3), mpmath.zeros(3, 1)
    waiting = [(base, base, *identity, (0.0, 0.0, 0.0))]
    reached = set()
    while waiting:
        link, body, turn, place, _ = waiting.pop(0)
        reached.add(link)
        merged.links[body] += [_move(part, turn, place) for part in robot.links[link]]
        for joint in by_parent.get(link, ()):
            at, rotation = place + turn * joint.place, turn * joint.turn
            if joint.moves:
                moved = replace(joint, parent=body, place=at, angles=_find_angles(rotation))
                if turn == identity[0]:
                    moved = replace(moved, angles=joint.angles)
                merged.joints.append(moved)
                merged.links[joint.child] = []
                waiting.append((joint.child, joint.child, *identity, (0.0, 0.0, 0.0)))
            else:
                waiting.append((joint.child, body, rotation, at, (0.0, 0.0, 0.0)))
    if missing := robot.links.keys() - reached:
        raise RobotError(f"{path}: {', '.join(sorted(missing))}: no chain of joints leads there")
    return merged


def _move(part: Inertial, turn: matrix, place: matrix) -> Inertial:
    return Inertial(part.mass, place + turn * part.centroid, turn * part.tensor * turn.T)


def _name(element: Element, path: Path) -> str:
    name = element.get("name")
    if not name:
        raise RobotError(f"{path}: a <{element.tag}> has no name")
    return name


def _read_numbers(
    element: Element | None, key: str, default: str, where: str, count: int = 3
) -> list[float]:
    text = default if element is None else element.get(key, default)
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        allowed = "a number" if count == 1 else f"{count} numbers"
        raise RobotError(f'{where}: {key}="{text}": it must be {allowed}')
    return numbers


def _read_positive(element: Element | None, key: str, where: str) -> float:
    """Return a number that is not negative, 0 if it is missing."""
    (value,) = _read_numbers(element, key, "0", where, 1)
    if value < 0:
        raise RobotError(f'{where}: {key}="{value:g}": it must not be negative')
    return value


def _read_inertial(link: Element, path: Path) -> Iterator[Inertial]:
    inertial = link.find("inertial")
    if inertial is None:
        return
    where = f"{path}: link {_name(link, path)}"
    mass = _read_positive(inertial.find("mass"), "value", f"{where}: mass")
    origin, tensor = inertial.find("origin"), mpmath.zeros(3)
    for entry in ENTRIES:
        element, key = inertial.find("inertia"), f"i{entry}"
        if entry in ("xx", "yy", "zz"):
            value = _read_positive(element, key, where)
        else:
            (value,) = _read_numbers(element, key, "0", where, 1)
        i, j = PLACES[entry]
        tensor[i, j] = tensor[j, i] = value
    turn = _turn(_read_numbers(origin, "rpy", "0 0 0", where))
    centroid = matrix(_read_numbers(origin, "xyz", "0 0 0", where))
    if mass:
        yield Inertial(mass, centroid, turn * tensor * turn.T)


def _read_joint(joint: Element, links: Mapping[str, object], path: Path) -> RobotJoint:
    name = _name(joint, path)
    where = f"{path}: joint {name}"
    kind = joint.get("type", "")
    if kind not in KINDS:
        raise RobotError(
            f"{where}: type {kind}: it must be one of {', '.join(KINDS)}; state other joints in "
            "Python (`free_frame`, `ball`, `wheel`)"
        )
    ends = [joint.find(tag) for tag in ("parent", "child")]
    parent, child = (str(end.get("link")) if end is not None else "" for end in ends)
    for link in (parent, child):
        if link not in links:
            raise RobotError(f"{where}: link {link}: there is no such link")
    origin, dynamics, mimic = (joint.find(tag) for tag in ("origin", "dynamics", "mimic"))
    axis = _read_numbers(joint.find("axis"), "xyz", "1 0 0", where)
    size = math.sqrt(sum(a * a for a in axis))
    if kind != "fixed" and size == 0:
        raise RobotError(f"{where}: its axis has no length")
    followed = None
    if mimic is not None:
        (factor,) = _read_numbers(mimic, "multiplier", "1", where, 1)
        (offset,) = _read_numbers(mimic, "offset", "0", where, 1)
        followed = (mimic.get("joint", ""), factor, offset)
    limit = joint.find("limit")
    limits = {
        key: _read_numbers(limit, key, "0", where, 1)[0]
        for key in ("lower", "upper", "effort", "velocity")
        if limit is not None and limit.get(key) is not None
    }
    for key in ("effort", "velocity"):
        _read_positive(limit, key, where)
    if limits.get("lower", 0.0) > limits.get("upper", 0.0) and kind != "continuous":
        raise RobotError(
            f'{where}: lower="{limits.get("lower", 0.0):g}" is above '
            f'upper="{limits.get("upper", 0.0):g}"'
        )
    damping, friction = (_read_positive(dynamics, key, where) for key in ("damping", "friction"))
    return RobotJoint(
        name=name,
        kind=kind,
        parent=parent,
        child=child,
        angles=_read_numbers(origin, "rpy", "0 0 0", where),
        place=matrix(_read_numbers(origin, "xyz", "0 0 0", where)),
        axis=[a / (size or 1.0) for a in axis],
        limits=limits,
        damping=damping,
        friction=friction,
        mimic=followed,
    )


def _turn(angles: Vector) -> matrix:
    """Return the rotation of roll, pitch and yaw: about x, then the fixed y, then the fixed z."""
    with mpmath.workdps(30):
        r, p, y = map(mpf, angles)
        (sr, sp, sy), (cr, cp, cy) = map(mpmath.sin, (r, p, y)), map(mpmath.cos, (r, p, y))
        return matrix(
            [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ]
        )


def _find_angles(turn: matrix) -> list[float]:
    """Return roll, pitch and yaw of a rotation; of a pitch of a right angle the roll is zero."""
    with mpmath.workdps(30):
        level = mpmath.sqrt(turn[0, 0] ** 2 + turn[1, 0] ** 2)
        pitch = mpmath.atan2(-turn[2, 0], level)
        if level > mpf(10) ** -20:
            roll = mpmath.atan2(turn[2, 1], turn[2, 2])
            yaw = mpmath.atan2(turn[1, 0], turn[0, 0])
        else:
            roll, yaw = mpf(0), mpmath.atan2(-turn[0, 1], turn[1, 1])
        return [float(angle) for angle in (roll, pitch, yaw)]


# --- the statement ------------------------------------------------------------------------------

HEAD = '''"""{title}: written from {file}; edit it as you like.

Lengths in m, angles in rad. Frames stand at the joints, turned by roll, pitch and yaw.
"""

from derive import Mechanism, X, Y, Z, creeping, quantities

q = quantities("""
{table}
""")
m = Mechanism("{name}", q, gravity=(0, 0, -q.g), spatial=True)
'''


def write_statement(path: Path) -> tuple[str, str]:
    """Return the name of a URDF file's robot and its statement in Python. Raises RobotError."""
    robot = read_robot(path)
    name = _identifier(robot.name)
    writer = _Writer(robot)
    lines = writer.list_lines()
    table = "\n".join(writer.rows)
    head = HEAD.format(title=_quoted(robot.name), file=path.name, table=table, name=name)
    return name, head + "\n".join(lines) + "\n"


def _identifier(text: str) -> str:
    name = re.sub(r"\W", "_", text)
    return name if name[:1].isalpha() else f"r_{name}"


def _quoted(text: str) -> str:
    return text.replace("\\", "/").replace('"', "'")


class _Writer:
    """Rows of the table, and lines of the statement."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.rows = [f"    g | m/s2 | free fall | {FALL}"]

    def list_lines(self) -> list[str]:
        base = next(iter(self.robot.links))
        frames, points, bodies = {base: "m.world"}, {base: "m.O"}, {base: "m.ground"}
        for unit in ("m", "rad"):
            if any(
                j.friction and (j.kind == "prismatic") == (unit == "m") for j in self.robot.joints
            ):
                meaning = "speed below which friction is smooth"
                self.rows.append(f"    creep_{unit} | {unit}/s | {meaning} | {CREEP}")
        lines: list[str] = []
        for joint in self._sort_joints():
            lines += ["", *self._print_joint(joint, frames, points, bodies)]
        # Balances of bodies need all reactions, which oblique and following joints do not state.
        is_whole = all(self._find_axis(joint) for joint in self.robot.joints)
        reported = "" if is_whole else 'reported=["kinetic", "potential"]'
        return [*lines, "", f"SYSTEM = m.system({reported})"]

    def _sort_joints(self) -> Iterator[RobotJoint]:
        """Yield joints, those that others follow before these where the tree allows."""
        waiting, ready = list(self.robot.joints), {next(iter(self.robot.links))}
        done: set[str] = set()
        while waiting:
            chosen = next(
                (
                    joint
                    for joint in waiting
                    if joint.parent in ready and (joint.mimic is None or joint.mimic[0] in done)
                ),
                None,
            )
            if chosen is None:
                names = ", ".join(joint.name for joint in waiting)
                raise RobotError(f"{names}: joints that they follow do not come before them")
            waiting.remove(chosen)
            ready.add(chosen.child)
            done.add(chosen.name)
            yield chosen

    def _print_joint(
        self,
        joint: RobotJoint,
        frames: dict[str, str],
        points: dict[str, str],
        bodies: dict[str, str],
    ) -> Iterator[str]:
        name, child = _identifier(joint.name), _identifier(joint.child)
        slides = joint.kind == "prismatic"
        coordinate = f"q_{name}"
        yield f"# {joint.name}: {joint.kind}{self._describe_limits(joint)}"
        if joint.mimic is None:
            unit = "m" if slides else "rad"
            yield f'{coordinate} = m.coordinate("{name}", "{unit}", "{_quoted(joint.name)}")'
        else:
            other, factor, offset = joint.mimic
            shift = f" + {offset!r}" if offset else ""
            yield f"{coordinate} = {factor!r} * q_{_identifier(other)}{shift}"
        frame = frames[joint.parent]
        place = self._add_vector(f"p_{name}", "m", f"place of {joint.name}", joint.place)
        yield f'P_{name} = m.point("P_{name}", {points[joint.parent]}, {frame}, {place})'
        for letter, angle in zip("ZYX", reversed(joint.angles), strict=True):
            if angle:
                yield f'f_{name} = m.frame("{name}_{letter}", {angle!r}, {letter}, {frame})'
                frame = f"f_{name}"
        at = f"P_{name}"
        direction = [0.0 if abs(a) < 1e-15 else a for a in joint.axis]
        if slides:
            path = ", ".join(f"{coordinate} * {a!r}" if a else "0" for a in direction)
            yield f'S_{name} = m.point("S_{name}", P_{name}, {frame}, {path})'
            at = f"S_{name}"
        else:
            yield from self._print_turn(name, coordinate, direction, frame)
            frame = f"f_{name}"
        frames[joint.child], points[joint.child] = frame, at
        bodies[joint.child] = f"b_{child}"
        yield from self._print_body(joint.child, child, frame, at)
        if joint.mimic is None:
            yield from self._print_forces(
                joint, f"b_{child}", bodies[joint.parent], frames[joint.parent], at
            )

    def _describe_limits(self, joint: RobotJoint) -> str:
        limits = joint.limits
        unit = "m" if joint.kind == "prismatic" else "rad"
        if joint.kind == "continuous" or not {"lower", "upper"} <= limits.keys():
            return ""
        return f", from {limits['lower']:g} to {limits['upper']:g} {unit}"

    def _print_turn(
        self, name: str, coordinate: str, axis: Sequence[float], frame: str
    ) -> Iterator[str]:
        target = f"f_{name}"
        for letter, index in (("X", 0), ("Y", 1), ("Z", 2)):
            if abs(axis[index]) == 1:
                sign = "-" if axis[index] < 0 else ""
                yield f'{target} = m.frame("{name}", {sign}{coordinate}, {letter}, {frame})'
                return
        yaw, pitch = math.atan2(axis[1], axis[0]), math.atan2(math.hypot(*axis[:2]), axis[2])
        turns = ((yaw, "Z"), (pitch, "Y"), (coordinate, "Z"), (-pitch, "Y"), (-yaw, "Z"))
        for number, (angle, letter) in enumerate(turns):
            label = name if number == len(turns) - 1 else f"{name}_{number}"
            yield f'{target} = m.frame("{label}", {angle}, {letter}, {frame})'
            frame = target

    def _print_body(self, link: str, child: str, frame: str, at: str) -> Iterator[str]:
        parts = self.robot.links[link]
        if not parts:
            yield f'b_{child} = m.body("{child}", {frame})'
            return
        joined = _join(parts)
        self.rows.append(f"    m_{child} | kg | mass of {link} | {joined.mass!r}")
        centroid = self._add_vector(f"c_{child}", "m", f"centroid of {link}", joined.centroid)
        inertia = []
        for entry in ENTRIES:
            value = float(joined.tensor[PLACES[entry]])
            inertia.append(self._add(f"I_{child}_{entry}", "kg m2", f"{link}, {entry}", value))
        yield f'C_{child} = m.point("C_{child}", {at}, {frame}, {centroid})'
        yield f"inertia = {', '.join(inertia)}"
        yield f'b_{child} = m.body("{child}", {frame}, q.m_{child}, C_{child}, inertia)'

    def _add_vector(self, name: str, unit: str, meaning: str, vector: matrix) -> str:
        parts = [
            self._add(f"{name}_{axis}", unit, f"{meaning}, {axis}", float(vector[i]))
            for i, axis in enumerate("xyz")
        ]
        return ", ".join(parts)

    def _add(self, name: str, unit: str, meaning: str, value: float) -> str:
        """Return a quantity of the table, or 0 for a zero."""
        if value == 0:
            return "0"
        self.rows.append(f"    {name} | {unit} | {_quoted(meaning)} | {value!r}")
        return f"q.{name}"

    def _print_forces(
        self, joint: RobotJoint, on: str, by: str, frame: str, at: str
    ) -> Iterator[str]:
        name, slides = _identifier(joint.name), joint.kind == "prismatic"
        unit, rate = ("N", f"m.rate(q_{name})") if slides else ("N m", f"m.rate(q_{name})")
        if (letter := self._find_axis(joint)) is not None:
            yield f'm.{"slide" if slides else "pin"}("{name}", {on}, {by}, {at}, {letter})'
        effort = joint.limits.get("effort")
        ends = f", low={-effort!r}, high={effort!r}" if effort else ""
        meaning = f"drive of {_quoted(joint.name)}"
        yield f'T_{name} = m.input("T_{name}", "{unit}", "{meaning}"{ends})'
        load = f"T_{name}"
        if joint.damping:
            damper = self._add(
                f"d_{name}", f"{unit} s/m" if slides else "N m s", "damping", joint.damping
            )
            load += f" - {damper} * {rate}"
        if joint.friction:
            limit = self._add(f"F_{name}", unit, "friction", joint.friction)
            creep = "q.creep_m" if slides else "q.creep_rad"
            load += f" - creeping({limit}, ({rate},), {creep}) * {rate}"
        axis = joint.turn * matrix(list(joint.axis))
        direction = ", ".join(repr(float(x)) if abs(x) > 1e-25 else "0" for x in axis)
        yield f"load = {load}"
        vector = f"load * m.vector({frame}, {direction})"
        if slides:
            yield f'm.force("drive_{name}", {on}, {at}, {vector}, {by})'
        else:
            yield f'm.torque("drive_{name}", {on}, {by}, {vector})'

    def _find_axis(self, joint: RobotJoint) -> str | None:
        """Return the axis of the parent's frame along which that of a joint lies, None if none."""
        axis = [abs(float(x)) for x in joint.turn * matrix(list(joint.axis))]
        index = max(range(3), key=axis.__getitem__)
        is_aligned = sum(axis) - axis[index] < ALIGNED
        return "XYZ"[index] if is_aligned and joint.mimic is None else None


def _join(parts: Sequence[Inertial]) -> Inertial:
    """Return the body of several parts."""
    mass = math.fsum(part.mass for part in parts)
    centroid = matrix([mpf(0)] * 3)
    for part in parts:
        centroid += part.mass * part.centroid / mass
    tensor = mpmath.zeros(3)
    for part in parts:
        d = part.centroid - centroid
        square = (d.T * d)[0]
        tensor += part.tensor + part.mass * (square * mpmath.eye(3) - d * d.T)
    return Inertial(mass, centroid, tensor)
