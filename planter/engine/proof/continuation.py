"""Roots followed from the one assembly that is meant to all designs of a box and to all angles.

The way is cut into cells of designs and angles. In each, an interval Newton step shows that a ball
holds one root at every design and angle; where two cells meet, both have the same one. How cells
lie, and the numbers near roots in them, are those of `check_proof.py`; such numbers prove nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planter.engine.proof.check_proof import (
    MEANT,
    PARTS,
    follow_plainly,
    list_cells,
)
from planter.engine.proof.enclosures import ResponseProgram, RootBranch
from planter.engine.proof.intervals import U, Unbounded
from planter.engine.proof.jets import CENTRE, Space
from planter.engine.proof.roots import EnclosedRoots
from planter.kernels import Array, Flags

TURN = 2 * np.pi


@dataclass(frozen=True)
class AssemblyStart:
    """The one assembly that is meant: roots of each stage that has some at a design (p,) and the
    angle 0.
    """

    design: Array
    roots: Sequence[Sequence[float]] = ()

    def to_document(self) -> dict[str, Any]:
        """Return the assembly as a JSON object."""
        return {
            "design": [float(value).hex() for value in self.design],
            "roots": [[float(value).hex() for value in roots] for roots in self.roots],
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> AssemblyStart:
        """Return the assembly of a JSON object whose form was checked."""
        roots = [[float.fromhex(value) for value in values] for values in document["roots"]]
        return cls(np.array([float.fromhex(value) for value in document["design"]]), roots)

    def follow(self, response: ResponseProgram, lower: Array, upper: Array) -> RootBranch:
        """Return the roots that are meant over a box of designs, in finer parts if they are not
        followed to all angles.
        """
        if not response.rooted:
            return RootBranch(1.0, (), ())
        is_moving = not all(response.fixed[index] for index in response.rooted)
        for parts in PARTS:
            count = math.ceil(parts * response.period) if is_moving else 0
            branch = RootWay(response, self, lower, upper, count).follow()
            if branch.is_whole:
                break
        return branch


class RootWay:
    """A way from the assembly that is meant to a box [lower, upper] (p,), and around a period in
    `count` parts.
    """

    def __init__(
        self,
        response: ResponseProgram,
        start: AssemblyStart,
        lower: Array,
        upper: Array,
        count: int,
    ) -> None:
        self.response, self.starts, self.count = response, start.roots, count
        self.turn = TURN * float(response.period)
        origin, *box = (side.tolist() for side in (start.design, lower, upper))
        cells, self.points = list_cells(origin, box[0], box[1], self.turn, count)
        self.low, self.high = np.array(cells).transpose(1, 2, 0)
        self.stages, place = list[Any](), response.parameters + 1
        for index, stage in enumerate(response.stages):
            code, values = stage.solver if stage.limits else stage, range(place, place + stage.size)
            if index in response.feeding:
                entry = code.operations, code.outputs, stage.inputs, values, len(stage.limits)
                self.stages.append(entry)
            place += stage.size

    def follow(self) -> RootBranch:
        """Return the roots that are meant, in the parts to which they were followed."""
        middles = (self.low + (self.high - self.low) / 2).T.tolist()
        way: list[Any] = [self.points[0]]
        for middle, point in zip(middles, self.points[1:], strict=True):
            way += [(middle[:-1], middle[-1]), point]
        first, guesses = len(middles) - self.count, follow_plainly(self.stages, self.starts, way)
        cells = self._enclose(guesses)
        reached = np.logical_and.accumulate(cells.is_joined) & self._is_meant(cells)
        if not self.count or not reached[:first].all():
            return self._build(cells, reached)
        if reached.all():
            return self._build(cells, reached & cells.is_closed(cells, first))
        back = follow_plainly(self.stages, guesses[2 * first], way[: 2 * first : -1])
        backs = self._enclose([*guesses[: 2 * first + 1], *back[::-1]])
        ends = np.logical_and.accumulate(backs.is_joined[::-1])[::-1]
        ends &= backs.is_closed(cells, first)
        balls = [np.where(reached, *pair) for pair in zip(cells.balls, backs.balls, strict=True)]
        return self._build(replace(cells, balls=balls), reached | ends)

    def _is_meant(self, cells: CellRoots) -> bool:
        """Return whether the roots at the origin are those from which the way starts."""
        return all(
            bool((np.abs(joint[:, :, 0] - start) <= MEANT * (1 + np.abs(start))).all())
            for joint, start in zip(cells.joints, map(np.array, self.starts), strict=True)
        )

    def _enclose(self, guesses: Sequence[Any]) -> CellRoots:
        """Return the roots of all cells guesses some numbers, and those at the points between them."""
        points = np.array([[*x, phi] for x, phi in self.points]).T
        balls = [
            np.array([roots.points, roots.radii])
            for roots in self._find_roots(guesses[1::2], self.low, self.high)
        ]
        joints = []
        for roots in self._find_roots(guesses[::2], points, points):
            values = [jet.repeated(points.shape[1]).value[CENTRE] for jet in roots.jets]
            joints.append(np.array([[ball.low for ball in values], [ball.high for ball in values]]))
        return CellRoots(balls, joints)

    def _find_roots(self, numbers: Sequence[Any], low: Array, high: Array) -> list[EnclosedRoots]:
        """Return the roots of each stage over boxes of designs and angles (p + 1, lanes), NaN in
        lanes without any.
        """
        lanes = low.shape[1]
        guesses = [np.full((len(start), lanes), np.nan) for start in self.starts]
        for lane, roots in enumerate(numbers):
            for values, root in zip(guesses, roots or (), strict=False):
                values[:, lane] = root
        space = Space(low, high)
        try:
            with np.errstate(all="ignore"):
                return self.response.find_roots(space, space.parameters()[-1], guesses)
        except Unbounded:
            nothing = space.lift(np.full(lanes, np.nan))
            empty = [np.full_like(values, np.nan) for values in guesses]
            return [EnclosedRoots([nothing] * len(part), part, part) for part in empty]

    def _build(self, cells: CellRoots, reached: Flags) -> RootBranch:
        first, chosen = len(reached) - self.count, []
        for index, ball in zip(self.response.rooted, cells.balls, strict=True):
            is_fixed = self.response.fixed[index]
            part = slice(first - 1, first) if is_fixed else slice(first, None)
            chosen.append(np.where(reached, ball, np.nan)[:, :, part])
        return RootBranch(self.turn, tuple(b[0] for b in chosen), tuple(b[1] for b in chosen))


@dataclass(frozen=True)
class CellRoots:
    """Balls that hold one root in each cell, by midpoint and radius (2, k, cells), and ends (2, k,
    cells + 1) of the roots at the points between them, of each stage; NaN where there are none.
    """

    balls: Sequence[Array]
    joints: Sequence[Array]

    @property
    def is_joined(self) -> Flags:
        """Whether each cell has the roots at both of its points, (cells,)."""
        flags = [
            _is_inside(ball, joint[:, :, :-1]) & _is_inside(ball, joint[:, :, 1:])
            for ball, joint in zip(self.balls, self.joints, strict=True)
        ]
        return np.asarray(np.logical_and.reduce(flags))

    def is_closed(self, other: CellRoots, first: int) -> bool:
        """Return whether the roots at the last point are those that others have at the begin of the
        `first` cell of the period, but for whole turns.
        """
        flags = []
        for ball, begin, joint in zip(other.balls, other.joints, self.joints, strict=True):
            flags.append(bool(_is_inside(ball[:, :, first], begin[:, :, first])))
            turns = TURN * np.round((joint[0, :, -1] - ball[0, :, first]) / TURN)
            margin = 8 * U * (np.abs(joint[:, :, -1]) + np.abs(turns))
            ends = joint[:, :, -1] - turns + np.array([-margin[0], margin[1]])
            flags.append(bool(_is_inside(ball[:, :, first], ends)))
        return all(flags)


def _is_inside(ball: Array, ends: Array) -> Flags:
    """Return where balls (2, k, ...) hold all between two ends (2, k, ...)."""
    low, high = ball[0] - ball[1], ball[0] + ball[1]
    return np.asarray(((low <= ends[0]) & (ends[1] <= high)).all(axis=0))
