"""Quantities with first and second time derivative, and vectors of them, on arrays and on mpmath
numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

Number = Any


@dataclass(frozen=True)
class Jet:
    """A value, its rate and its acceleration; `xp` gives the elementary functions.

    >>> import numpy
    >>> t = Jet(numpy, 2.0, 1.0, 0.0)
    >>> (t * t * t).rate, (t * t * t).acceleration
    (12.0, 12.0)
    """

    xp: ModuleType
    value: Number
    rate: Number = 0
    acceleration: Number = 0

    def _lift(self, other: Jet | Number) -> Jet:
        return other if isinstance(other, Jet) else Jet(self.xp, other)

    def __add__(self, other: Jet | Number) -> Jet:
        o = self._lift(other)
        return Jet(
            self.xp, self.value + o.value, self.rate + o.rate, self.acceleration + o.acceleration
        )

    def __neg__(self) -> Jet:
        return Jet(self.xp, -self.value, -self.rate, -self.acceleration)

    def __sub__(self, other: Jet | Number) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Number) -> Jet:
        return -self + other

    def __mul__(self, other: Jet | Number) -> Jet:
        o = self._lift(other)
        second = self.acceleration * o.value + 2 * self.rate * o.rate + self.value * o.acceleration
        return Jet(self.xp, self.value * o.value, self.rate * o.value + self.value * o.rate, second)

    def __truediv__(self, other: Jet | Number) -> Jet:
        o = self._lift(other)
        return self * o.through(1 / o.value, -1 / o.value**2, 2 / o.value**3)

    def __rtruediv__(self, other: Number) -> Jet:
        return self._lift(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def through(self, f: Number, df: Number, ddf: Number) -> Jet:
        """A function of this quantity, given by its value and derivatives here (chain rule)."""
        second = ddf * self.rate**2 + df * self.acceleration
        return Jet(self.xp, f, df * self.rate, second)

    def cos(self) -> Jet:
        c, s = self.xp.cos(self.value), self.xp.sin(self.value)
        return self.through(c, -s, -c)

    def sin(self) -> Jet:
        c, s = self.xp.cos(self.value), self.xp.sin(self.value)
        return self.through(s, c, -s)

    def sqrt(self) -> Jet:
        root = self.xp.sqrt(self.value)
        return self.through(root, 1 / (2 * root), -1 / (4 * root * self.value))

    def integrated(self, value: Number) -> Jet:
        """The quantity whose rate this is, from its value."""
        return Jet(self.xp, value, self.value, self.rate)

    def where(self, condition: Any, other: Jet | Number) -> Jet:
        """This quantity where the condition holds, the other elsewhere."""
        o = self._lift(other)
        pairs = zip(self.parts, o.parts, strict=True)
        return Jet(self.xp, *(self.xp.where(condition, jet, its) for jet, its in pairs))

    @property
    def parts(self) -> tuple[Number, Number, Number]:
        return self.value, self.rate, self.acceleration


Place = tuple[Jet, Jet, Jet]


def added(*places: Place) -> Place:
    x, y, z = (sum(components[1:], components[0]) for components in zip(*places, strict=True))
    return x, y, z


def turned_z(angle: Jet, place: Place) -> Place:
    """The vector after a turn by `angle` about z."""
    c, s, (x, y, z) = angle.cos(), angle.sin(), place
    return c * x - s * y, s * x + c * y, z


def turned_y(angle: Jet, place: Place) -> Place:
    """The vector after a turn by `angle` about y."""
    c, s, (x, y, z) = angle.cos(), angle.sin(), place
    return c * x + s * z, y, c * z - s * x
