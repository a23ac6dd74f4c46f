"""A prescribed motion as named steps: coordinates with their rates, places, accelerations, gear stages."""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..branches import clip, clip_slope
from ..model import Call, Let, RuntimeFunction, Step
from ..quantity import OpenVector, Quantity
from .frames import Frame, Motion, Point, Vec, displacement, shorter


@dataclass(frozen=True)
class GearStage:
    """A pair of non-circular gears whose pitch curves are chosen at run time: the vectors of the inner one."""

    number: int
    parameters: OpenVector
    hoisted: OpenVector

    @property
    def contact(self) -> RuntimeFunction:
        takes, gives = ("t", "parameters", "hoisted"), ("r", "dr", "ddr", "ratio", "dratio", "turned")
        return RuntimeFunction(f"stage{self.number}", "contact functions of pitch curves", takes, gives)

    def call(self, argument: Expr, when: str = "", **outputs: Quantity) -> Call:
        """Contact at a polar angle of the inner gear; ``outputs`` are those of its results that have a use."""
        contact = self.contact
        named = tuple(outputs.get(name) for name in contact.gives)
        source = f"derived: stage {self.number}{when}"
        return Call(named, contact, argument, (self.parameters, self.hoisted), source)


@dataclass(frozen=True)
class FollowerLaw:
    """How a follower goes from one dwell to the next, by a law that is chosen at run time."""

    name: str

    @property
    def function(self) -> RuntimeFunction:
        return RuntimeFunction(self.name, "laws of cam flanks", ("x",), ("p", "dp", "ddp"))


@dataclass
class Kinematics:
    """The prescribed motion of a machine along an angle: named steps, and how the named quantities change in time.

    ``start`` holds what is known at the angle zero.
    """

    angle: Quantity
    motion: Motion
    start: dict[sp.Symbol, Expr]
    steps: list[Step] = field(default_factory=list)

    @classmethod
    def along(cls, angle: Quantity, speed: Quantity) -> Kinematics:
        """The motion of what turns at a constant speed."""
        return cls(angle, Motion({angle: speed}), {angle: S.Zero})

    def let(self, symbol: Quantity, expr: Expr) -> Quantity:
        """Name an expression; how it changes in time is not followed."""
        self.steps.append(Let(symbol, expr, f"derived: {symbol.meaning}"))
        return symbol

    def coordinate(
        self, symbols: tuple[Quantity, Quantity, Quantity], expr: Expr, at_start: Expr | None = None
    ) -> None:
        """Name a coordinate, its rate and its acceleration; ``at_start`` is what it is at the angle zero."""
        value, rate, acceleration = symbols
        self.let(value, expr)
        velocity = self.motion.rate(expr)
        self.let(rate, velocity)
        self.let(acceleration, self.motion.rate(velocity))
        self.motion.rates |= {value: rate, rate: acceleration}
        self.start |= {} if at_start is None else {value: at_start}

    def stage(
        self, stage: GearStage, t: Quantity, argument: Expr, *, r: Quantity, dr: Quantity, ratio: Quantity,
        dratio: Quantity, turned: Quantity, start: Quantity,
    ) -> None:  # fmt: skip
        """Contact of a gear stage at the polar angle ``t`` of its inner gear; ``start`` is ``turned`` at angle zero.

        Raises ValueError where the polar angle is not known there.
        """
        at_start = argument.xreplace(self.start)
        if moving := sorted(map(str, at_start.free_symbols & self.motion.rates.keys())):
            raise ValueError(f"stage {stage.number}: nothing says what {', '.join(moving)} is at {self.angle} = 0")
        self.let(t, argument)
        self.steps.append(stage.call(at_start, f", {self.angle} = 0", turned=start))
        self.steps.append(stage.call(t, r=r, dr=dr, ratio=ratio, dratio=dratio, turned=turned))
        rate = self.motion.rate(argument)
        self.motion.rates |= {t: rate, r: dr * rate, ratio: dratio * rate, turned: ratio * rate}

    def flank(
        self, law: FollowerLaw, angle: Quantity, ends: tuple[Expr, Expr], x: Quantity, pace: Quantity,
        shares: tuple[Quantity, Quantity, Quantity],
    ) -> None:  # fmt: skip
        """A cam's flank between two angles: position x in it, how fast it is passed, share of the rise with slopes."""
        start, end = ends
        place, (share, slope, bend) = (angle - start) / (end - start), shares
        self.let(x, clip(place, S.Zero, S.One))
        self.let(pace, clip_slope(place, 1 / (end - start)))
        self.steps.append(Call(shares, law.function, x, (), f"derived: {x.meaning}"))
        passed = pace * self.motion.rates[angle]
        self.motion.rates |= {x: passed, share: slope * passed, slope: bend * passed}

    def name_acceleration(self, point: Point, frame: Frame, symbols: tuple[Quantity, ...]) -> None:
        """Name the components of a point's acceleration along ``frame``."""
        acceleration = self.motion.acceleration(point, frame)
        for symbol, component in zip(symbols, acceleration.components, strict=False):
            self.let(symbol, component)
        self.motion.accelerations[point] = _vector(frame, symbols, acceleration.components)

    def name_place(self, point: Point, base: Point, frame: Frame, symbols: tuple[Quantity, ...]) -> None:
        """Name a point's coordinates from ``base`` along ``frame``."""
        place = displacement(base, point, frame)
        for symbol, component in zip(symbols, place.components, strict=False):
            self.let(symbol, component)
        self.motion.places[point] = base, _vector(frame, symbols, place.components)
        drift = shorter(self.motion.drift(base, point, frame))
        self.motion.rates |= dict(zip(symbols, drift.components, strict=False))

    def hang(self, point: Point, hinge: Point) -> None:
        """Count a named place from the hinge that the point swings about, so that its motion is told from there."""
        base, named = self.motion.places[point]
        self.motion.places[point] = hinge, named - self.motion.arm(base, hinge, named.frame)

    def mirror_place(self, image: Point, point: Point, base: Point, frame: Frame, plane: Expr) -> None:
        """Name the place of a mirror image by that of its original, which it must be, in ``z = plane`` of ``frame``."""
        place, meant = self.motion.arm(base, point, frame), displacement(base, point, frame)
        difference = displacement(base, image, frame) - Vec(frame, (meant[0], meant[1], 2 * plane - meant[2]))
        if any(sp.simplify(c) != 0 for c in difference.components):
            raise ValueError(f"{image.name} is not the mirror image of {point.name}")
        self.motion.places[image] = base, Vec(frame, (place[0], place[1], 2 * plane - place[2]))


def _vector(frame: Frame, symbols: tuple[Quantity, ...], others: tuple[Expr, Expr, Expr]) -> Vec:
    """A vector by names, and by other components where the names end."""
    components: list[Expr] = [*symbols, *others[len(symbols) :]]
    return Vec(frame, (components[0], components[1], components[2]))
