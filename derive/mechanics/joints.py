"""Bodies of a mechanism, the joints between them, springs and forces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import sympy as sp
from sympy import Expr, S

from ..branches import switch
from ..model import Event
from ..quantity import Quantity
from .bodies import AXES, SHAFT, Body, Part, Pin
from .contacts import Contacts
from .frames import Axis, Frame, Point, Vec, X, Z, displacement, unit, zero
from .laws import velocity
from .statement import MechanismError, triple

Scalar: TypeAlias = Expr | float


class Joints(Contacts):
    """What a mechanism is made of; its motion stands in `Mechanism`."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The ground, then every body in the order in which it was stated."""
        return tuple(self.assembly.bodies)

    def body(
        self, name: str, frame: Frame, mass: Quantity | None = None, centroid: Point | None = None,
        inertia: Scalar | Sequence[Scalar] = 0, about: Point | None = None, *, parts: Sequence[Part] = (),
        axes: Frame | None = None, tilting: bool = True, shared: bool = False,
    ) -> Body:  # fmt: skip
        """A rigid body that turns with a frame; one without a mass only passes forces on.

        ``inertia`` is that about the centroid: across the plane, or the diagonal of the tensor in the body's frame, or
        its entries xx, yy, zz, xy, xz, yz [kg m2]; ``parts`` are rigid pieces besides. Moments are taken about
        ``about``, else about a joint, the ground's before others; components along ``axes``, else the world's. In
        space a shaft's moments across z may be left out, not ``tilting``. Equal sides have a ``shared`` body in common.
        """
        if (mass is None) != (centroid is None):
            raise MechanismError(f"body {name}: a mass needs a centroid, and a centroid a mass")
        if name in {body.name for body in self.assembly.bodies}:
            raise MechanismError(f"two bodies are called {name}")
        tensor = inertia if isinstance(inertia, Sequence) else (0, 0, inertia)
        own = (Part(mass, centroid, tuple(map(sp.sympify, tensor))),) if mass is not None and centroid else ()
        pin = None if about is None else Pin(about, axes or self.world, self.asked if tilting else SHAFT)
        body = self.assembly.add(Body(name, frame, (*own, *parts), pin))
        self.shared += [body] if shared else []
        return body

    def pin(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z, axes: Frame | None = None) -> None:
        """A revolute joint about an axis of ``by``'s frame: the force F_name on a body, by the world's axes or others.

        In space moments M_name too, by the axes of ``by``'s frame, if the body's balances ask for them. What is told by
        other axes than the world's is told by the world's as well, as F_name_world_x or M_name_world_x.
        """
        tilting = self.spatial and (on.pin is None or on.pin.asked != SHAFT)
        self._joint(name, on, by, at, self._directions, _across(axis) if tilting else (), axes)

    def weld(self, name: str, on: Body, by: Body, at: Point) -> None:
        """A rigid joint: every force and every moment."""
        self._joint(name, on, by, at, self._directions, range(3) if self.spatial else (2,))

    def ball(self, name: str, on: Body, by: Body, at: Point) -> None:
        """A spherical joint: every force, no moment."""
        self._joint(name, on, by, at, self._directions, ())

    def universal(self, name: str, on: Body, by: Body, at: Point, axis: Axis, other: Axis) -> None:
        """A universal joint about an ``axis`` of ``by``'s frame and an ``other`` of ``on``'s: one moment M_name."""
        self._in_space(name)
        cross = unit(by.frame, axis).cross(unit(on.frame, other).resolved(by.frame))
        self._joint(name, on, by, at, self._directions, ())
        moment = self.assembly.unknown(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}, across both axes")
        self.assembly.act(f"{name}, moment", on, by, at, zero(by.frame), moment * cross)

    def cylinder(self, name: str, on: Body, by: Body, at: Point, axis: Axis) -> None:
        """A cylindrical joint, which turns about and slides along an axis of ``by``'s frame."""
        self._in_space(name)
        self._joint(name, on, by, at, _across(axis), _across(axis), by.frame)

    def plane(self, name: str, on: Body, by: Body, at: Point, normal: Axis) -> None:
        """A planar joint: a force along the ``normal`` of ``by``'s frame, moments across it."""
        self._in_space(name)
        self._joint(name, on, by, at, [i for i in range(3) if normal[i]], _across(normal), by.frame)

    def wheel(self, name: str, on: Body, centre: Point, radius: Scalar, axle: Axis, up: Axis) -> None:
        """A thin wheel rolls without slip on the plane through the origin that is normal to an axis of the world.

        ``centre`` is fixed in the body, ``axle`` an axis of its frame; F_name is the plane's force on it.
        """
        self._in_space(name)
        way, normal = unit(on.frame, axle).resolved(self.world), unit(self.world, up)
        tilt = way.dot(normal)
        upright = sp.sqrt(1 - tilt**2)
        contact = Point(f"{name}, contact", centre, (-radius / upright) * (normal - tilt * way))
        self.constrain(name, displacement(self.O, centre, self.world).dot(normal) - radius * upright, {})
        arm = displacement(centre, contact, self.world)
        slip = velocity(self.motion, centre, self.world) + self.motion.spin(on.frame).resolved(self.world).cross(arm)
        for i in _across(up):
            self.roll(f"{name}{AXES[i]}", slip[i])
        self._joint(name, on, self.ground, contact, range(3), ())

    def slide(
        self, name: str, on: Body, by: Body, at: Point, along: Axis = X, friction: Scalar = 0,
        origin: Point | None = None,
    ) -> None:  # fmt: skip
        """A prismatic joint along an axis of ``by``'s frame: in the plane the force N_name across it, moment M_name.

        In space the forces are F_name, in ``by``'s frame, and every moment; friction is one of the plane: Coulomb's,
        ``friction`` |N|, acts against the sliding, which is that of ``at`` as it is seen from a
        point fixed in ``by``: from ``origin``, that of the world if ``by`` is the ground.
        """
        if self.spatial:
            if friction != 0:
                raise MechanismError(f"{name}: a slide in space has no friction here; state it as a force")
            self._joint(name, on, by, at, _across(along), range(3), by.frame)
            return
        normal = self.assembly.unknown(f"N_{name}", "N", f"normal force of {by} on {on} at {at.name}")
        moment = self.assembly.unknown(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}")
        way = unit(by.frame, along)
        force = normal * unit(by.frame, Z).cross(way)
        if friction != 0:
            sliding = self._sliding(name, by, at, way, origin)
            drag = friction * sp.Abs(normal) * switch(sliding, S.One, S.NegativeOne)
            force -= drag * way
            self.report(f"P_{name}", "W", f"power lost to friction at {at.name}", drag * sliding)
        self.assembly.act(name, on, by, at, force, moment * unit(by.frame, Z))

    def motor(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> Quantity:
        """What keeps the motion: the torque ``name``, about an axis of ``by``'s frame."""
        way = unit(by.frame, axis)
        torque = self.assembly.torque(name, on, by, at, way, f"torque of {by} on {on}, which keeps the motion")
        turning = self.motion.spin(on.frame).resolved(by.frame) - self.motion.spin(by.frame)
        self.report(f"P_{name}", "W", f"power of {name}", torque * turning.dot(way))
        return torque

    def spring(
        self, name: str, on: Body, by: Body, ends: tuple[Point, Point], stiffness: Scalar, length: Scalar,
        damping: Scalar = 0,
    ) -> Quantity:  # fmt: skip
        """A spring between a point of ``on`` and one of ``by``: it pulls by F_name where it is longer than ``length``.

        ``stiffness`` in N/m, ``length`` in m; ``damping``, of the rate of its length, in N s/m.
        """
        line = displacement(*ends, self.world)
        long = self.name_(f"l_{name}", "m", f"length of {name}", sp.sqrt(line.dot(line)))
        rate = line.dot(self.motion.derivative(line)) / long
        self.motion.rates[long] = rate
        pull = self.name_(f"F_{name}", "N", f"pull of {name}", stiffness * (long - length) + damping * rate)
        self.potentials.append(stiffness * (long - length) ** 2 / 2)
        self.force(name, on, ends[0], (pull / long) * line, by)
        return pull

    def force(self, name: str, on: Body, at: Point, force: Vec, by: Body | None = None) -> None:
        """A given force [N] on a body at a point, by another body or by the ground."""
        self.assembly.act(name, on, by or self.ground, at, force)

    def torque(self, name: str, on: Body, by: Body, torque: Expr, axis: Axis = Z) -> None:
        """A given torque [N m] of one body on another, about an axis of ``by``'s frame."""
        self.assembly.act(name, on, by, self.O, zero(by.frame), torque * unit(by.frame, axis))

    @property
    def _directions(self) -> range:
        return range(3 if self.spatial else 2)

    def _in_space(self, name: str) -> None:
        if not self.spatial:
            raise MechanismError(f"{name}: a joint of space; say `spatial=True` where the mechanism is begun")

    def _joint(
        self, name: str, on: Body, by: Body, at: Point, forces: Iterable[int], moments: Iterable[int],
        frame: Frame | None = None,
    ) -> None:  # fmt: skip
        """Forces by axes of the world or of a frame, moments by those of ``by``'s.

        Whatever is not by those of the world is told by these as well.
        """
        force, moment = [S.Zero] * 3, [S.Zero] * 3
        for i in forces:
            force[i] = self.assembly.unknown(
                f"F_{name}{AXES[i]}", "N", f"force of {by} on {on} at {at.name}, {AXES[i]}"
            )
        for i in moments:
            meaning = f"moment of {by} on {on} at {at.name}, {AXES[i]} of {by.frame}"
            moment[i] = self.assembly.unknown(f"M_{name}{AXES[i]}", "N m", meaning)
        forces_, moments_ = Vec(frame or self.world, triple(force)), Vec(by.frame, triple(moment))
        self.assembly.act(name, on, by, at, forces_, moments_)
        self._along_other_axes(f"F_{name}", "N", f"force of {by} on {on} at {at.name}", forces_)
        self._along_other_axes(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}", moments_)

    def _along_other_axes(self, name: str, unit_: str, meaning: str, action: Vec) -> None:
        """Note an action of a joint in space, or a force in the plane, whose components are not the world's."""
        turned = action.frame != self.world and any(component != 0 for component in action.components)
        if turned and (self.spatial or unit_ == "N"):
            self.turned[name] = (unit_, meaning, action)

    def _sliding(self, name: str, by: Body, at: Point, way: Vec, origin: Point | None) -> Quantity:
        """How fast a point slides along a way as it is seen from a body; friction turns round where it stops."""
        if origin is None and by != self.ground:
            raise MechanismError(f"{name}: name the point of {by} that the sliding is counted from, `origin`")
        place = displacement(origin or self.O, at, by.frame)
        speed = self.motion.relative_derivative(place, by.frame).dot(way)
        sliding = self.name_(f"v_{name}", "m/s", f"sliding at {at.name} on {by}", speed)
        self.events.append(Event(f"sliding of {name} turns", sliding, S.Zero, 0))
        return sliding


def _across(axis: Axis) -> tuple[int, ...]:
    """The axes across one."""
    return tuple(i for i in range(3) if not axis[i])
