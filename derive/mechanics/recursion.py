"""Equations of free motion from named steps: the residual of virtual power, and accelerations by
articulated inertias where the bodies form a tree.

    residual = inertia accelerations - forces

The articulated inertia of a body is what it opposes to an acceleration while the coordinates beyond
it are free (Featherstone, Rigid Body Dynamics Algorithms, New York 2008, chapter 7). Coordinates
that move a body against the one before it are eliminated one by one, so that a joint may have any
number of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..quantity import word
from .bodies import Action, Body
from .frames import Frame, Point, Triple, Vec, multiply_cross
from .motion_steps import (
    GIVEN,
    NOTHING,
    MotionSteps,
    Slopes,
    add_slopes,
    add_triples,
    dot_product,
    scale_triple,
)
from .statement import Statement

Six = tuple[Expr, ...]
"""Components of a turn, then of a displacement; or of a moment, then of a force."""
Square = list[list[Expr]]
UNITS = ("kg m2", "kg m", "kg")
"""Of an inertia between two turns, a turn and a displacement, two displacements."""
SIX = ("rx", "ry", "rz", "x", "y", "z")


class Loads:
    """The loads of bodies in the steps of a motion: given actions, weights and inertia."""

    def __init__(self, stated: Statement, motion: MotionSteps, actions: Sequence[Action]) -> None:
        self.stated, self.motion, self._actions = stated, motion, actions
        for body in self.bodies:
            for part in body.parts:
                motion.acceleration(part.centroid, motion.world)
                motion.momentum_rate(part.tensor, body.frame)
        self._pushes = [
            (
                self._name("p", "N", action, action.force),
                self._name("q", "N m", action, action.moment),
            )
            for action in actions
        ]

    def _name(self, stem: str, unit: str, action: Action, load: Vec) -> Triple:
        plain = self.motion.write_plain(self.motion.to_world(load))
        label = f"{stem}_{word(action.name)}_{word(action.on.name)}"
        return self.motion.name_all(label, unit, plain)

    @property
    def bodies(self) -> list[Body]:
        """The bodies that can move."""
        return [body for body in self.stated.assembly.bodies if body != self.stated.earth]

    def resist(self, body: Body, at: Point) -> tuple[Triple, Triple]:
        """Return moment about a point [N m] and force [N] that the motion of a body needs beside
        what acts on it.
        """
        motion, gravity = self.motion, self.stated.assembly.gravity
        moments, forces = [NOTHING], [NOTHING]
        for number, part in enumerate(body.parts, 1):
            fall = scale_triple(S.NegativeOne, motion.to_world(gravity))
            rise = add_triples(motion.acceleration(part.centroid, motion.world).components, fall)
            label = f"i_{word(body.name)}" + (f"_{number}" if number > 1 else "")
            force = motion.name_all(label, "N", scale_triple(part.mass, rise))
            moments.append(motion.momentum_rate(part.tensor, body.frame).components)
            moments.append(multiply_cross(motion.reach(at, part.centroid), force))
            forces.append(force)
        for action, (force, moment) in zip(self._actions, self._pushes, strict=True):
            if sign := -action.sign(body):
                moments.append(scale_triple(sp.Integer(sign), moment))
                arm = motion.reach(at, action.at) if any(force) else NOTHING
                moments.append(scale_triple(sp.Integer(sign), multiply_cross(arm, force)))
                forces.append(scale_triple(sp.Integer(sign), force))
        return add_triples(*moments), add_triples(*forces)

    def find_residuals(self) -> list[Expr]:
        """Return the virtual power of all loads on the rate of each coordinate."""
        forces: dict[Point, list[Triple]] = {}
        moments: dict[Frame, list[Triple]] = {}
        for body in self.bodies:
            at = self.stated.anchor(body)
            moment, force = self.resist(body, at)
            forces.setdefault(at, []).append(force)
            moments.setdefault(body.frame, []).append(moment)
        return self.motion.collect_power(forces, moments)


@dataclass(eq=False)
class Link:
    """Bodies that do not move against each other, and what moves them against the link before.

    `at` is a point fixed in them, which the link before carries at a distance `reach` [m]; where
    `turns` is 1, they turn with it, too. `ways` are the slopes of spin and velocity in the rates of
    their own coordinates.
    """

    bodies: list[Body]
    at: Point
    before: Link | None = None
    turns: int = 0
    reach: Triple = NOTHING
    ways: dict[int, Six] = field(default_factory=dict)


class Tree:
    """Links of a mechanism, each with coordinates of its own; `links` is None where a coordinate
    moves several of them against those before, as in gears.
    """

    def __init__(self, loads: Loads, count: int) -> None:
        self._loads, self._motion = loads, loads.motion
        self._by_place: dict[tuple[Point, Frame], Link] = {}
        for body in loads.bodies:
            base = self._motion.base(body.frame)
            at = self._climb(loads.stated.anchor(body), base)
            self._by_place.setdefault((at, base), Link([], at)).bodies.append(body)
        for link in self._by_place.values():
            self._find_before(link)
        owned = sorted(i for link in self._by_place.values() for i in link.ways)
        self.links = self._order() if owned == list(range(count)) else None

    def _climb(self, point: Point, base: Frame) -> Point:
        """Return the point nearest to the origin against which one is fixed in a frame."""
        while point.base is not None and point.offset is not None:
            if self._motion.base(point.offset.frame) != base or not self._motion.is_still(point):
                break
            point = point.base
        return point

    def _find_carrier(self, link: Link, point: Point) -> tuple[Link, Frame] | None:
        """Return the link in which a point is fixed, with its frame: of those that turn its offset
        or are stated earlier the one nearest to the link.
        """
        if point.offset is None:
            return None
        motion, turning = self._motion, self._motion.base(point.offset.frame)
        above = [motion.base(frame) for frame in motion.chain(link.bodies[0].frame)]
        best, carrier, is_earlier = (-1, False), None, True
        for (at, base), other in self._by_place.items():
            is_earlier = is_earlier and other is not link
            rank = above.index(base) if base in above else 0, base == turning
            if other is link or not (is_earlier or base == turning) or rank <= best:
                continue
            if self._climb(point, base) == at:
                best, carrier = rank, (other, base)
        return carrier

    def _climb_frames(self, frame: Frame, end: Frame | None) -> tuple[list[Frame], bool]:
        """Return the frames from one up to the base of another, and whether it is reached."""
        passed: list[Frame] = []
        while self._motion.base(frame) != end:
            parent = self._motion.frame(frame).parent
            if parent is None:
                return passed, False
            passed.append(frame)
            frame = parent
        return passed, True

    def _find_before(self, link: Link) -> None:
        """Find the link before one, and what moves it against that."""
        motion, point, end = self._motion, link.at, None
        offsets: list[Point] = []
        while (carrier := self._find_carrier(link, point)) is None and point.base is not None:
            offsets.append(point)
            point = point.base
        reach, speeds = [NOTHING], list[Slopes]()
        if carrier is not None:
            link.before, end = carrier
            reach.append(motion.reach(link.before.at, point))
        passed, is_carried = self._climb_frames(link.bodies[0].frame, end)
        link.turns = int(is_carried)
        spins = add_slopes([motion.spin_slopes(frame) for frame in passed])
        for offset in offsets:
            assert offset.offset is not None
            passed, is_carried = self._climb_frames(offset.offset.frame, end)
            reach += [motion.offset(offset)] if is_carried else []
            speeds.append(motion.stretch_slopes(offset))
            for frame in passed:
                for i, spin in motion.spin_slopes(frame).items():
                    speeds.append({i: multiply_cross(spin, motion.offset(offset))})
        velocity = add_slopes(speeds)
        link.reach = add_triples(*reach)
        for i in sorted(spins.keys() | velocity.keys()):
            link.ways[i] = (*spins.get(i, NOTHING), *velocity.get(i, NOTHING))

    def _order(self) -> list[Link] | None:
        """Return the links, each after the one before it; None if they go round in a circle."""
        waiting, ordered = list(self._by_place.values()), list[Link]()
        while waiting:
            ready = [link for link in waiting if link.before is None or link.before in ordered]
            if not ready:
                return None
            ordered += ready
            waiting = [link for link in waiting if link not in ready]
        return ordered


class ArticulatedInertias:
    """Accelerations of the coordinates of a tree, in steps of a motion without accelerations."""

    def __init__(self, loads: Loads, links: Sequence[Link], count: int) -> None:
        self._loads, self._motion, self._links = loads, loads.motion, links
        self._count = count

    def define_accelerations(self) -> None:
        """Define the accelerations of the coordinates."""
        inertias = [self._find_inertia(link) for link in self._links]
        loads = [self._find_load(link) for link in self._links]
        solved: list[Expr] = [S.Zero] * self._count
        places = {link: n for n, link in enumerate(self._links)}
        eliminated: list[list[tuple[int, Six, Six, Expr]]] = [[] for _ in self._links]
        for n, link in reversed(list(enumerate(self._links))):
            inertia = self._name_inertia(link, inertias[n])
            load = self._name_load(link, loads[n])
            for number, (i, way) in enumerate(link.ways.items()):
                if number:
                    stem = f"A_{self._label(link)}_{number}"
                    inertia = self._name_square(stem, inertia)
                    load = self._name_load(link, load)
                inertia, load, step = self._eliminate(link, i, way, inertia, load)
                eliminated[n].append(step)
            if link.before is not None:
                m = places[link.before]
                inertias[m] = _add_squares(inertias[m], self._carry(link, inertia))
                loads[m] = _plus(loads[m], self._carry_load(link, load))
        changes: list[Six] = []
        for n, link in enumerate(self._links):
            change = self._follow(link, changes[places[link.before]] if link.before else None)
            change = self._name_six(f"h_{self._label(link)}", ("rad/s2", "m/s2"), change)
            for i, way, share, size in reversed(eliminated[n]):
                symbol = self._motion.coordinates[i].acceleration
                solved[i] = self._motion.define(symbol, size - dot_product(share, change), GIVEN)
                change = _plus(change, tuple(w * solved[i] for w in way))
            stem = f"g_{self._label(link)}"
            changes.append(self._name_six(stem, ("rad/s2", "m/s2"), change))

    def _label(self, link: Link) -> str:
        return word(link.bodies[0].name)

    def _name_six(self, stem: str, units: Sequence[str], six: Sequence[Expr]) -> Six:
        named = (
            self._motion.name(f"{stem}_{axis}", units[n // 3], component)
            for n, (axis, component) in enumerate(zip(SIX, six, strict=True))
        )
        return tuple(named)

    def _find_inertia(self, link: Link) -> Square:
        """Return the inertia of the bodies of a link about its point."""
        total = [[S.Zero] * 6 for _ in range(6)]
        for body in link.bodies:
            for part in body.parts:
                x, y, z = arm = self._motion.reach(link.at, part.centroid)
                square, mass = sum(a * a for a in arm), part.mass
                cross = (S.Zero, -z, y), (z, S.Zero, -x), (-y, x, S.Zero)
                tensor = self._motion.tensor(part.tensor, body.frame)
                for a in range(3):
                    total[a + 3][a + 3] += mass
                    total[a][a] += mass * square
                    for b in range(3):
                        total[a][b] += tensor[a][b] - mass * arm[a] * arm[b]
                        total[a][b + 3] += mass * cross[a][b]
                        total[b + 3][a] += mass * cross[a][b]
        return total

    def _find_load(self, link: Link) -> Six:
        total: Six = (S.Zero,) * 6
        for body in link.bodies:
            moment, force = self._loads.resist(body, link.at)
            total = _plus(total, (*moment, *force))
        return total

    def _name_inertia(self, link: Link, inertia: Square) -> Square:
        return self._name_square(f"A_{self._label(link)}", inertia)

    def _name_square(self, stem: str, square: Square) -> Square:
        named = [list(row) for row in square]
        for a, b in _list_entries():
            unit = UNITS[a // 3 + b // 3]
            name = f"{stem}_{SIX[a]}_{SIX[b]}"
            entry = self._motion.name(name, unit, square[a][b])
            named[a][b] = named[b][a] = entry
        return named

    def _name_load(self, link: Link, load: Six) -> Six:
        return self._name_six(f"P_{self._label(link)}", ("N m", "N"), load)

    def _eliminate(
        self, link: Link, i: int, way: Six, inertia: Square, load: Six
    ) -> tuple[Square, Six, tuple[int, Six, Six, Expr]]:
        """Return inertia and load with a coordinate free, and what its acceleration follows from:
        its place, its way, its share of the link's acceleration, and what it is without that.
        """
        symbol, name = (
            self._motion.coordinates[i].acceleration,
            str(self._motion.coordinates[i].value),
        )
        units = ("kg m2", "kg m") if symbol.unit == "rad/s2" else ("kg m", "kg")
        moved = [dot_product(row, way) for row in inertia]
        carried = self._name_six(f"U_{name}", units, moved)
        pivot = self._motion.name(f"D_{name}", units[0], dot_product(way, carried))
        shares = self._name_six(f"S_{name}", ("1", "1"), tuple(c / pivot for c in carried))
        size = self._motion.name(f"s_{name}", symbol.unit, -dot_product(way, load) / pivot)
        left = [[S.Zero] * 6 for _ in range(6)]
        for a, b in _list_entries():
            share = carried[b] * shares[a] if shares[a] == 1 else carried[a] * shares[b]
            left[a][b] = left[b][a] = inertia[a][b] - share
        load = _plus(load, tuple(c * size for c in carried))
        if (axis := _find_axis(way)) is not None:  # nothing is left along it
            load = tuple(S.Zero if n == axis else c for n, c in enumerate(load))
        return left, load, (i, way, shares, size)

    def _carry(self, link: Link, inertia: Square) -> Square:
        """Return an inertia as the link before feels it."""
        turns, arm = link.turns, link.reach
        cross = (S.Zero, -arm[2], arm[1]), (arm[2], S.Zero, -arm[0]), (-arm[1], arm[0], S.Zero)
        if any(arm):
            inertia = self._name_square(f"B_{self._label(link)}", inertia)
        total = [[S.Zero] * 6 for _ in range(6)]
        mixed = [[turns * inertia[a][b + 3] for b in range(3)] for a in range(3)]
        for a in range(3):
            for b in range(3):
                mixed[a][b] += sum(cross[a][n] * inertia[n + 3][b + 3] for n in range(3))
                total[a + 3][b + 3] = inertia[a + 3][b + 3]
        label = self._label(link)
        for a in range(3):
            for b in range(3):
                stem = f"H_{label}_{SIX[a]}_{SIX[b + 3]}"
                mixed[a][b] = self._motion.name(stem, "kg m", mixed[a][b])
                total[a][b + 3] = total[b + 3][a] = mixed[a][b]
        for a in range(3):
            for b in range(a, 3):
                entry = turns * inertia[a][b]
                entry += sum(cross[a][n] * mixed[b][n] for n in range(3))
                entry -= turns * sum(inertia[a][n + 3] * cross[n][b] for n in range(3))
                total[a][b] = total[b][a] = entry
        return total

    def _carry_load(self, link: Link, load: Six) -> Six:
        force = (load[3], load[4], load[5])
        turned = multiply_cross(link.reach, force)
        moment = tuple(link.turns * a + b for a, b in zip(load[:3], turned, strict=True))
        return (*moment, *force)

    def _follow(self, link: Link, change: Six | None) -> Six:
        """Return the acceleration of a link that the one before gives it."""
        if change is None:
            return (S.Zero,) * 6
        turn, push = (change[0], change[1], change[2]), change[3:]
        swept = multiply_cross(turn, link.reach)
        moved = (a + b for a, b in zip(push, swept, strict=True))
        return (*(link.turns * a for a in turn), *moved)


def _find_axis(way: Six) -> int | None:
    """Return the number of the only component that is not zero, if that is one."""
    filled = [n for n, component in enumerate(way) if component != 0]
    return filled[0] if len(filled) == 1 and way[filled[0]] == 1 else None


def _list_entries() -> Iterator[tuple[int, int]]:
    """Yield the places of a symmetric matrix's upper half."""
    return ((a, b) for a in range(6) for b in range(a, 6))


def _plus(first: Six, second: Six) -> Six:
    return tuple(a + b for a, b in zip(first, second, strict=True))


def _add_squares(first: Square, second: Square) -> Square:
    return [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(first, second, strict=True)]
