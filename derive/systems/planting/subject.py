"""The planting device as an audit subject, and the laws that every chain of its equations must obey.

The sides are half a revolution apart, so that everything that acts on the frame has the period of half a revolution;
both sides over half a revolution are one side over a full one.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr, S, pi

from ...audit.paper import Cycle, Dynamics, Law, Subject, Values
from ...equations import Claimed, Equation
from ...evaluate import MachineFile, Point
from ...functions import switch
from ...mechanics import driven_motion as twins
from ...mechanics.contacts import GearContact
from ...mechanics.frames import Vec
from ...mechanics.mechanism import Mechanism
from ...model import Event, needed
from ...quantity import Quantity, of_unit
from . import claims, cycle, derivation, flanks
from . import quantities as q

NODES = 4
NODES_PER_RADIAN = 12
"""Gauss points in each piece between two joints of the motion, where all is smooth: some, and more with length."""
BETWEEN = 1000
"""Interpolated points in each piece, to find the largest value of what is broken."""
WORKING_DIGITS = 18
SLOW = 1e-6
"""Share of the speed that stands for no speed: forces of inertia are down to 1e-12."""


@cache
def dynamics() -> Dynamics:
    """The laws of the device with its motion and its derivation."""
    reference = _cycle()
    return Dynamics(laws(), {"reference": reference, "slow": _slowed(reference)}, claims.derive_claims(),
                   claims.supplements(), (q.twin,))  # fmt: skip


def laws() -> tuple[Law, ...]:
    """Momentum, work, rest, and contacts that only push."""
    m = derivation.device()
    other = twins.Other(q.phi, q.twin, claims.moving() | {q.F_E_loss})
    support = q.F_Ox + q.F_O1x, q.F_Oy + q.F_O1y
    rate = [_momentum_rate(m, other, axis) for axis in (0, 1)]
    weight = derivation.weight()
    loss = m.assembly.law(q.F_E_loss).expr
    pushes = {
        "teeth at P": _tooth_push(derivation.CONTACT_P, (q.F_Px, q.F_Py)),
        "teeth at Q": _tooth_push(derivation.CONTACT_Q, (q.F_Qx, q.F_Qy)),
        "cam and roller": _cam_push(m),
    }
    return (
        Law("vertical support force is weight and rate of momentum", "N", (support[1] - weight - rate[1],)),
        Law("horizontal support force is rate of momentum", "N", (support[0] - rate[0],)),
        Law("mean vertical support force is the weight", "N", (support[1] - weight,), "mean"),
        Law("work of the motor is work of friction", "J", (q.M_L - (loss + other(loss)) / q.omega,), "turn"),
        Law("support force tends to the weight as the speed goes to zero", "N", (support[1] - weight,), cycle="slow"),
        *(Law(f"{name} only push", "N", (_pull(push), _pull(other(push)))) for name, push in pushes.items()),
        *(Law(f"tooth force at {tag} has its moment", "N m", (gap, other(gap))) for tag, gap in _levers(m).items()),
    )


def _momentum_rate(m: Mechanism, other: twins.Other, axis: int) -> Expr:
    """Mass times acceleration, from the motion alone; sun and the carrier's centroid are at rest."""
    parts = [part for body in m.bodies if body not in m.shared for part in body.parts]
    own = sp.Add(*(part.mass * m.motion.acceleration(part.centroid, derivation.WORLD)[axis] for part in parts))
    return own + other(own)


def _tooth_push(contact: GearContact, force: tuple[Quantity, Quantity]) -> Expr:
    """Normal force of the flank that the force on the inner gear lies on, positive where it points into the gear."""
    inward = contact.tangent + pi / 2
    normal = Vec(contact.frame, (sp.cos(inward), sp.sin(inward), S.Zero)).resolved(derivation.WORLD)
    share = sp.sin(contact.pressure_angle - contact.friction) / sp.cos(contact.friction)
    return (normal[0] * force[0] + normal[1] * force[1]) / share


def _levers(m: Mechanism) -> dict[str, Expr]:
    """Moment about the outer gear's shaft that is named, less that of the tooth force, at P and Q."""
    found = claims.relations(m)
    return {tag: moment - found[moment] for tag, moment in (("P", q.M_P), ("Q", q.M_Q))}


def _cam_push(m: Mechanism) -> Expr:
    """Component of the cam's force on the roller along the normal of the roller's path, away from the cam."""
    forces, alone = (q.F_Ex, q.F_Ez), {q.mu1: S.Zero, q.F_E: S.One}
    return sp.Add(*(force * m.assembly.law(force).expr.xreplace(alone) for force in forces))


def _pull(push: Expr) -> Expr:
    return switch(push, S.Zero, push)


class BuiltInMotion:
    """The motion of the built-in machine: the kinematic quantities of a side at a carrier angle."""

    def __init__(self) -> None:
        data = MachineFile.read(cycle.MACHINE)
        stages = ((1, "3"), (2, "6"))
        gears = {f"stage{i}": cycle.stage_gears(data, i, suffix) for i, suffix in stages}
        self.functions = cycle.composed(data, gears)
        self.flank = data.tables["cam"]["flank"]
        self.fixed = {s: cycle.in_si(data, s.shown) for s in (*q.MACHINE, *q.MOUNTING)}
        self.fixed |= cycle.distances_and_deformations(gears)
        self.steps = tuple(derivation.device().steps)

    def side(self, phi: Any, wanted: frozenset[sp.Symbol] | None = None) -> dict[sp.Symbol, mpf]:
        """All quantities, or those that some are found from."""
        steps = self.steps if wanted is None else needed(self.steps, wanted)
        return cycle.one_side({**self.fixed, q.phi: phi}, self.functions, steps)

    def joints(self) -> list[Any]:
        """Carrier angles where the motion of either side is not smooth, in half a turn from the first to its return."""
        moving = frozenset(s for step in self.steps for s in step.defines)
        law = (None, *flanks.joints(self.flank))
        kinematic = [e for e in derivation.device().events if e.argument.free_symbols <= moving and e.position in law]
        found = sorted(self._joint(event) % mpmath.pi for event in kinematic)
        return [*found, found[0] + mpmath.pi]

    def _joint(self, event: Event) -> Any:
        """Where in a turn an argument, which grows by one period or falls, meets its target."""

        def periods(phi: Any) -> Any:
            return Point(self.side(phi, event.argument.free_symbols))((event.argument - event.target) / event.period)

        ends = periods(mpf(0)), periods(2 * mpmath.pi)
        whole = mpmath.ceil(min(ends))
        return mpmath.findroot(lambda phi: periods(phi) - whole, (0, 2 * mpmath.pi), solver="anderson", tol=1e-14)


@dataclass(frozen=True)
class Piece:
    """From one joint to the next: Gauss nodes, and what interpolates between them."""

    start: Any
    end: Any

    @property
    def count(self) -> int:
        return NODES + int(NODES_PER_RADIAN * (self.end - self.start))

    @property
    def rule(self) -> tuple[Any, Any]:
        nodes, weights = np.polynomial.legendre.leggauss(self.count)
        return nodes, float(self.end - self.start) / 2 * weights

    @property
    def angles(self) -> list[Any]:
        return [self.start + (self.end - self.start) * (1 + mpf(float(x))) / 2 for x in self.rule[0]]

    @property
    def interpolation(self) -> Any:
        """Matrix from values at the nodes to values at equal steps from end to end."""
        legendre = np.polynomial.legendre.legvander
        return legendre(np.linspace(-1, 1, BETWEEN), self.count - 1) @ np.linalg.inv(
            legendre(self.rule[0], self.count - 1)
        )


def _cycle() -> Cycle:
    """Half a turn of both sides."""
    with mpmath.workdps(WORKING_DIGITS):
        motion = BuiltInMotion()
        joints = motion.joints()
        pieces = [Piece(a, b) for a, b in pairwise(joints)]
        angles = [phi for piece in pieces for phi in piece.angles]
        one, two = (_arrays([motion.side(phi - back) for phi in angles]) for back in (0, mpmath.pi))
    dense = Cycle((_between(one, pieces), _between(two, pieces)), np.ones(BETWEEN * len(pieces)))
    return Cycle((one, two), 2 * np.concatenate([piece.rule[1] for piece in pieces]), dense)


def _arrays(points: list[dict[sp.Symbol, mpf]]) -> Values:
    return {symbol: np.array([float(point[symbol]) for point in points]) for symbol in points[0]}


def _between(side: Values, pieces: list[Piece]) -> Values:
    """A motion at many angles of each piece. The cam's angle, which starts anew in a piece, is left out."""
    cuts = np.cumsum([piece.count for piece in pieces])[:-1]
    matrices = [piece.interpolation for piece in pieces]
    return {
        s: np.concatenate([m @ part for m, part in zip(matrices, np.split(values, cuts), strict=True)])
        for s, values in side.items()
        if s != q.delta
    }


def _order_in_time(quantity: Quantity) -> int:
    """Of a rate 1, of an acceleration 2, of all else 0: a force does not go with the speed."""
    mass, _, time = of_unit(quantity.unit)
    return 0 if mass else -int(time)


def _slowed(cycle: Cycle) -> Cycle:
    """The same motion at next to no speed: rates go with the speed, accelerations with its square."""
    steps = derivation.device().steps
    moving = [q.omega, *(s for step in steps for s in step.defines)]
    factors = {s: SLOW ** _order_in_time(s) for s in moving}
    one, two = ({s: factors.get(s, 1.0) * v for s, v in side.items()} for side in cycle.sides)
    return Cycle((one, two), cycle.weights, _slowed(cycle.between) if cycle.between else None)


class PlantingDevice(Subject):
    """The planting device, as derived, on the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        return claims.derive_claims()

    def admissible(self, rng: random.Random) -> Mapping[sp.Symbol, mpf]:
        return claims.draw_admissible_point(rng)

    def reference(self, points: int) -> Sequence[Mapping[sp.Symbol, mpf]]:
        return claims.compute_reference_cycle(points)

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        return claims.common(printed, derived)

    def footings(self, printed: Expr, derived: Expr) -> Sequence[tuple[Expr, Expr]]:
        return claims.footings(printed, derived)

    def folds(self) -> Mapping[sp.Symbol, Expr]:
        return claims.OFFSETS

    def actions(self) -> Mapping[sp.Symbol, str]:
        return claims.actions()

    def zero(self) -> Mapping[sp.Symbol, str]:
        return claims.ZERO

    def lift(self, claim: Claimed, printed: Expr) -> Expr | None:
        return claims.relax_balance(claim, printed)

    def dynamics(self) -> Dynamics:
        return dynamics()

    def files(self) -> Iterable[Path]:
        """Return the machine file, on which the laws depend."""
        return (cycle.MACHINE,)


SUBJECT = PlantingDevice()
