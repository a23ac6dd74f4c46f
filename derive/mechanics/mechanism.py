"""A mechanism as it is drawn: frames, points, bodies, joints, forces. What follows from them is derived."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy as sp
from sympy import Expr, S

from ..dimensions import NONE, DimensionError, dimension
from ..model import Input, Lane, Let, Step, System
from ..quantity import Quantity
from ..table import NOTHING, Quantities
from . import moving, turning, twins
from .bodies import AXES
from .frames import Axis, Frame, Motion, Point, Vec, Z, displacement, unit
from .joints import Joints, Scalar
from .statement import MechanismError, triple

TIME = Quantity("time", "s", "time", "given")
WORLD = Frame("world")


class Mechanism(Joints):
    """Bodies that move along ``angle``, which turns at the constant ``speed``, or by themselves where none is given.

    With ``acceleration``, one of the quantities, the speed changes at that rate, so that a motor line can drive them.
    They move in the plane across z unless ``spatial``. ``given`` is the table of all quantities; ``gravity`` the
    acceleration of free fall, along -y of the ``world``, or its components there. Lengths in m, angles in rad. Every
    name becomes a name in the generated code.
    """

    def __init__(
        self,
        name: str,
        given: Quantities = NOTHING,
        *,
        angle: Quantity | None = None,
        speed: Quantity | None = None,
        acceleration: Quantity | None = None,
        gravity: Scalar | Sequence[Scalar] = 0,
        title: str = "",
        source: str = "own",
        assumptions: Iterable[str] = (),
        spatial: bool = False,
        world: Frame = WORLD,
    ) -> None:
        if (angle is None) != (speed is None):
            raise MechanismError(f"{name}: an angle to move along needs its speed, and a speed an angle")
        if acceleration is not None and angle is None:
            raise MechanismError(f"{name}: an acceleration is that of an angle to move along, which is lacking")
        for driving, unit_ in ((angle, "rad"), (speed, "rad/s"), (acceleration, "rad/s2")):
            if driving is not None and driving.unit != unit_:
                raise MechanismError(
                    f"{name}: {driving} ({driving.meaning}) is in {driving.unit}, but a mechanism is driven along an "
                    "angle in rad at a speed in rad/s, which changes in rad/s2; state a length as a coordinate that "
                    "the angle moves"
                )
        fall = gravity if isinstance(gravity, Sequence) else (0, -gravity, 0)
        changing = {} if acceleration is None else {speed: acceleration}
        motion = moving.FreeMotion({TIME: S.One}) if angle is None else Motion({angle: speed, **changing})
        super().__init__(name, given, angle, motion, fall, spatial, world)
        self.title, self.source, self.speed = title or name.replace("_", " ").capitalize(), source, speed
        self.acceleration = acceleration
        steady = (f"constant: {speed.meaning}",) if speed is not None and acceleration is None else ()
        self.assumptions = ("rigid bodies", *steady, *assumptions)

    @property
    def time(self) -> Quantity:
        """Time [s], for what is prescribed to a mechanism that moves by itself."""
        return TIME

    def frame(self, name: str, angle: Scalar, axis: Axis = Z, parent: Frame | None = None) -> Frame:
        """A frame turned by an angle [rad] about an axis of its parent, the world unless one is named.

        Raises DimensionError for what is no angle.
        """
        try:
            found = dimension(sp.sympify(angle))
        except DimensionError as error:
            raise DimensionError(f"frame {name}: {error}") from None
        if found not in (None, NONE):
            raise DimensionError(f"frame {name}: its angle {angle} is not in rad")
        return Frame(name, parent or self.world, axis, sp.sympify(angle))

    def point(self, name: str, base: Point, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Point:
        """A point at an offset [m] from another, in components of a frame."""
        return Point(name, base, self.vector(frame, x, y, z))

    def vector(self, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Vec:
        """A vector by its components in a frame."""
        return Vec(frame, triple((x, y, z)))

    def position(self, point: Point, frame: Frame | None = None) -> Vec:
        """A point's place from the origin [m], in components of the world or of a frame."""
        return displacement(self.O, point, frame or self.world)

    def velocity(self, point: Point) -> Vec:
        """A point's velocity in the world [m/s]."""
        return self.motion.derivative(self.position(point))

    def close(self, first: Point, second: Point, start: Mapping[Quantity, Scalar]) -> None:
        """Two points are one, always; ``start`` says about where coordinates are at the angle zero."""
        gap = displacement(first, second, self.world)
        for axis, component in zip(AXES if self.spatial else AXES[:2], gap.components, strict=False):
            self.constrain(f"{first.name}{axis}", component, start)

    def parallel(
        self, name: str, first: tuple[Frame, Axis], second: tuple[Frame, Axis], start: Mapping[Quantity, Scalar]
    ) -> None:
        """An axis of one frame stays parallel to one of another, as a hinge that closes a loop in space keeps them."""
        way = unit(*second).resolved(first[0])
        for axis, component in (
            (a, c) for a, c, along in zip(AXES, way.components, first[1], strict=True) if not along
        ):
            self.constrain(f"{name}{axis}", component, start)

    def begin(self, start: Mapping[Quantity, Scalar]) -> None:
        """What coordinates, or their rates (``motion.rates``), are at the start of free motion; zero unless told."""
        self.start |= {q: sp.sympify(at) for q, at in start.items()}

    def rate(self, expr: Expr) -> Expr:
        """Rate of an expression of coordinates."""
        return self.motion.rate(expr)

    def twin_lane(
        self, sides: twins.Sides, inputs: Sequence[Input], forces: Sequence[Step] | None = None,
        frame: Sequence[Let] | None = None,
    ) -> Lane:  # fmt: skip
        """The lane of one of two equal sides, and what it adds up to with the other, from packed ``inputs``.

        Steps for the ``forces`` of a side and in the ``frame`` that both share may come from elsewhere; else they
        follow from the balances. Raises MechanismError, ChainError or DimensionError where they do not.
        """
        return twins.along(self, sides, inputs, forces, frame)

    def accelerations(self) -> tuple[Expr, ...]:
        """Those of the coordinates of a mechanism that moves by itself, in symbols; raises MechanismError."""
        return moving.accelerations(self, TIME)

    def system(self, reported: Sequence[str | Quantity] | None = None) -> System:
        """The model: what is reported (everything, unless told) along the angle, or what an integrator needs.

        Raises MechanismError, LoopError, ChainError or DimensionError where it cannot be derived.
        """
        if self.angle is not None and self.speed is not None:
            lane, functions = turning.along(self, self.angle, self.speed, self.acceleration, reported)
            return System(
                self.name, self.title, self.source, self.assumptions, lane, functions, self.given.data,
                pushing=tuple(force.name for force in self.pushing if force in lane.outputs),
                axes=self.component_axes,
                meshes={tag: (inner.name, outer.name) for tag, (inner, outer, _) in self.meshing.items()},
            )  # fmt: skip
        functions = moving.freely(self, TIME, reported)
        return System(
            self.name, self.title, self.source, self.assumptions, None, functions, self.given.data,
            axes=self.component_axes,
        )  # fmt: skip
