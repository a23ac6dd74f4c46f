"""The planting device as an audit subject, and the laws that every chain of its equations must
obey.

The sides are half a revolution apart, so that everything that acts on the frame has the period of
half a revolution; both sides over half a revolution are one side over a full one.
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
"""Gauss points in each smooth piece between two breakpoints of the motion: NODES, and more per
length.
"""
INTERPOLATED = 1000
"""Interpolated points in each piece, to find the largest violation of a law."""
WORKING_DIGITS = 18
SLOW = 1e-6
"""Share of the speed that represents rest: inertia forces are reduced to 1e-12."""


@cache
def build_dynamics() -> Dynamics:
    """Return the laws of the device with its motion and its derivation."""
    reference = _build_cycle()
    return Dynamics(
        derive_laws(),
        {"reference": reference, "slow": _slow_down(reference)},
        claims.derive_claims(),
        claims.derive_reaction_steps(),
        (q.twin,),
    )


def derive_laws() -> tuple[Law, ...]:
    """Return the laws of momentum, work and rest, and that contacts only push."""
    m = derivation.build_device()
    other = twins.Other(q.phi, q.twin, claims.side_quantities() | {q.F_E_loss})
    support = q.F_Ox + q.F_O1x, q.F_Oy + q.F_O1y
    rate = [_momentum_rate(m, other, axis) for axis in (0, 1)]
    weight = derivation.supported_weight()
    loss = m.assembly.law(q.F_E_loss).expr
    pushes = {
        "teeth at P": _tooth_push(derivation.CONTACT_P, (q.F_Px, q.F_Py)),
        "teeth at Q": _tooth_push(derivation.CONTACT_Q, (q.F_Qx, q.F_Qy)),
        "cam and roller": _cam_push(m),
    }
    return (
        Law(
            "vertical support force is weight and rate of momentum",
            "N",
            (support[1] - weight - rate[1],),
        ),
        Law("horizontal support force is rate of momentum", "N", (support[0] - rate[0],)),
        Law("mean vertical support force is the weight", "N", (support[1] - weight,), "mean"),
        Law(
            "work of the motor is work of friction",
            "J",
            (q.M_L - (loss + other(loss)) / q.omega,),
            "turn",
        ),
        Law(
            "support force tends to the weight as the speed goes to zero",
            "N",
            (support[1] - weight,),
            cycle="slow",
        ),
        *(
            Law(f"{name} only push", "N", (_pull(push), _pull(other(push))))
            for name, push in pushes.items()
        ),
        *(
            Law(f"tooth force at {tag} has its moment", "N m", (gap, other(gap)))
            for tag, gap in _levers(m).items()
        ),
    )


def _momentum_rate(m: Mechanism, other: twins.Other, axis: int) -> Expr:
    """Return mass times acceleration, from the motion alone; sun and the carrier's centroid are at
    rest.
    """
    parts = [part for body in m.bodies if body not in m.shared for part in body.parts]
    rate = sp.Add(
        *(
            part.mass * m.motion.acceleration(part.centroid, derivation.WORLD)[axis]
            for part in parts
        )
    )
    return rate + other(rate)


def _tooth_push(contact: GearContact, force: tuple[Quantity, Quantity]) -> Expr:
    """Return the normal force on the loaded flank of the inner gear, positive if it points into the
    gear.
    """
    inward = contact.tangent + pi / 2
    normal = Vec(contact.frame, (sp.cos(inward), sp.sin(inward), S.Zero)).resolved(derivation.WORLD)
    share = sp.sin(contact.pressure_angle - contact.friction) / sp.cos(contact.friction)
    return (normal[0] * force[0] + normal[1] * force[1]) / share


def _levers(m: Mechanism) -> dict[str, Expr]:
    """Return the named moment about the outer gear's shaft minus that of the tooth force, at P and
    Q.
    """
    relations = claims.derive_relations(m)
    return {tag: moment - relations[moment] for tag, moment in (("P", q.M_P), ("Q", q.M_Q))}


def _cam_push(m: Mechanism) -> Expr:
    """Return the component of the cam's force on the roller along the normal of its path, away from
    the cam.
    """
    forces, alone = (q.F_Ex, q.F_Ez), {q.mu1: S.Zero, q.F_E: S.One}
    return sp.Add(*(force * m.assembly.law(force).expr.xreplace(alone) for force in forces))


def _pull(push: Expr) -> Expr:
    return switch(push, S.Zero, push)


class BuiltInMotion:
    """The motion of the built-in machine: kinematic quantities of a side at a carrier angle."""

    def __init__(self) -> None:
        data = MachineFile.read(cycle.MACHINE)
        stages = ((1, "3"), (2, "6"))
        gears = {f"stage{i}": cycle.stage_gears(data, i, suffix) for i, suffix in stages}
        self.functions = cycle.build_runtime_functions(data, gears)
        self.flank = data.tables["cam"]["flank"]
        self.fixed = {s: cycle.read_si(data, s.shown) for s in (*q.MACHINE, *q.MOUNTING)}
        self.fixed |= cycle.distances_and_deformations(gears)
        self.steps = tuple(derivation.build_device().steps)

    def evaluate_side(
        self, phi: Any, targets: frozenset[sp.Symbol] | None = None
    ) -> dict[sp.Symbol, mpf]:
        """Return all quantities, or those that the targets depend on."""
        steps = self.steps if targets is None else needed(self.steps, targets)
        return cycle.evaluate_side({**self.fixed, q.phi: phi}, self.functions, steps)

    def breakpoints(self) -> list[Any]:
        """Return the carrier angles at which the motion is not smooth, over half a revolution, with
        both ends.
        """
        moving = frozenset(s for step in self.steps for s in step.defines)
        law = (None, *flanks.flank_breakpoints(self.flank))
        events = [
            event for event in derivation.build_device().events if event.name != derivation.CAM_TURN
        ]
        kinematic = [e for e in events if e.argument.free_symbols <= moving and e.position in law]
        angles = sorted(self._find_event(event) % mpmath.pi for event in kinematic)
        return [*angles, angles[0] + mpmath.pi]

    def _find_event(self, event: Event) -> Any:
        """Return the angle at which an argument, which changes by one period per revolution,
        reaches its target.
        """

        def periods(phi: Any) -> Any:
            return Point(self.evaluate_side(phi, event.argument.free_symbols))(
                (event.argument - event.target) / event.period
            )

        ends = periods(mpf(0)), periods(2 * mpmath.pi)
        count = mpmath.ceil(min(ends))
        return mpmath.findroot(
            lambda phi: periods(phi) - count, (0, 2 * mpmath.pi), solver="anderson", tol=1e-14
        )


@dataclass(frozen=True)
class SmoothPiece:
    """The angles between two breakpoints: Gauss nodes, and the interpolation between them."""

    start: Any
    end: Any

    @property
    def count(self) -> int:
        """Number of nodes."""
        return NODES + int(NODES_PER_RADIAN * (self.end - self.start))

    @property
    def rule(self) -> tuple[Any, Any]:
        """Nodes in [-1, 1] and weights [rad] of the Gauss-Legendre rule."""
        nodes, weights = np.polynomial.legendre.leggauss(self.count)
        return nodes, float(self.end - self.start) / 2 * weights

    @property
    def angles(self) -> list[Any]:
        """Carrier angles of the nodes [rad]."""
        return [
            self.start + (self.end - self.start) * (1 + mpf(float(x))) / 2 for x in self.rule[0]
        ]

    @property
    def interpolation(self) -> Any:
        """Matrix from values at the nodes to values at INTERPOLATED equal steps."""
        legendre = np.polynomial.legendre.legvander
        return legendre(np.linspace(-1, 1, INTERPOLATED), self.count - 1) @ np.linalg.inv(
            legendre(self.rule[0], self.count - 1)
        )


def _build_cycle() -> Cycle:
    """Return half a revolution of both sides."""
    with mpmath.workdps(WORKING_DIGITS):
        motion = BuiltInMotion()
        pieces = [SmoothPiece(a, b) for a, b in pairwise(motion.breakpoints())]
        angles = [phi for piece in pieces for phi in piece.angles]
        sides = tuple(
            _stack_values([motion.evaluate_side(phi - lag) for phi in angles])
            for lag in (0, mpmath.pi)
        )
    dense = Cycle(
        tuple(_interpolate(side, pieces) for side in sides), np.ones(INTERPOLATED * len(pieces))
    )
    return Cycle(sides, 2 * np.concatenate([piece.rule[1] for piece in pieces]), dense)


def _stack_values(points: list[dict[sp.Symbol, mpf]]) -> Values:
    return {symbol: np.array([float(point[symbol]) for point in points]) for symbol in points[0]}


def _interpolate(side: Values, pieces: list[SmoothPiece]) -> Values:
    """Return a motion at many angles of each piece, without the cam's angle, which is reset within
    a piece.
    """
    cuts = np.cumsum([piece.count for piece in pieces])[:-1]
    matrices = [piece.interpolation for piece in pieces]
    return {
        s: np.concatenate(
            [m @ part for m, part in zip(matrices, np.split(values, cuts), strict=True)]
        )
        for s, values in side.items()
        if s != q.delta
    }


def _time_order(quantity: Quantity) -> int:
    """Return 1 for a rate, 2 for an acceleration, otherwise 0, also for a force."""
    mass, _, time = of_unit(quantity.unit)
    return 0 if mass else -int(time)


def _slow_down(cycle: Cycle) -> Cycle:
    """Return the same motion at a negligible speed: rates scale with the speed, accelerations with
    its square.
    """
    steps = derivation.build_device().steps
    moving = [q.omega, *(s for step in steps for s in step.defines)]
    factors = {s: SLOW ** _time_order(s) for s in moving}
    sides = tuple({s: factors.get(s, 1.0) * v for s, v in side.items()} for side in cycle.sides)
    return Cycle(sides, cycle.weights, _slow_down(cycle.between) if cycle.between else None)


class PlantingDevice(Subject):
    """The planting device, as derived, on the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return the derived equations by their claims."""
        return claims.derive_claims()

    def admissible(self, rng: random.Random) -> Mapping[sp.Symbol, mpf]:
        """Return random values of all symbols at which the machine works."""
        return claims.draw_admissible_point(rng)

    def reference(self, points: int) -> Sequence[Mapping[sp.Symbol, mpf]]:
        """Return the values of all symbols at ``points`` angles of a cycle of the reference
        machine.
        """
        return claims.compute_reference_cycle(points)

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """Return both sides in the same quantities."""
        return claims.to_common_quantities(printed, derived)

    def footings(self, printed: Expr, derived: Expr) -> Sequence[tuple[Expr, Expr]]:
        """Return the pairs of sides to compare."""
        return claims.list_comparisons(printed, derived)

    def folds(self) -> Mapping[sp.Symbol, Expr]:
        """Return the offsets that may be taken from a symbol."""
        return claims.OFFSETS

    def definitions(self) -> Mapping[sp.Symbol, Expr]:
        """Return the quantities of both sides by what they are in other quantities."""
        return claims.derive_definitions()

    def reactions(self) -> Mapping[sp.Symbol, Expr]:
        """Return constraint moments and moments of tooth forces in other quantities."""
        return claims.derive_reactions()

    def actions(self) -> Mapping[sp.Symbol, str]:
        """Return the descriptions of forces and moments by their symbols."""
        return claims.describe_actions()

    def zero(self) -> Mapping[sp.Symbol, str]:
        """Return the symbols that are zero, each with the reason."""
        return claims.ZERO

    def lift(self, claim: Claimed, printed: Expr) -> Expr | None:
        """Return a balance without the assumption that the print makes, or None if it makes
        none.
        """
        return claims.relax_balance(claim, printed)

    def dynamics(self) -> Dynamics:
        """Return the laws, motions and derivation for the audit of the chain."""
        return build_dynamics()

    def files(self) -> Iterable[Path]:
        """Return the machine file, on which the laws depend."""
        return (cycle.MACHINE,)


SUBJECT = PlantingDevice()
