"""Closed loops: coordinates that follow from equations between them, their rates and accelerations.

Positions are found where the code runs, by Newton's method from a place nearby. The generated
functions take what was found there and add two Newton steps: they change the value by nothing but
rounding, and carry its first and second derivatives (those of the implicit function theorem) to
whatever differentiates the function.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from sympy import Expr

from ..chain import pivot, solve_linear_set
from ..model import ClosedForm, Let, Step, needed
from ..quantity import Quantity, Vector
from .frames import Motion

ROUNDS = 2
"""Newton steps in the generated code: one carries first derivatives, two carry second ones too."""


class LoopError(ValueError):
    """Loops do not determine their coordinates."""


@dataclass(frozen=True)
class Coordinate:
    """A coordinate that loops determine: its value, rate and acceleration, and what it is before it
    is improved.
    """

    value: Quantity
    rate: Quantity
    acceleration: Quantity

    @property
    def given(self) -> Quantity:
        """Return the packed input of the generated functions: the values of the coordinates."""
        return self._like("given", "as found before")

    def step(self, turn: int) -> Quantity:
        """Return the quantity that is the coordinate's Newton step of a number."""
        return self._like(f"step{turn}", f"Newton step {turn}")

    def near(self, turn: int) -> Quantity:
        """Return the quantity that is the coordinate after a Newton step of a number."""
        return self._like(f"near{turn}", f"after Newton step {turn}")

    def _like(self, suffix: str, remark: str) -> Quantity:
        value = self.value
        return Quantity(
            f"{value}_{suffix}", value.unit, f"{value.meaning}, {remark}", "derived: loops"
        )


@dataclass
class Loops:
    """Equations ``gap = 0`` of as many coordinates; ``start`` says where these are at the angle
    zero, about.

    ``rate_steps`` are those of rates and accelerations, after `steps` has derived them.
    """

    coordinates: list[Coordinate] = field(default_factory=list)
    gaps: dict[str, Expr] = field(default_factory=dict)
    start: dict[Quantity, Expr] = field(default_factory=dict)
    rate_steps: tuple[Step, ...] = ()

    @property
    def all(self) -> tuple[Quantity, ...]:
        """Coordinates, then their rates, then their accelerations."""
        order = ("value", "rate", "acceleration")
        return tuple(getattr(c, part) for part in order for c in self.coordinates)

    @property
    def inputs(self) -> tuple[Vector, ...]:
        """Return the inputs that the generated functions take besides the data."""
        return (self.given,) if self.coordinates else ()

    @property
    def values(self) -> tuple[Quantity, ...]:
        return tuple(c.value for c in self.coordinates)

    @property
    def given(self) -> Vector:
        """Return the packed input of the generated functions: the values of the coordinates."""
        return Vector("loops", tuple(c.given for c in self.coordinates))

    @property
    def pivots(self) -> frozenset[Quantity]:
        """Return the quantities that repeat what the pivot of the rates says."""
        first = [
            q
            for c in self.coordinates[:1]
            for q in (*(c.step(turn) for turn in range(1, ROUNDS + 1)), c.acceleration)
        ]
        return frozenset(map(pivot, first))

    def _check(self) -> None:
        """Raises LoopError where there are more or fewer equations than coordinates, or no
        start.
        """
        if len(self.gaps) != len(self.coordinates):
            less = "fewer" if len(self.gaps) < len(self.coordinates) else "more"
            names, gaps = ", ".join(map(str, self.values)) or "none", ", ".join(self.gaps) or "none"
            raise LoopError(
                f"loops give {less} equations ({len(self.gaps)}: {gaps}) than there are "
                f"coordinates to find "
                f"({len(self.coordinates)}: {names}): {len(self.coordinates) - len(self.gaps):+d} "
                f"degrees of freedom"
            )
        for value in self.values:
            if value not in self.start:
                raise LoopError(
                    f"nothing says where {value} starts: give it in `start` of a loop that it "
                    f"closes"
                )
        for gap, expr in self.gaps.items():
            if not expr.free_symbols & set(self.values):
                raise LoopError(
                    f"{gap} holds none of the coordinates {', '.join(map(str, self.values))}"
                )

    def jacobian(self) -> list[list[Expr]]:
        """Return the Jacobian of the gaps (rows) in the coordinates (columns)."""
        return [[gap.diff(value) for value in self.values] for gap in self.gaps.values()]

    def steps(self, motion: Motion) -> tuple[Step, ...]:
        """Coordinates by Newton steps from where they were found, then their rates and
        accelerations.
        """
        self._check()
        if not self.coordinates:
            return ()
        positions = self._positions()
        self.rate_steps = tuple(self._rates(motion))
        return (*positions, *self.rate_steps)

    def _positions(self) -> list[Step]:
        newton_steps: list[Step] = []
        position = [c.given for c in self.coordinates]
        for turn in range(1, ROUNDS + 1):
            at = dict(zip(self.values, position, strict=True))
            steps = [c.step(turn) for c in self.coordinates]
            rows, gaps = self.jacobian(), list(self.gaps.values())
            moved = [
                gap.xreplace(at)
                + sum(entry.xreplace(at) * s for entry, s in zip(row, steps, strict=True))
                for gap, row in zip(gaps, rows, strict=True)
            ]
            newton_steps += solve_linear_set(moved, steps, f"derived: loops, Newton step {turn}")
            last = turn == ROUNDS
            new = [c.value if last else c.near(turn) for c in self.coordinates]
            newton_steps += [
                Let(n, h + s, f"derived: {n.meaning}")
                for n, h, s in zip(new, position, steps, strict=True)
            ]
            position = new
        return newton_steps

    def _rates(self, motion: Motion) -> list[Step]:
        """The gaps stay closed: their first and second derivatives in time vanish."""
        rates, accelerations = (
            [c.rate for c in self.coordinates],
            [c.acceleration for c in self.coordinates],
        )
        once = [motion.rate(gap) for gap in self.gaps.values()]
        twice = [motion.rate(gap) for gap in once]
        return [
            *solve_linear_set(once, rates, "derived: loops stay closed, rates"),
            *solve_linear_set(twice, accelerations, "derived: loops stay closed, accelerations"),
        ]

    def functions(
        self, angle: Quantity, data: Vector, before: Sequence[Let]
    ) -> tuple[ClosedForm, ...]:
        """Build two functions: the coordinates at the angle zero, and the gaps with their Jacobian
        (row by row).

        ``before`` are the steps that the gaps may need.
        """
        if not self.coordinates:
            return ()
        start = tuple(Let(c.value, self.start[c.value], "given: start") for c in self.coordinates)
        at = dict(zip(self.values, self.given, strict=True))
        gaps = [
            Let(_gap(name), gap.xreplace(at), "derived: gap") for name, gap in self.gaps.items()
        ]
        slopes = [
            Let(_slope(gap.symbol, value), entry.xreplace(at), "derived: Jacobian of the gaps")
            for gap, row in zip(gaps, self.jacobian(), strict=True)
            for value, entry in zip(self.values, row, strict=True)
        ]
        outputs = Vector("gaps", tuple(step.symbol for step in (*gaps, *slopes)))
        closure = needed((*before, *gaps, *slopes), frozenset(outputs))
        return (
            ClosedForm("assembly", (data,), start, Vector("start", self.values)),
            ClosedForm("closure", (angle, data, self.given), closure, outputs),
        )


def _gap(name: str) -> Quantity:
    return Quantity(name, "m", f"gap of the loop {name.removeprefix('gap_')}", "derived: loops")


def _slope(gap: Quantity, value: Quantity) -> Quantity:
    unit = {"m": "1", "rad": "m"}.get(value.unit, "1")
    return Quantity(f"{gap}_by_{value}", unit, f"slope of {gap} over {value}", "derived: loops")
