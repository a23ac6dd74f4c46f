"""Closed loops: their coordinates along a turn, of many machines at once, one machine in each lane.

The coordinates are followed from angle to angle, from an assembly that must not change: secant predictor, then
Newton's method. A lane that does not close takes half the step; where the least step does not close either, the
machine has a dead point.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, Kernel
from planter.numerics.arrays import Flags

TURN = 2 * np.pi
LARGEST_STEP = TURN / 360
"""Largest step of the walk [rad]; one that does not close is halved."""
LEAST_STEP = 1e-5
"""Least step of the walk [rad]."""
UNROLLED = 3
"""Steps of Newton's method in a call: from the predictor at the largest step, two steps close a loop to rounding."""
MOST_ITERATIONS = 16
"""Calls until a lane that has not closed is given up."""
CLOSED = 1e-13
"""A loop is closed where Newton's next step is below this share of the coordinates' size."""
SINGULAR = 1e-9
"""Below this share of its largest entries' product the Jacobian's determinant counts as zero."""
RETURNED = 1e-6
"""A coordinate that differs by less after a turn, apart from whole turns, has returned [m or rad]."""


@dataclass(frozen=True)
class Loops:
    """The loops of a machine: `gaps` (phi, d, q) -> gaps (c,) and their Jacobian row by row, `assembly` d -> q.

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
    def _steps(self) -> Kernel:
        """(phi, d, q) -> q after `UNROLLED` steps of Newton's method, the last one's relative size, determinants.

        Determinants of the Jacobian, the last one and the least one, are in parts of its columns' largest entries.
        """
        size = self.size
        phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", self.gaps.numel_in(1)), ca.SX.sym("q", size)
        at, step, determinant, least = q, ca.SX(0), ca.SX(0), ca.SX(np.inf)
        for _ in range(UNROLLED):
            gaps = self.gaps(phi, d, at)
            jacobian = ca.reshape(gaps[size:], size, size).T
            change = -ca.solve(jacobian, gaps[:size])
            at = at + change
            step = ca.mmax(ca.fabs(change) / (1 + ca.fabs(at)))
            determinant = ca.det(jacobian)
            for j in range(size):
                determinant = determinant / ca.norm_inf(jacobian[:, j])
            least = ca.fmin(least, ca.fabs(determinant))
        outputs = ca.cse([ca.densify(output) for output in (at, step, determinant, least)])
        names = ["next", "step", "determinant", "least"]
        return Kernel(ca.Function("close", [phi, d, q], outputs, ["phi", "d", "q"], names), lanes=["phi", "d", "q"])

    @cached_property
    def _start(self) -> Kernel:
        d = ca.SX.sym("d", self.assembly.numel_in(0))
        return Kernel(ca.Function("assemble", [d], [ca.densify(self.assembly(d))], ["d"], ["q"]), lanes=["d"])

    def compile(self) -> None:
        """Compile what the walk calls."""
        self._steps.compile()

    def close(self, phi: Array, d: Array, q: Array) -> tuple[Array, Array, Flags]:
        """Return coordinates (c, n) near others, scaled determinants (n,), and which lanes closed.

        A lane has not closed where its Jacobian was singular on the way.
        """
        closed = failed = np.zeros(q.shape[1], dtype=bool)
        determinant = np.ones(q.shape[1])
        for _ in range(MOST_ITERATIONS):
            out, finite = self._steps.masked(phi=phi, d=d, q=q)
            good = finite & (out["least"][0] > SINGULAR)
            converged = good & (out["step"][0] <= CLOSED)
            if converged.all() and not (closed.any() or failed.any()):
                return out["next"], out["determinant"][0], converged
            active = ~(closed | failed)
            q = np.where(active & good, out["next"], q)
            determinant = np.where(active & good, out["determinant"][0], determinant)
            closed, failed = closed | (active & converged), failed | (active & ~good)
            if (closed | failed).all():
                break
        return q, determinant, closed

    def near(self, phi: Array, d: Array, q: Array) -> Array | None:
        """Return coordinates (c, n) near others, or None where they lead to no common assembly."""
        q, determinant, closed = self.close(phi, d, q)
        return q if closed.all() and (determinant * determinant[0] > 0).all() else None

    def walk(self, d: Array, angles: Array) -> Walk:
        """Return a walk of machines with values d (v, lanes) along increasing angles (n,) from 0 on [rad]."""
        return Walk(self, d, angles)

    def course(self, name: str, d: Array) -> Course:
        """Return the coordinates of one machine with values d (v,) over a turn.

        Raises ComputationError where a loop does not close, at a dead point, and if a turn does not lead back.
        """
        return Course(self, name, d)


class Walk:
    """Coordinates of loops along angles, a machine in each lane.

    `alive` (lanes,) are the lanes that closed until now, `reached` (lanes,) the angles at which the others ended.
    """

    def __init__(self, loops: Loops, d: Array, angles: Array) -> None:
        self.loops, self.angles = loops, angles
        self.lanes = d.shape[1]
        self._d = np.ascontiguousarray(d, dtype=float)
        zeros = np.zeros(self.lanes)
        start, finite = loops._start.masked(d=self._d)
        self.first, self._sense, closed = loops.close(zeros, self._d, np.nan_to_num(start["q"]))
        self.alive, self.reached = closed & finite, np.full(self.lanes, np.inf)
        self.reached[~self.alive] = 0.0
        self.at, self.q = zeros.copy(), self.first.copy()
        self._before, self._q_before = zeros.copy(), self.first.copy()
        self._step = np.full(self.lanes, LARGEST_STEP)
        self._park()

    def __iter__(self) -> Iterator[Array]:
        """Yield the coordinates (c, lanes) at each of the angles; those of lanes that are not alive mean nothing."""
        for angle in self.angles:
            while (self.at < angle).any():
                reach = self.at + self._step
                self._advance(np.where(reach > angle - LEAST_STEP, angle, reach))
            yield self.q

    def _advance(self, target: Array) -> None:
        """Take one step in each lane, or halve it."""
        apart = self.at - self._before
        slope = np.divide(self.q - self._q_before, apart, out=np.zeros_like(self.q), where=apart > 0)
        q, sense, closed = self.loops.close(target, self._d, self.q + slope * (target - self.at))
        good = closed & (sense * self._sense > 0)
        if good.all():
            self._before, self._q_before, self.at, self.q = self.at, self.q, target, q
            self._step = np.minimum(2 * self._step, LARGEST_STEP)
            return
        moves = good & (target > self.at)
        self._before = np.where(moves, self.at, self._before)
        self._q_before = np.where(moves, self.q, self._q_before)
        self.at, self.q = np.where(moves, target, self.at), np.where(moves, q, self.q)
        self._step = np.where(good, np.minimum(2 * self._step, LARGEST_STEP), self._step / 2)
        ended = self.alive & (self._step <= LEAST_STEP)
        self.reached[ended] = self.at[ended]
        self.alive = self.alive & ~ended
        self._park()

    def _park(self) -> None:
        """Let lanes that failed go along with a lane that did not, so that they cost no further steps."""
        lost = np.flatnonzero(~self.alive)
        if not len(lost):
            return
        if not self.alive.any():
            self.at = np.full(self.lanes, np.inf)
            return
        guide = int(np.argmax(self.at * self.alive))
        for array in (self._d, self.q, self._q_before):
            array[:, lost] = array[:, [guide]]
        for array in (self.at, self._before, self._step, self._sense):
            array[lost] = array[guide]

    def gains(self) -> tuple[Array, Flags]:
        """Return what coordinates (c, lanes) gained since the start, as whole turns, and which lanes returned."""
        gained = self.q - self.first
        angular = np.array([unit == "rad" for unit in self.loops.units])[:, None]
        whole = np.where(angular, TURN * np.round(gained / TURN), 0.0)
        return whole, np.asarray(self.alive & (np.abs(gained - whole) <= RETURNED).all(axis=0))


class Course:
    """The coordinates of one machine's loops over a turn, found once, then anywhere."""

    def __init__(self, loops: Loops, name: str, d: Array) -> None:
        self.loops, self.name, self.d = loops, name, np.asarray(d, dtype=float)
        walk = loops.walk(self.d[:, None], np.linspace(0.0, TURN, 361))
        if not walk.alive[0]:
            raise ComputationError(f"{name}: at 0 deg, from the start that is given, {self._obstacle(0.0, walk.first)}")
        places = []
        for q in walk:
            if not walk.alive[0]:
                raise ComputationError(self._dead_point(walk))
            places.append(q[:, 0].copy())
        self.gained = self._returned(walk)
        self.angles, self.places = walk.angles, np.array(places).T

    def moved_to(self, d: Array) -> Course | None:
        """Return the course at other values d (v,), or None if it is not near this one.

        It begins as a walk would, from the assembly of those values.
        """
        lanes = np.repeat(d[:, None], len(self.angles), axis=1)
        q = self.loops.near(self.angles, lanes, self.places)
        first = self.loops.walk(d[:, None], np.empty(0)).first[:, 0]
        if q is None or np.abs(np.column_stack([q[:, 0] - first, q[:, -1] - first - self.gained])).max() > RETURNED:
            return None
        course = copy.copy(self)
        course.d, course.places = d, q
        return course

    def at(self, angles: Array) -> Array:
        """Return the coordinates (c, n) at angles (n,) [rad] of any turn."""
        within = np.mod(angles, TURN)
        guess = np.array([np.interp(within, self.angles, row) for row in self.places])
        q = self.loops.near(within, np.repeat(self.d[:, None], len(within), axis=1), guess)
        if q is None:
            raise ComputationError(f"{self.name}: the loops do not close everywhere on the turn")
        return q + np.outer(self.gained, np.round((angles - within) / TURN))

    def _returned(self, walk: Walk) -> Array:
        """Return what the coordinates gain in a turn: lengths nothing, angles whole turns."""
        whole, returned = walk.gains()
        if not returned[0]:
            gained = walk.q[:, 0] - walk.first[:, 0]
            worst = int(np.argmax(np.abs(gained - whole[:, 0])))
            raise ComputationError(
                f"{self.name}: after a turn {self.loops.names[worst]} is not what it was (it gains {gained[worst]:.6g} "
                f"{self.loops.units[worst]}): the mechanism does not repeat after one turn, or its loops have come "
                "into another assembly"
            )
        return whole[:, 0]

    def _dead_point(self, walk: Walk) -> str:
        at = float(walk.reached[0])
        names = ", ".join(self.loops.names)
        _, _, closed = self.loops.close(np.array([at + 2 * LEAST_STEP]), self.d[:, None], walk.q)
        beyond = f"{names} go on in another assembly" if closed[0] else self._obstacle(at + 2 * LEAST_STEP, walk.q)
        return f"{self.name}: dead point near {np.degrees(at):.6g} deg: beyond it {beyond}"

    def _obstacle(self, angle: float, q: Array) -> str:
        """Return what keeps the loops from closing at an angle."""
        gaps = self._gaps(phi=np.array([angle]), d=self.d[:, None], q=q)["gaps"][: self.loops.size, 0]
        worst = int(np.argmax(np.abs(gaps)))
        if abs(gaps[worst]) <= CLOSED:
            return "the bars lie in line"
        return f"the loops do not close ({self.loops.gap_names[worst]} is {abs(gaps[worst]):.3g} m)"

    @cached_property
    def _gaps(self) -> Kernel:
        gaps = self.loops.gaps
        symbols = [ca.SX.sym(name, gaps.numel_in(i)) for i, name in enumerate(("phi", "d", "q"))]
        function = ca.Function("gaps", symbols, [ca.densify(gaps(*symbols))], ["phi", "d", "q"], ["gaps"])
        return Kernel(function, lanes=["phi", "d", "q"])
