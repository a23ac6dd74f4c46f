"""Closed loops: their coordinates along a turn, of many machines at once, one machine in each lane.

The coordinates are followed from angle to angle, from an assembly that must not change: secant
predictor, then Newton's method. A lane that does not close takes half the step; where the least
step does not close either, the machine has a dead point.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers, Kernel
from planter.kernels.elimination import solve_system
from planter.progress import name_step

VECTOR = 8
"""Lanes that a processor takes at once, at most."""
LARGEST_STEP = np.pi / 180
"""Largest step of the walk [rad]; one that does not close is halved."""
LEAST_STEP = 1e-5
"""Least step of the walk [rad]."""


@dataclass
class WalkLanes:
    """The state of the lanes of a walk: an entry, or a column, for each.

    `index` is the angle that a lane goes to next, `at` where it is, `before` where it was a step
    before, `target` where Newton's method closes it now, from `guess`, after `calls`; a lane is
    `settled` if it needs another target. Lanes that are not `running` repeat one that is.
    """

    lane: Integers
    d: Array
    senses: Array
    index: Integers
    at: Array
    q: Array
    before: Array
    q_before: Array
    step: Array
    target: Array
    guess: Array
    calls: Integers
    settled: Flags
    running: Flags

    @classmethod
    def at_start(cls, d: Array, senses: Array, q: Array, index: int) -> WalkLanes:
        """Return lanes at angle 0, on their way to the angle of an index."""
        count = senses.shape[1]
        return cls(
            lane=np.arange(count),
            d=d.copy(),
            senses=senses.copy(),
            index=np.full(count, index),
            at=np.zeros(count),
            q=q.copy(),
            before=np.zeros(count),
            q_before=q.copy(),
            step=np.full(count, LARGEST_STEP),
            target=np.zeros(count),
            guess=q.copy(),
            calls=np.zeros(count, dtype=np.int64),
            settled=np.ones(count, dtype=bool),
            running=np.ones(count, dtype=bool),
        )

    def compact(self) -> WalkLanes:
        """Return the lanes that are running, filled up with others to full vectors."""
        count = np.count_nonzero(self.running)
        order = np.argsort(~self.running, kind="stable")[: count + -count % VECTOR]
        return WalkLanes(
            **{name: np.ascontiguousarray(array[..., order]) for name, array in vars(self).items()}
        )

    def aim(self, angles: Array) -> None:
        """Set target and guess, by the secant through the last two places, where a lane is
        settled.
        """
        reach, following = self.at + self.step, angles[self.index]
        target = np.where(reach > following - LEAST_STEP, following, reach)
        distance = self.at - self.before
        slope = np.divide(
            self.q - self.q_before, distance, out=np.zeros_like(self.q), where=distance > 0
        )
        guess = self.q + slope * (target - self.at)
        settled = self.settled
        if settled.all():
            self.target, self.guess, self.calls = target, guess, np.zeros_like(self.calls)
        else:
            self.target, self.guess = (
                np.where(settled, target, self.target),
                np.where(settled, guess, self.guess),
            )
            self.calls = np.where(settled, 0, self.calls)

    def move(self, accepted: Flags, refused: Flags, q: Array) -> None:
        """Take lanes that closed to their targets and double their steps, halve those of lanes that
        did not close.
        """
        if accepted.all():
            self.before, self.q_before, self.at, self.q = self.at, self.q, self.target, q
            self.step, self.settled = np.minimum(2 * self.step, LARGEST_STEP), accepted
            return
        self.settled, self.calls = accepted | refused, self.calls + 1
        self.guess = np.where(self.settled, self.guess, q)
        self.before, self.q_before = (
            np.where(accepted, self.at, self.before),
            np.where(accepted, self.q, self.q_before),
        )
        self.at, self.q = np.where(accepted, self.target, self.at), np.where(accepted, q, self.q)
        changed = np.where(accepted, np.minimum(2 * self.step, LARGEST_STEP), self.step / 2)
        self.step = np.where(self.settled, changed, self.step)

    def stop(self, ended: Flags) -> None:
        """End lanes: they go along with one that is running, so that they cost no further steps."""
        self.running = self.running & ~ended
        if ended.any() and self.running.any():
            guide, lost = int(np.argmax(self.running)), np.flatnonzero(~self.running)
            for name, array in vars(self).items():
                if name not in ("lane", "running"):
                    array[..., lost] = array[..., [guide]]


TURN = 2 * np.pi
UNROLLED = 3
"""Steps of Newton's method in a call: from the predictor at the largest step, two steps close a
loop to rounding.
"""
MOST_ITERATIONS = 16
"""Calls until a lane that has not closed is given up."""
CLOSED = 1e-13
"""A loop is closed where Newton's next step is below this share of the coordinates' size."""
SINGULAR = 1e-9
"""The Jacobian counts as singular if a pivot is below this share of the largest entry of its
column.
"""
COMPACTED_SHARE = 0.9
"""Lanes of a walk are put together, in fewer vectors, where no more than this share of them is
running.
"""
KEPT_COURSES = 8
"""Number of machines whose coordinates over a turn are kept."""
RETURNED = 1e-6
"""A coordinate that differs by less after a turn, apart from whole turns, has returned [m or
rad].
"""


def split_gaps(closure: ca.SX, size: int) -> tuple[ca.SX, ca.SX]:
    """Return the gaps (c,) of loops and their Jacobian (c, c), which follows them row by row in a
    closure.
    """
    return closure[:size], ca.reshape(closure[size:], size, size).T


@dataclass(frozen=True)
class KinematicLoops:
    """The loops of a machine: `gaps` (phi, d, q) -> gaps (c,) and their Jacobian row by row,
    `assembly` d -> q.

    `names` and `units` are those of the coordinates, `gap_names` those of the gaps.
    """

    gaps: ca.Function
    assembly: ca.Function
    names: tuple[str, ...]
    units: tuple[str, ...]
    gap_names: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of coordinates, c."""
        return len(self.names)

    @cached_property
    def steps_function(self) -> ca.Function:
        """(phi, d, q) -> q after `UNROLLED` steps of Newton's method, relative size of the last,
        senses, least pivot.

        The senses (l,) are those of the Jacobian at the last step, of each loop that can be closed
        alone, and the pivot is the least of all steps (`planter.kernels.elimination`).
        """
        size = self.size
        phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", self.gaps.numel_in(1)), ca.SX.sym("q", size)
        at, step, senses, pivot = q, ca.SX(0), ca.SX(0), ca.SX(1)
        for _ in range(UNROLLED):
            gaps, jacobian = split_gaps(self.gaps(phi, d, at), size)
            solved = solve_system(jacobian, -gaps)
            at = at + solved.solution
            step = ca.mmax(ca.fabs(solved.solution) / (1 + ca.fabs(at)))
            senses, pivot = solved.senses, ca.fmin(pivot, solved.pivot)
        outputs = ca.cse([ca.densify(output) for output in (at, step, senses, pivot)])
        names = ["next", "step", "senses", "pivot"]
        return ca.Function("newton", [phi, d, q], outputs, ["phi", "d", "q"], names)

    @property
    def count(self) -> int:
        """Number of loops that can be closed alone, l."""
        return int(self.steps_function.numel_out("senses"))

    @cached_property
    def _steps(self) -> Kernel:
        return Kernel(self.steps_function, lanes=["phi", "d", "q"])

    @cached_property
    def start_function(self) -> ca.Function:
        """(d) -> q, the assembly that a turn begins with."""
        d = ca.SX.sym("d", self.assembly.numel_in(0))
        return ca.Function("assemble", [d], [ca.densify(self.assembly(d))], ["d"], ["q"])

    @cached_property
    def value_indices(self) -> Integers:
        """Indices of the values d on which the coordinates depend, such as lengths, but not
        masses.
        """
        phi, d, q = (
            ca.SX.sym("phi"),
            ca.SX.sym("d", self.gaps.numel_in(1)),
            ca.SX.sym("q", self.size),
        )
        graph = ca.vertcat(ca.vec(self.gaps(phi, d, q)), ca.vec(self.assembly(d)))
        return np.flatnonzero(ca.which_depends(graph, d))

    def are_same(self, d: Array, other: Array) -> bool:
        """Return whether machines with values d (v,) and others have the same coordinates."""
        return np.array_equal(d[self.value_indices], other[self.value_indices])

    @cached_property
    def _start(self) -> Kernel:
        return Kernel(self.start_function, lanes=["d"])

    def compile(self) -> None:
        """Compile what the walk calls."""
        self._steps.compile()

    def close(self, phi: Array, d: Array, q: Array) -> tuple[Array, Array, Flags]:
        """Return coordinates (c, n) near others, the senses of the loops (l, n), and which lanes
        closed.

        A lane has not closed where its Jacobian was singular on the way.
        """
        closed = failed = np.zeros(q.shape[1], dtype=bool)
        senses = np.ones((self.count, q.shape[1]))
        for _ in range(MOST_ITERATIONS):
            out, finite = self._steps.masked(phi=phi, d=d, q=q)
            good = finite & (out["pivot"][0] > SINGULAR)
            converged = good & (out["step"][0] <= CLOSED)
            if converged.all() and not (closed.any() or failed.any()):
                return out["next"], out["senses"], converged
            active = ~(closed | failed)
            q = np.where(active & good, out["next"], q)
            senses = np.where(active & good, out["senses"], senses)
            closed, failed = closed | (active & converged), failed | (active & ~good)
            if (closed | failed).all():
                break
        return q, senses, closed

    def find_near(self, phi: Array, d: Array, q: Array) -> Array | None:
        """Return coordinates (c, n) near others, or None where they lead to no common assembly."""
        q, senses, closed = self.close(phi, d, q)
        return q if closed.all() and (senses * senses[:, :1] > 0).all() else None

    def walk(self, d: Array, angles: Array) -> LoopWalk:
        """Return a walk of machines with values d (v, lanes) along increasing angles (n,) from 0 on
        [rad].
        """
        return LoopWalk(self, d, angles)

    def course(self, name: str, d: Array) -> LoopCoordinates:
        """Return the coordinates of one machine with values d (v,) over a turn.

        The last ones are kept. Raises ComputationError where a loop does not close, at a dead
        point, and if a turn does not lead back.
        """
        key = name, d[self.value_indices].tobytes()
        course = self._courses.get(key)
        if course is None:
            course = self._courses[key] = LoopCoordinates(self, name, d)
            if len(self._courses) > KEPT_COURSES:
                self._courses.pop(next(iter(self._courses)), None)
        return course

    @cached_property
    def _courses(self) -> dict[tuple[str, bytes], LoopCoordinates]:
        return {}


class LoopWalk:
    """Coordinates of loops along angles, a machine in each lane, none of which waits for another.

    `places` (c, n, lanes) are the coordinates at the angles, without meaning beyond what a lane
    `reached` (lanes,), the angle at which it ended; `alive` (lanes,) are the lanes that came to the
    end. `first` and `last` (c, lanes) are the coordinates at the start and at the end, and
    `assembled` (lanes,) the lanes that closed at the start.
    """

    def __init__(self, loops: KinematicLoops, d: Array, angles: Array) -> None:
        self.loops, self.angles = loops, angles
        d = np.ascontiguousarray(d, dtype=float)
        count = d.shape[1]
        start, finite = loops._start.masked(d=d)
        self.first, senses, closed = loops.close(np.zeros(count), d, np.nan_to_num(start["q"]))
        self.assembled = closed & finite
        self.alive, self.last = self.assembled.copy(), self.first.copy()
        self.reached = np.where(self.alive, np.inf, 0.0)
        begun = int(np.searchsorted(angles, 0.0, side="right"))
        self.places = np.zeros((loops.size, len(angles), count))
        self.places[:, :begun] = self.first[:, None]
        if begun == len(angles):
            return
        lanes = WalkLanes.at_start(d, senses, self.first, begun)
        lanes.stop(~self.alive)
        while lanes.running.any():
            if np.count_nonzero(lanes.running) + VECTOR <= COMPACTED_SHARE * len(lanes.running):
                lanes = lanes.compact()
            self._advance(lanes)

    def _advance(self, lanes: WalkLanes) -> None:
        """Let each lane take a few steps of Newton's method, and go on, or back, where these have
        ended.
        """
        lanes.aim(self.angles)
        out, finite = self.loops._steps.masked(phi=lanes.target, d=lanes.d, q=lanes.guess)
        good = finite & (out["pivot"][0] > SINGULAR)
        closed = good & (out["step"][0] <= CLOSED)
        accepted = closed & (out["senses"] * lanes.senses > 0).all(axis=0)
        refused = ~accepted & (closed | ~good | (lanes.calls + 1 >= MOST_ITERATIONS))
        lanes.move(accepted, refused, out["next"])
        arrived = accepted & (lanes.at >= self.angles[lanes.index])
        if arrived.any():
            self._arrive(lanes, arrived)
        if refused.any():
            ended = refused & lanes.running & (lanes.step <= LEAST_STEP)
            chosen = lanes.lane[ended]
            self.alive[chosen], self.reached[chosen] = False, lanes.at[ended]
            self._end(lanes, ended)

    def _arrive(self, lanes: WalkLanes, arrived: Flags) -> None:
        """Store the places of lanes at their angles; a lane at the last one has ended."""
        index = lanes.index[0]
        if len(arrived) == len(self.alive) and arrived.all() and (lanes.index == index).all():
            np.copyto(self.places[:, index], lanes.q, where=lanes.running)
        else:
            chosen = arrived & lanes.running
            self.places[:, lanes.index[chosen], lanes.lane[chosen]] = lanes.q[:, chosen]
        lanes.index = lanes.index + arrived
        ended = lanes.index == len(self.angles)
        if ended.any():
            lanes.index = np.minimum(lanes.index, len(self.angles) - 1)
            self._end(lanes, ended & lanes.running)

    def _end(self, lanes: WalkLanes, ended: Flags) -> None:
        if ended.any():
            self.last[:, lanes.lane[ended]] = lanes.q[:, ended]
            lanes.stop(ended)

    def gains(self) -> tuple[Array, Flags]:
        """Return what coordinates (c, lanes) gained since the start, as whole turns, and which
        lanes returned.
        """
        gained = self.last - self.first
        angular = np.array([unit == "rad" for unit in self.loops.units])[:, None]
        turns = np.where(angular, TURN * np.round(gained / TURN), 0.0)
        return turns, np.asarray(self.alive & (np.abs(gained - turns) <= RETURNED).all(axis=0))


class LoopCoordinates:
    """The coordinates of one machine's loops over a turn, found once, then anywhere."""

    def __init__(self, loops: KinematicLoops, name: str, d: Array) -> None:
        self.loops, self.name, self.d = loops, name, np.asarray(d, dtype=float)
        with name_step(f"{name}: closing the loops over a turn"):
            walk = loops.walk(self.d[:, None], np.linspace(0.0, TURN, 361))
        if not walk.assembled[0]:
            raise ComputationError(
                f"{name}: at 0 deg, from the start that is given, {self._obstacle(0.0, walk.first)}"
            )
        if not walk.alive[0]:
            raise ComputationError(self._dead_point(walk))
        self.gained = self._returned(walk)
        self.angles, self.places = walk.angles, walk.places[:, :, 0]

    def move_to(self, d: Array) -> LoopCoordinates | None:
        """Return the course at other values d (v,), or None if it is not near this one.

        It begins as a walk would, from the assembly of those values.
        """
        lanes = np.repeat(d[:, None], len(self.angles), axis=1)
        q = self.loops.find_near(self.angles, lanes, self.places)
        first = self.loops.walk(d[:, None], np.empty(0)).first[:, 0]
        if (
            q is None
            or np.abs(np.column_stack([q[:, 0] - first, q[:, -1] - first - self.gained])).max()
            > RETURNED
        ):
            return None
        course = copy.copy(self)
        course.d, course.places = d, q
        return course

    def evaluate(self, angles: Array) -> Array:
        """Return the coordinates (c, n) at angles (n,) [rad] of any turn."""
        folded = np.mod(angles, TURN)
        guess = np.array([np.interp(folded, self.angles, row) for row in self.places])
        q = self.loops.find_near(folded, np.repeat(self.d[:, None], len(folded), axis=1), guess)
        if q is None:
            raise ComputationError(f"{self.name}: the loops do not close everywhere on the turn")
        return q + np.outer(self.gained, np.round((angles - folded) / TURN))

    def _returned(self, walk: LoopWalk) -> Array:
        """Return what the coordinates gain in a turn: lengths nothing, angles whole turns."""
        turns, returned = walk.gains()
        if not returned[0]:
            gained = walk.last[:, 0] - walk.first[:, 0]
            worst = int(np.argmax(np.abs(gained - turns[:, 0])))
            raise ComputationError(
                f"{self.name}: after a turn {self.loops.names[worst]} is not what it was (it "
                f"gains {gained[worst]:.6g} "
                f"{self.loops.units[worst]}): the mechanism does not repeat after one turn, or "
                f"its loops have come "
                "into another assembly"
            )
        return turns[:, 0]

    def _dead_point(self, walk: LoopWalk) -> str:
        at = float(walk.reached[0])
        names = ", ".join(self.loops.names)
        _, _, closed = self.loops.close(np.array([at + 2 * LEAST_STEP]), self.d[:, None], walk.last)
        beyond = (
            f"{names} go on in another assembly"
            if closed[0]
            else self._obstacle(at + 2 * LEAST_STEP, walk.last)
        )
        return f"{self.name}: dead point near {np.degrees(at):.6g} deg: beyond it {beyond}"

    def _obstacle(self, angle: float, q: Array) -> str:
        """Return the reason why the loops do not close at an angle."""
        gaps = self._gaps(phi=np.array([angle]), d=self.d[:, None], q=q)["gaps"][
            : self.loops.size, 0
        ]
        worst = int(np.argmax(np.abs(gaps)))
        if abs(gaps[worst]) <= CLOSED:
            return "the bars lie in line"
        return f"the loops do not close ({self.loops.gap_names[worst]} is {abs(gaps[worst]):.3g} m)"

    @cached_property
    def _gaps(self) -> Kernel:
        gaps = self.loops.gaps
        symbols = [ca.SX.sym(name, gaps.numel_in(i)) for i, name in enumerate(("phi", "d", "q"))]
        function = ca.Function(
            "gaps", symbols, [ca.densify(gaps(*symbols))], ["phi", "d", "q"], ["gaps"]
        )
        return Kernel(function, lanes=["phi", "d", "q"])
