"""Frames as data; vectors and points in frames; differentiation in time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache, reduce
from typing import TypeAlias

import sympy as sp
from sympy import Expr, Matrix, S

Triple = tuple[Expr, Expr, Expr]
Rows = tuple[Triple, Triple, Triple]
"""A matrix, row by row."""
Axis = tuple[int, int, int]
X: Axis = (1, 0, 0)
Y: Axis = (0, 1, 0)
Z: Axis = (0, 0, 1)
NO_AXIS: Axis = (0, 0, 0)
MOST_RESOLVED = 10_000
"""Vectors that are kept by their components in another frame."""
LONG = 50
"""Operations of a component that multiplying out only makes longer; what it shortens has fewer than
ten.
"""


class FrameError(ValueError):
    """Vectors of different frames are added or multiplied."""


@dataclass(frozen=True)
class Quaternion:
    """A turn in space by a unit quaternion, without unit: its scalar part and its vector part.

    Source: J. B. Kuipers, Quaternions and Rotation Sequences, Princeton 1999, chapters 5 to 7 and
    11.

    >>> from sympy import S
    >>> about_z = Quaternion(S(1) / 2, (S.Zero, S.Zero, sp.sqrt(3) / 2))
    >>> about_z.matrix()
    Matrix([
    [     -1/2, -sqrt(3)/2, 0],
    [sqrt(3)/2,       -1/2, 0],
    [        0,          0, 1]])
    >>> about_z * -about_z
    Quaternion(scalar=1, vector=(0, 0, 0))
    """

    scalar: Expr
    vector: Triple

    def __neg__(self) -> Quaternion:
        """Return the reverse turn."""
        x, y, z = self.vector
        return Quaternion(self.scalar, (-x, -y, -z))

    def __mul__(self, other: Quaternion) -> Quaternion:
        """Return the turn by ``other`` and then by this one, both along the axes of the root."""
        first, second = Matrix(self.vector), Matrix(other.vector)
        x, y, z = self.scalar * second + other.scalar * first + first.cross(second)
        return Quaternion(self.scalar * other.scalar - first.dot(second), (x, y, z))

    def matrix(self) -> sp.ImmutableMatrix:
        """Return the matrix of the turn (3, 3), without unit."""
        w, (x, y, z) = self.scalar, self.vector
        return sp.ImmutableMatrix(
            [
                [w**2 + x**2 - y**2 - z**2, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), w**2 - x**2 + y**2 - z**2, 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), w**2 - x**2 - y**2 + z**2],
            ]
        )


Turn: TypeAlias = "tuple[Axis, Expr | Quaternion]"


@dataclass(frozen=True)
class Frame:
    """A right-handed frame: its parent, turned by ``angle`` [rad] about ``axis``, a unit vector of
    both.

    A `Quaternion` in place of the angle turns the parent in any way; the axis is then NO_AXIS.
    """

    name: str
    parent: Frame | None = None
    axis: Axis = Z
    angle: Expr | Quaternion = S.Zero

    def turns(self) -> list[Turn]:
        """Return the rotations (axis, angle [rad]) that carry components in this frame to the root,
        outermost first.
        """
        return [] if self.parent is None else [*self.parent.turns(), (self.axis, self.angle)]

    def __str__(self) -> str:
        return self.name


@cache
def rotation(axis: Axis, angle: Expr | Quaternion) -> sp.ImmutableMatrix:
    """Return Rodrigues' matrix for a turn by ``angle`` [rad] about the unit vector ``axis``, or a
    quaternion's.
    """
    if isinstance(angle, Quaternion):
        return angle.matrix()
    cross = sp.ImmutableMatrix(
        3, 3, lambda i, j: -sum(sp.LeviCivita(i, j, k) * axis[k] for k in range(3))
    )
    return sp.eye(3) + sp.sin(angle) * cross + (1 - sp.cos(angle)) * cross * cross


def _merge(turns: list[Turn]) -> list[Turn]:
    """Return turns with adjacent ones about one axis made one; those by nothing and those that
    cancel vanish.
    """
    merged: list[Turn] = []
    for axis, angle in turns:
        before = merged.pop() if merged and merged[-1][0] == axis else None
        if before is None:
            merged += [(axis, angle)] if angle != 0 else []
        elif isinstance(angle, Quaternion) or isinstance(before[1], Quaternion):
            merged += [before, (axis, angle)] if before[1] != -angle else []
        elif before[1] + angle != 0:
            merged.append((axis, before[1] + angle))
    return merged


@dataclass(frozen=True)
class Vec:
    """A vector by its components in a frame, in the unit of the components; vectors of different
    frames do not mix.

    Sum, difference, product with a number, `dot` and `cross` raise FrameError for another frame:
    use `resolved`.
    """

    frame: Frame
    components: Triple

    def __add__(self, other: Vec) -> Vec:
        self._same_frame(other)
        return self._with(a + b for a, b in zip(self.components, other.components, strict=True))

    def __neg__(self) -> Vec:
        return self._with(-a for a in self.components)

    def __sub__(self, other: Vec) -> Vec:
        return self + (-other)

    def __rmul__(self, factor: Expr) -> Vec:
        return self._with(factor * a for a in self.components)

    def __getitem__(self, index: int) -> Expr:
        return self.components[index]

    def dot(self, other: Vec) -> Expr:
        """Return the scalar product, in the product of both units.

        Raises FrameError for a vector of another frame.
        """
        self._same_frame(other)
        return sp.Add(*(a * b for a, b in zip(self.components, other.components, strict=True)))

    def cross(self, other: Vec) -> Vec:
        """Return the vector product, in the product of both units.

        Raises FrameError for a vector of another frame.
        """
        self._same_frame(other)
        return Vec(self.frame, multiply_cross(self.components, other.components))

    def resolved(self, frame: Frame) -> Vec:
        """Return the same vector by its components in ``frame``, in the same unit."""
        return _resolve(self, frame)

    def _with(self, components: Iterable[Expr]) -> Vec:
        x, y, z = (sp.sympify(c) for c in components)
        return Vec(self.frame, (x, y, z))

    def _same_frame(self, other: Vec) -> None:
        if self.frame != other.frame:
            raise FrameError(
                f"a vector in frame {self.frame} meets one in frame {other.frame}; resolve one of "
                f"them"
            )


@lru_cache(maxsize=MOST_RESOLVED)
def _resolve(vector: Vec, frame: Frame) -> Vec:
    """Return a vector by its components in a frame; a chain of bodies asks for the same ones again
    and again.
    """
    inverse = [(axis, -angle) for axis, angle in reversed(frame.turns())]
    turns = _merge(inverse + vector.frame.turns())
    turned = reduce(lambda v, turn: rotation(*turn) * v, reversed(turns), Matrix(vector.components))
    return Vec(frame, tuple(turned))


def multiply_cross(first: Triple, second: Triple) -> Triple:
    """Return the components of a vector product, in the product of both units."""
    (a, b, c), (x, y, z) = first, second
    return b * z - c * y, c * x - a * z, a * y - b * x


def zero(frame: Frame) -> Vec:
    """Return the zero vector by components of ``frame``, in any unit."""
    return Vec(frame, (S.Zero, S.Zero, S.Zero))


def unit(frame: Frame, axis: Axis) -> Vec:
    """Return the vector of length one along an axis of ``frame``, without unit."""
    return Vec(frame, tuple(sp.Integer(a) for a in axis))


def shorten_vector(vector: Vec) -> Vec:
    """Return the same vector with components multiplied out where that saves operations; long ones
    stay.
    """
    x, y, z = map(_shorter, vector.components)
    return Vec(vector.frame, (x, y, z))


def _shorter(component: Expr) -> Expr:
    if (size := sp.count_ops(component)) > LONG:
        return component
    expanded = sp.expand(component)
    return expanded if sp.count_ops(expanded) < size else component


@dataclass(frozen=True)
class Point:
    """A point: its ``base``, another point, and the ``offset`` from it [m].

    The origin has neither.
    """

    name: str
    base: Point | None = None
    offset: Vec | None = None

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        # computed once: that of a point at the end of a chain takes all points before it
        return hash((self.name, self.base, self.offset))

    def chain(self) -> dict[Point, Vec | None]:
        """Return the points from the origin to this one, each with its offset [m] from the one
        before.
        """
        return {self: None} if self.base is None else {**self.base.chain(), self: self.offset}


class InputRateError(ValueError):
    """A rate is needed of what an input decides."""


@dataclass
class Motion:
    """The rates of quantities: ``rates[q]`` is dq/dt [the unit of q per s]; what is not listed is
    constant.

    A mechanism holds its own as ``motion``; frames, points and vectors are differentiated by it.
    ``accelerations`` [m/s2] and ``places`` (base points and offsets [m]) hold results that have
    names of their own. ``inputs`` are quantities whose rates nobody knows.

    >>> from derive import Frame, Motion, Point, Quantity, X, unit
    >>> phi, omega = Quantity("phi", "rad", "angle", "own"), Quantity("omega", "rad/s", "its rate", "own")
    >>> r = Quantity("r", "m", "radius", "own")
    >>> motion, world = Motion({phi: omega}), Frame("world")
    >>> turned = Frame("turned", world, angle=phi)
    >>> arm = r * unit(turned, X)
    >>> motion.rate(phi**2), motion.spin(turned).components
    (2*omega*phi, (0, 0, omega))
    >>> motion.derivative(arm).components, motion.relative_derivative(arm, turned).components
    ((0, omega*r, 0), (0, 0, 0))
    >>> O = Point("O")
    >>> A = Point("A", O, arm)
    >>> motion.acceleration(A, turned).components, motion.arm(O, A, world).components
    ((-omega**2*r, 0, 0), (r*cos(phi), r*sin(phi), 0))
    >>> motion.drift(O, A, world).components
    (-omega*r*sin(phi), omega*r*cos(phi), 0)
    """

    rates: dict[sp.Symbol, Expr] = field(default_factory=dict)
    accelerations: dict[Point, Vec] = field(default_factory=dict)
    places: dict[Point, tuple[Point, Vec]] = field(default_factory=dict)
    inputs: set[sp.Symbol] = field(default_factory=set)
    _bends: dict[tuple[Vec, Frame], Vec] = field(default_factory=dict, repr=False)

    def rate(self, expr: Expr) -> Expr:
        """Return the time derivative of a scalar by the chain rule [its unit per s].

        Raises InputRateError for an expression of an input.
        """
        self._refuse_inputs(expr)
        moving = sorted(expr.free_symbols & self.rates.keys(), key=str)
        return sp.Add(*(expr.diff(q) * self.rates[q] for q in moving))

    def _refuse_inputs(self, expr: Expr) -> None:
        if unknown := sorted(map(str, expr.free_symbols & self.inputs)):
            raise InputRateError(
                f"{', '.join(unknown)}: an input has no derivative: let forces and torques depend "
                "on it, not places; a coordinate that follows it needs a motor or a spring"
            )

    def spin(self, frame: Frame, seen_from: Frame | None = None) -> Vec:
        """Return the angular velocity [rad/s] of a frame, along its own axes, absolute or
        ``seen_from`` an ancestor.
        """
        if frame.parent is None or frame == seen_from:
            return zero(frame)
        return self.spin(frame.parent, seen_from).resolved(frame) + self._relative_spin(frame)

    def _relative_spin(self, frame: Frame) -> Vec:
        """Return the angular velocity of a frame as its parent sees it; of a quaternion q, the
        vector of 2 q* dq/dt.
        """
        if not isinstance(frame.angle, Quaternion):
            return self.rate(frame.angle) * unit(frame, frame.axis)
        x, y, z = map(self.rate, frame.angle.vector)
        return 2 * Vec(
            frame, (-frame.angle * Quaternion(self.rate(frame.angle.scalar), (x, y, z))).vector
        )

    def derivative(self, vector: Vec) -> Vec:
        """Return the absolute time derivative of a vector [its unit per s], along the axes of the
        vector's frame.
        """
        relative = Vec(vector.frame, tuple(self.rate(c) for c in vector.components))
        return relative + self.spin(vector.frame).cross(vector)

    def relative_derivative(self, vector: Vec, observer: Frame) -> Vec:
        """Return the time derivative of a vector as seen from ``observer`` [its unit per s], in the
        vector's frame.
        """
        return self.derivative(vector) - self.spin(observer).resolved(vector.frame).cross(vector)

    def resolve(self, vector: Vec, frame: Frame) -> Vec:
        """Return a vector by its components in a frame, in the same unit."""
        return vector.resolved(frame)

    def velocity(self, point: Point, frame: Frame) -> Vec:
        """Return the absolute velocity of a point [m/s], along the axes of ``frame``."""
        origin = next(iter(point.chain()))
        return self.derivative(displacement(origin, point, frame))

    def angular_momentum(self, tensor: Rows, frame: Frame) -> Vec:
        """Return the angular momentum [kg m2/s] of an inertia [kg m2] along the axes of ``frame``,
        with which it turns; its axes are those of the `spin`.
        """
        spin = self.spin(frame)
        x, y, z = Matrix(tensor) * Matrix(spin.components)
        return Vec(spin.frame, (x, y, z))

    def momentum_rate(self, tensor: Rows, frame: Frame) -> Vec:
        """Return the rate of that [N m]."""
        return self.derivative(self.angular_momentum(tensor, frame))

    def acceleration(self, point: Point, frame: Frame) -> Vec:
        """Return the absolute acceleration of a point [m/s2], along the axes of ``frame``."""
        if point in self.accelerations:
            return self.accelerations[point].resolved(frame)
        base, offset = self.places.get(point, (point.base, point.offset))
        if base is None or offset is None:
            return zero(frame)
        return self.acceleration(base, frame) + self._bend(offset, frame)

    def _bend(self, offset: Vec, frame: Frame) -> Vec:
        """Second derivative of an offset in components of ``frame``."""
        if (offset, frame) not in self._bends:
            velocity = shorten_vector(self.derivative(offset.resolved(frame)))
            self._bends[offset, frame] = shorten_vector(self.derivative(velocity))
        return self._bends[offset, frame]

    def drift(self, base: Point, point: Point, frame: Frame) -> Vec:
        """Return the rate of the vector from ``base`` to ``point`` as seen from ``frame`` [m/s],
        along its axes.

        It is expressed by named places where there are any. The offsets between the points must
        stand in ``frame`` or in frames that descend from it.
        """
        if point == base or point.base is None or point.offset is None:
            return zero(frame)
        offset_frame = point.offset.frame
        stretch = Vec(offset_frame, tuple(self.rate(c) for c in point.offset.components)).resolved(
            frame
        )
        turning = self.spin(offset_frame, seen_from=frame).resolved(frame)
        swept = stretch + turning.cross(self.arm(point.base, point, frame))
        named_base, named = self.places.get(point.base, (None, None))
        if named is None or named_base != base or named.frame != frame:
            return self.drift(base, point.base, frame) + swept
        return Vec(frame, tuple(self.rate(c) for c in named.components)) + swept

    def arm(self, start: Point, end: Point, frame: Frame) -> Vec:
        """Return the vector from ``start`` to ``end`` [m] along the axes of ``frame``.

        It is expressed by named places where there are any.
        """
        return _difference(self._named_chain(start), self._named_chain(end), frame)

    def _named_chain(self, point: Point) -> dict[Point, Vec | None]:
        base, offset = self.places.get(point, (point.base, point.offset))
        return {point: None} if base is None else {**self._named_chain(base), point: offset}


def displacement(start: Point, end: Point, frame: Frame) -> Vec:
    """Return the vector from ``start`` to ``end`` [m] along the axes of ``frame``.

    Offsets that both points share on the way from the origin cancel.
    """
    return _difference(start.chain(), end.chain(), frame)


def _difference(start: dict[Point, Vec | None], end: dict[Point, Vec | None], frame: Frame) -> Vec:
    by_frame: dict[Frame, Vec] = {}
    for sign, chain, opposite in ((S.One, end, start), (S.NegativeOne, start, end)):
        for point, offset in chain.items():
            if point not in opposite and offset:
                so_far = by_frame.get(offset.frame, zero(offset.frame))
                by_frame[offset.frame] = so_far + sign * offset
    resolved = [part.resolved(frame).components for part in by_frame.values()]
    x, y, z = (sp.Add(*components) for components in zip((S.Zero,) * 3, *resolved, strict=True))
    return Vec(frame, (x, y, z))
