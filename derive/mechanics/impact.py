"""Compliant contacts with dry friction, for integration in time.

A force along the normal follows from the depth and its rate, friction acts across it, both by
virtual work. Hunt and Crossley, Coefficient of restitution interpreted as damping in vibroimpact,
J. Appl. Mech. 42 (1975).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp
from sympy import Expr, S

from ..functions import switch
from ..model import Let, let, let_all
from ..quantity import Quantity, Vector


def sum_of_squares(components: Sequence[Expr]) -> Expr:
    """Return the sum of the squares of some components."""
    return sp.Add(*(c**2 for c in components))


def creeping(limit: Expr, slip: Sequence[Expr], speed: Expr) -> Expr:
    """Return the friction force per slip velocity [N s/m], Coulomb's ``limit`` [N] smoothed below
    ``speed`` [m/s].

    The force acts against the slip velocity [m/s], whose components are passed: it is minus the
    result times them.

    >>> from sympy import symbols
    >>> from derive import creeping
    >>> limit, v, speed = symbols("limit v speed", positive=True)
    >>> creeping(limit, (v,), speed)
    limit/sqrt(speed**2 + v**2)
    """
    return limit / sp.sqrt(sum_of_squares(slip) + speed**2)


def dahl(
    sliding: Sequence[Expr], bent: Sequence[Expr], stiffness: Expr, limit: Expr, creep: Expr
) -> tuple[tuple[Expr, ...], Expr]:
    """Return the rates [m/s] at which bristles bend, and the power lost in them [W], by Dahl's law
    of friction.

    ``sliding`` [m/s] and ``bent`` [m] are components of the sliding velocity and of the bristles'
    deflection; the force is ``-stiffness * bent``, with ``stiffness`` in [N/m]. It is elastic at
    first and tends to ``limit`` [N] while sliding continues one way. ``creep`` [m/s] makes the law
    smooth at rest (Dahl, Solid friction damping of mechanical vibrations, AIAA J. 14, 1976).

    >>> from sympy import symbols
    >>> from derive import dahl
    >>> v, z, k, limit = symbols("v z k limit", positive=True)
    >>> dahl((v,), (z,), k, limit, 0)
    ((-k*v*z/limit + v,), k**2*v*z**2/limit)
    """
    yielding = sp.sqrt(sum_of_squares(sliding) + creep**2) * stiffness / limit
    rates = tuple(speed - yielding * bend for speed, bend in zip(sliding, bent, strict=True))
    return rates, stiffness * sum_of_squares(bent) * yielding


@dataclass(frozen=True)
class ImpactLaw:
    """An elastic contact with losses: at a depth d [m] the normal force is K d^n (1 + D d'), never
    less than zero.

    ``stiffness`` K [N/m^n], ``exponent`` n (3/2 is Hertz's) and ``dissipation`` D [s/m] are of Hunt
    and Crossley; friction has the coefficient ``friction``, without unit, and creeps below the
    speed ``creep`` [m/s]. ``least`` [m] is a depth that is used where there is none, so that the
    slope of the force is finite.
    """

    stiffness: Quantity
    exponent: sp.Rational
    dissipation: Quantity
    friction: Quantity
    creep: Quantity
    least: Quantity

    def elastic(self, depth: Expr) -> Expr:
        """Return the elastic force [N] at a depth [m]."""
        return self.stiffness * depth**self.exponent

    def work(self, depth: Expr) -> Expr:
        """Return the work of the elastic force [J] up to a depth [m]."""
        way, end = sp.symbols("way end", positive=True)
        return sp.integrate(self.elastic(way), (way, 0, end)).subs(end, depth)


@dataclass(frozen=True)
class Impact:
    """Names for the results of an impact: generalised forces [N or N m] along coordinates, as many
    as their ``rates``.

    ``gap`` and ``depth`` are in [m], ``elastic`` and ``normal`` forces in [N], ``stored`` is the
    energy of the depth [J], ``damped`` and ``rubbed`` are powers lost [W].
    """

    gap: Quantity
    depth: Quantity
    elastic: Quantity
    closing: Quantity
    normal: Quantity
    slip: tuple[Quantity, ...]
    drag: Quantity
    rates: tuple[Quantity, ...]
    forces: tuple[Quantity, ...]
    stored: Quantity
    damped: Quantity
    rubbed: Quantity

    def outputs(self, name: str) -> Vector:
        """Return gap [m], normal force [N], generalised forces, stored energy [J] and powers lost
        [W], packed.
        """
        return Vector(
            name, (self.gap, self.normal, *self.forces, self.stored, self.damped, self.rubbed)
        )

    def steps(
        self, gap: Expr, opening: Expr, slip: Sequence[Expr], law: ImpactLaw
    ) -> tuple[Let, ...]:
        """Return the steps of the law for a distance ``gap`` [m], its rate ``opening`` [m/s] and
        slip velocities [m/s].

        The distance is negative where the bodies overlap.

        By virtual work a force along the normal acts on a coordinate as the slope of the distance
        along it says, and friction as that of the slip does: the slope in a coordinate is that of
        the rate in the coordinate's rate. Raises ValueError if the rate or a slip is not linear in
        the rates.
        """
        slips = self.slip[: len(slip)]
        return (
            let(self.gap, gap),
            let(self.depth, sp.Max(-self.gap, law.least)),
            let(self.elastic, switch(self.gap, S.Zero, law.elastic(self.depth))),
            let(self.closing, -opening),
            let(self.normal, self.elastic * sp.Max(1 + law.dissipation * self.closing, S.Zero)),
            *let_all(slips, slip),
            *(
                [let(self.drag, creeping(law.friction * self.normal, slips, law.creep))]
                if slip
                else []
            ),
            *(
                let(force, self._force(rate, opening, slip))
                for rate, force in zip(self.rates, self.forces, strict=True)
            ),
            let(self.stored, switch(self.gap, S.Zero, law.work(self.depth))),
            let(self.damped, (self.normal - self.elastic) * self.closing),
            let(self.rubbed, self.drag * sum_of_squares(slips) if slip else S.Zero),
        )

    def _force(self, rate: Quantity, opening: Expr, slip: Sequence[Expr]) -> Expr:
        lever = opening.diff(rate)
        rubbing = sp.Add(
            *(name * component.diff(rate) for name, component in zip(self.slip, slip, strict=False))
        )
        if (lever.free_symbols | rubbing.diff(rate).free_symbols) & {rate}:
            raise ValueError(f"{self.gap}: its rate, or a slip, is not linear in {rate}")
        return lever * self.normal - (self.drag * rubbing if rubbing != 0 else S.Zero)
