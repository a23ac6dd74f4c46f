"""The reverse design: value points are moved until the requirements hold, with exact gradients, by
IPOPT.

Of all designs that hold them the one is sought whose tip path differs least from the file's. A
requirement that no design can hold is broken as little as possible, and the result says so.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import scipy

from planter.engine.solvers.constraints import DesignBox, NamedConstraint
from planter.engine.solvers.expressions import (
    SmoothObjective,
    SymbolicConstraints,
    SymbolicFunction,
)
from planter.engine.solvers.local_search import LocalMinimum, search_locally
from planter.engine.solvers.problem import Problem
from planter.engine.solvers.result import OptimalityCertificate, certify_candidates
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.inverse import LAW_DEGREE
from planter.papers.pickup.law import MODEL, NEEDLE, ArmLaw, SplineLaw
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.requirements import (
    Cell,
    CellEntry,
    find_push,
    list_requirements,
    pick_angle_deg,
)
from planter.papers.pickup.results import Demand
from planter.progress import Listener, ProgressPhase

APART = np.radians(2)
"""Value points closer than this to an end of the dwell are left out: the end stands for them."""


@dataclass(frozen=True)
class LawNodes:
    """Angles of value points on the teeth, and the linear map from the arm's angles there to the
    law.

    `t` (n,) are carrier angles from the dwell's end of the turn before to its start. The variables
    are the arm's angles there (n,), with a dwell without the first: it is the last less a turn.
    """

    law: ArmLaw
    t: Array

    @property
    def size(self) -> int:
        return len(self.t) - 1

    @property
    def values(self) -> Array:
        """The variables of the law itself (size,)."""
        return self.law.arm(self.t)[1:]

    def angles(self, v: Any) -> Any:
        """The arm's angle at every node from the variables."""
        return np.concatenate([[v[-1] - TURN], v])

    @cached_property
    def _basis(self) -> scipy.interpolate.BSpline:
        """Splines through one for a node and zero for the others."""
        return _interpolant(self.t, np.eye(len(self.t)), self.law.dwell is None)

    def rows(self, t: Array, order: int) -> tuple[Array, Array]:
        """Matrix (m, size) and offset (m,) that give a derivative of the arm's angle at angles on
        the teeth.

        The splines act on the arm's lead over the carrier, which repeats after a turn.
        """
        values = self._basis(t, order)
        folded = values[:, 1:].copy()
        folded[:, -1] += values[:, 0]
        lead = -(values @ self.t) - TURN * values[:, 0]
        return folded, lead + (t if order == 0 else np.full_like(t, 1.0 if order == 1 else 0.0))

    def law_of(self, v: Array) -> SplineLaw:
        """The law through the variables."""
        curve = _interpolant(self.t, self.angles(v) - self.t, self.law.dwell is None)
        return SplineLaw(curve, self.law.dwell, float(v[-1]))


def _interpolant(t: Array, values: Array, closed: bool) -> scipy.interpolate.BSpline:
    if closed:
        ring = values.copy()
        ring[-1] = ring[0]
        curve = scipy.interpolate.make_interp_spline(t, ring, k=LAW_DEGREE, bc_type="periodic")
        curve.extrapolate = "periodic"
        return curve
    return scipy.interpolate.make_interp_spline(t, values, k=LAW_DEGREE)


def build_nodes(train: PickupTrain, value_points: int) -> LawNodes:
    """Nodes at equal steps from the farthest tip, outside the dwell, and at the dwell's ends.

    Raises InputError for a dwell with smooth ends, which moving value points would not keep.
    """
    first, last = train.driven
    if train.law.transition:
        raise InputError(
            'law.ends = "smooth" cannot be used where value points are moved (--optimise), for '
            "these keep no "
            "smooth ends: it must be left out"
        )
    steps = np.arange(value_points) * TURN / value_points
    inside = np.sort(first + (steps - first) % TURN)
    inside = inside[(inside > first + APART) & (inside < last - APART)]
    return LawNodes(train.law, np.concatenate([[first], inside, [last]]))


def sample_chain(
    train: PickupTrain, at: LawNodes, v: ca.MX, t: Array, axis: float, entry: float
) -> dict[str, ca.MX]:
    """Return the chain at sample angles (m,) as functions of the variables `v`: arm, slopes, depth,
    place across and tilt of the needle in the cell's frame, curvatures of the pitch curves.
    """
    model, count = load(MODEL), len(t)
    parts = [_product(at.rows(t, order), v) for order in range(4)]
    slopes = ca.vertcat(*(part.T for part in parts[1:]))
    phi5 = ca.DM(train.phi5_far + t).T
    motion = model.function("motion").map(count)(
        phi5,
        parts[0].T,
        slopes[0, :],
        ca.DM.ones(1, count) * train.omega,
        ca.repmat(ca.DM(train.geometry.triangle), 1, count),
    )
    tip = [motion[model.outputs("motion").index(name), :] for name in ("x_S", "y_S")]
    bottom = train.tip(np.zeros(1))[0]
    ones = ca.DM.ones(1, count)
    cell = model.function("entry").map(count)(*tip, bottom[0] * ones, bottom[1] * ones, axis * ones)
    pitch = model.function("pitch").map(count)(
        slopes, ca.DM(t).T, parts[0].T - np.pi, train.geometry.a1 * ones
    )
    bends = [pitch[model.outputs("pitch").index(name), :].T for name in ("kappa1", "kappa2")]
    return {
        "arm": parts[0],
        "slopes": slopes,
        "depth": cell[0, :].T + entry,
        "across": cell[1, :].T,
        "tilt": ca.DM(t) - parts[0] + np.pi,
        "curvatures": ca.horzcat(*bends),
    }


def _product(rows: tuple[Array, Array], v: ca.MX) -> ca.MX:
    matrix, offset = rows
    return ca.mtimes(ca.DM(matrix), v) + ca.DM(offset)


SAMPLES = 241
"""Carrier angles on the teeth at which requirements are imposed."""
ROUNDS = 8
"""Rounds of moving the push angle to where the needle rests, and of taking back what samples have
missed.
"""
LEAST_SLOPE, LEAST_CURVATURE = 0.05, 0.5
"""What slope [-] and curvature of the pitch curves [1/m] are kept above, to be above zero between
samples.
"""
FUNNEL = 5.0
"""Slope at which the clearance of the needle widens above the tray, where nothing is in its way
[-].
"""
NEAR_PICK = np.radians(100)
"""Carrier angles around the pick at which needle and tray can meet."""
PENALTY = 10.0
"""Cost of breaking a requirement by one unit; larger than what keeping it costs."""
STEP = 0.05
"""Unit of the variables: arm's angle [rad]."""
MOVED_MM, BENT = 30.0, 1.0
"""What counts as one in the objective: tip moved [mm], second derivative of the slope changed
[-].
"""
STRAIGHT_SHARE = 0.45
"""Part of the straightness that a line through the pick may use up, so that chords keep within the
whole.
"""

SETTLED = np.radians(0.01)
"""Change of the angle where the needle rests that is none [rad]."""
BROKEN = 1e-4
"""Slack from which a requirement cannot be held, in the unit in which it is imposed."""

MOST_ITERATIONS = 300
KINDS = (
    NamedConstraint("push angle", unit="deg"),
    NamedConstraint("straight entry", unit="mm"),
    NamedConstraint("needle to tray", unit="mm"),
    NamedConstraint("slope on the teeth", step=0.1),
    NamedConstraint("pitch curves convex", unit="1/m", step=10.0),
)
"""Requirements that the optimiser knows, each with a slack of its own."""
NAMES = tuple(kind.name for kind in KINDS)
PINNED = NamedConstraint("arm at the farthest tip", ("equal",), "rad")
"""What stays as it is."""


@dataclass(frozen=True)
class Redesign:
    """The train at the start and the one that was found, with value points (n, 2) [m] and
    requirements of both.

    `certificate` is that of the last round's optimum, None where nothing had to be moved.
    """

    start: PickupTrain
    train: PickupTrain
    points_before: Array
    points: Array
    before: list[Demand]
    after: list[Demand]
    iterations: int
    rounds: int
    certificate: OptimalityCertificate | None

    @property
    def holds(self) -> bool:
        return all(requirement.holds for requirement in self.after)

    @property
    def moved(self) -> float:
        """Largest distance that a value point was moved [m]."""
        return float(np.hypot(*(self.points - self.points_before).T).max())


def redesign_path(
    machine: Pickup, train: PickupTrain, progress: Listener | None = None
) -> Redesign:
    """Moves the value points of a train until its requirements hold, or as far towards it as they
    go.
    """
    before = list_requirements(machine, train)
    at = build_nodes(train, machine.spline.value_points)
    reserve = dict.fromkeys(NAMES, 0.0)
    v, iterations, current, after, turns = at.values, 0, train, before, 0
    proof: OptimalityCertificate | None = None
    phase = ProgressPhase("pickup", "round", ROUNDS, progress)
    for turns in range(1, ROUNDS + 1):
        if all(requirement.holds for requirement in after):
            turns -= 1
            break
        change = LeastChange(machine, train, at, find_push(current)[0], reserve)
        minimum = change.solve(v)
        v, broken, proof = (
            change.angles(minimum.u),
            change.slack(minimum.u),
            certify_candidates(change.problem, minimum.u, [minimum]),
        )
        iterations += minimum.iterations
        rested = find_push(current)[0]
        current = replace(train, law=at.law_of(v), inversion=None)
        after = list_requirements(machine, current)
        phase.advance(f"least margin {min(r.margin for r in after):.4g}")
        if abs(rested - change.rests) < SETTLED:
            if broken > BROKEN:
                break
            reserve = _tightened(reserve, after)
    phase.finish()
    steps = np.arange(machine.spline.value_points) * TURN / machine.spline.value_points
    return Redesign(
        train,
        current,
        train.tip(steps),
        current.tip(steps),
        before,
        after,
        iterations,
        turns,
        proof,
    )


_SHARE = {
    "sun's pitch curve convex": "pitch curves convex",
    "intermediate gear's convex": "pitch curves convex",
    "push angle less pick angle": "push angle",
}


def _tightened(reserve: dict[str, float], after: list[Demand]) -> dict[str, float]:
    """Reserves grown by what was missed, in the unit in which the optimiser imposes each
    requirement.
    """
    grown = dict(reserve)
    for requirement in after:
        name = _SHARE.get(requirement.name, requirement.name)
        if not requirement.holds and name in grown:
            grown[name] += 1.2 * abs(requirement.margin) * {"straight entry": 0.02}.get(name, 1.0)
    return grown


@dataclass(frozen=True)
class LeastChange:
    """The least change of a train that holds its requirements where its needle `rests`, more of
    them by a `reserve`.

    Variables x are the arm's angles at the nodes in steps of `STEP` from the train's own, the slope
    of the entry's line, and the slacks.
    """

    machine: Pickup
    train: PickupTrain
    at: LawNodes
    rests: float
    reserve: dict[str, float] = field(default_factory=dict)

    @cached_property
    def problem(self) -> Problem:
        """The search's variables are those of the programme, and its objective counts as it is."""
        x = ca.MX.sym("x", self.at.size + 1 + len(NAMES))
        objective, margins, pinned = self._graph(x)
        rows = ca.vertcat(*margins, pinned)
        count, free = rows.numel(), rows.numel() - pinned.numel()
        owner = np.repeat(
            np.arange(len(KINDS) + 1), [*(part.numel() for part in margins), pinned.numel()]
        )
        bounds = np.zeros(count), np.where(np.arange(count) < free, np.inf, 0.0)
        constraints = SymbolicConstraints(x, rows, bounds, (*KINDS, PINNED), owner)
        return Problem(
            SmoothObjective(SymbolicFunction(x, objective), x.numel(), unit=1.0),
            self._box,
            constraints,
        )

    @property
    def _box(self) -> DesignBox:
        n, k = self.at.size, len(NAMES)
        upper = np.concatenate([np.full(n, np.pi / 2 / STEP), [1.0], np.full(k, 1e3)])
        lower = np.concatenate([-upper[: n + 1], np.zeros(k)])
        names = (
            *(f"arm at node {i}" for i in range(1, n + 1)),
            "slope of the entry",
            *(f"slack of {s}" for s in NAMES),
        )
        return DesignBox.plain(names, lower, upper, np.zeros(n + 1 + k))

    def _graph(self, x: ca.MX) -> tuple[ca.MX, list[ca.MX], ca.MX]:
        """The change, the rows of each requirement, which are at least 0 where it holds, and what
        is 0.
        """
        n = self.at.size
        v, tilted, slack = ca.DM(self.at.values) + STEP * x[:n], x[n], x[n + 1 :]
        cell, t = Cell.from_pickup(self.machine), self.train.samples(SAMPLES)
        now = sample_chain(
            self.train, self.at, v, t, CellEntry(self.train, cell).axis(), cell.entry
        )
        margins = [
            ca.vertcat(*self._angles(v, slack[0])),
            ca.vertcat(*(part + slack[1] for part in self._straight(now, t, tilted))),
            ca.vertcat(*(part + slack[2] for part in self._clear(now, t, cell))),
            (now["slopes"][0, :].T - LEAST_SLOPE - self.reserve["slope on the teeth"]) * 10
            + slack[3],
            ca.vec(now["curvatures"]) / 10
            - (LEAST_CURVATURE / 10 + self.reserve["pitch curves convex"])
            + slack[4],
        ]
        moved = (now["arm"] - ca.DM(self.train.law.arm(t))) * (
            self.train.geometry.L2 * 1000 / MOVED_MM
        )
        bent = (now["slopes"][2, :].T - ca.DM(self.train.law.slopes(t)[2])) / BENT
        objective = (ca.sumsqr(moved) + ca.sumsqr(bent)) / SAMPLES + PENALTY * ca.sum1(slack)
        return objective, margins, self._row(v, 0.0, 0) - np.pi

    def _row(self, v: ca.MX, t: float, order: int) -> ca.MX:
        first = self.train.toothed[0]
        matrix, offset = self.at.rows(np.array([first + (t - first) % TURN]), order)
        return ca.mtimes(ca.DM(matrix), v) + ca.DM(
            offset + t - (first + (t - first) % TURN) if order == 0 else offset
        )

    def _angles(self, v: ca.MX, slack: ca.MX) -> list[ca.MX]:
        """Push angle and swing in their bands [deg], at the place where the needle rests."""
        targets = self.machine.targets
        turned = (self._row(v, self.rests, 0) - np.pi - self.rests) * (180 / np.pi)
        bands = (
            (targets.push_deg - pick_angle_deg(self.machine), targets.push_tolerance_deg),
            (targets.swing_deg, targets.swing_tolerance_deg),
        )
        reserve = self.reserve["push angle"]
        lower_margins = [turned - (target - tolerance) for target, tolerance in bands]
        upper_margins = [(target + tolerance) - turned for target, tolerance in bands]
        return [band - reserve + slack for band in (*lower_margins, *upper_margins)]

    def _straight(self, now: dict[str, ca.MX], t: Array, tilted: ca.MX) -> list[ca.MX]:
        """The path into the cell keeps to a line through the pick, over the length that must be
        straight [mm].
        """
        targets = self.machine.targets
        i = np.flatnonzero((t <= 0) & (t > -NEAR_PICK)).tolist()
        back = self.machine.si("targets.entry_depth_mm") - now["depth"][i]
        deviation = now["across"][i] - tilted * back
        beyond = ca.fmax(back * 1000 - targets.straight_entry_mm - 2, 0)
        clearance = (
            STRAIGHT_SHARE * targets.straightness_mm
            - self.reserve["straight entry"]
            + FUNNEL * beyond
        )
        return [clearance - deviation * 1000, clearance + deviation * 1000]

    def _clear(self, now: dict[str, ca.MX], t: Array, cell: Cell) -> list[ca.MX]:
        """The needle's tip and its edges at the surface stay within the cell, which widens above
        the tray [mm].
        """
        i = np.flatnonzero(np.abs(t) < NEAR_PICK).tolist()
        depths, across, tilt = now["depth"][i], now["across"][i], now["tilt"][i]
        clear = self.machine.si("targets.clearance_mm") + self.reserve["needle to tray"] / 1000
        taper = (cell.top - cell.bottom) / 2 / cell.depth
        needle = load(NEEDLE).function("needle").map(len(i))
        ones = ca.DM.ones(1, len(i))
        corners = needle(
            depths.T, across.T, tilt.T, cell.needle_length * ones, cell.needle_width * ones
        )
        at = dict(zip(load(NEEDLE).outputs("needle"), ca.vertsplit(corners), strict=True))
        gaps = []
        for side, edge in ((1, "left"), (-1, "right")):
            depth, offset, surface = (
                at[n].T for n in (f"tip_{edge}_along", f"tip_{edge}_across", f"{edge}_surface")
            )
            widened = cell.top / 2 + FUNNEL * ca.fmax(-depth, 0) - clear
            gaps += [
                (widened - taper * ca.fmax(depth, 0) - side * offset) * 1000,
                (widened - side * surface) * 1000,
            ]
        return gaps

    def start(self, v: Array) -> Array:
        """Variables with slacks that let every requirement hold."""
        z = np.concatenate([(v - self.at.values) / STEP, np.zeros(1 + len(NAMES))])
        constraints = self.problem.constraints
        assert constraints is not None
        short = max(0.0, -float(constraints.values(z)[:-1].min()))
        z[-len(NAMES) :] = short + 1e-3
        return z

    def angles(self, u: Array) -> Array:
        """The arm's angles (size,) at a point."""
        return self.at.values + STEP * u[: self.at.size]

    def slack(self, u: Array) -> float:
        """The largest slack at a point."""
        return float(u[-len(NAMES) :].max())

    def solve(self, v: Array) -> LocalMinimum:
        """The least change, looked for from angles (size,).

        Raises ComputationError where IPOPT finds none.
        """
        minimum = search_locally(self.problem, self.start(v), MOST_ITERATIONS)
        if not minimum.settled:
            raise ComputationError(
                f"the value points were not moved: IPOPT stopped after {minimum.iterations} "
                f"iterations"
            )
        return minimum
