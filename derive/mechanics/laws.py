"""Laws that any mechanism obeys as a whole, from its actions and its motion alone; each residual vanishes.

They are found on another way than the forces: the power of every action at the speed of the very points it acts on, its
virtual work where one coordinate alone moves, the momentum and angular momentum of all bodies together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import sympy as sp
from sympy import Expr, S

from ..quantity import Quantity
from ..slopes import slope
from .bodies import AXES, Action, Assembly, Body
from .frames import Frame, Motion, Point, Triple, Vec, displacement, zero

Anchor = Callable[[Body], Point]
"""A point that is fixed in a body."""


def loads(assembly: Assembly, ground: Body, anchor: Anchor) -> list[tuple[Vec, Vec]]:
    """Forces and moments of actions, weights and inertia, each with the velocity that it works on."""
    motion = assembly.motion
    acting = [pair for action in assembly.actions for pair in of_action(motion, action, ground, anchor)]
    return acting + [pair for body in assembly.bodies for pair in of_body(assembly, body, ground)]


def of_action(motion: Motion, action: Action, ground: Body, anchor: Anchor) -> list[tuple[Vec, Vec]]:
    """Force and moment of an action, with how its bodies slip and turn against each other there."""
    world = ground.frame
    slip = sliding(motion, (action.on, action.by), ground, anchor, action.at)
    turn = motion.spin(action.on.frame).resolved(world) - motion.spin(action.by.frame).resolved(world)
    return [(action.force.resolved(world), slip), (action.moment.resolved(world), turn)]


def of_body(assembly: Assembly, body: Body, ground: Body) -> list[tuple[Vec, Vec]]:
    """Weight and inertia of a body's parts, with how these move."""
    motion, world, found = assembly.motion, ground.frame, []
    for part in body.parts:
        spin = motion.spin(body.frame)
        fall = assembly.gravity - motion.acceleration(part.centroid, world)
        found.append((part.mass * fall, velocity(motion, part.centroid, world)))
        found.append((-motion.derivative(part.momentum(spin)), spin))
    return found


def power(assembly: Assembly, ground: Body, anchor: Anchor) -> Expr:
    """Power of actions, weights and inertia of all bodies [W]."""
    return sp.Add(*(load.dot(speed) for load, speed in loads(assembly, ground, anchor)))


def virtual_work(
    assembly: Assembly, ground: Body, anchor: Anchor, rate: Quantity, plain: Callable[[Expr], Expr]
) -> Expr:
    """Virtual work of the same while one coordinate alone moves: joints that this opens do work, no other does.

    ``plain`` tells speeds in the rates of the coordinates, of which ``rate`` is one.
    """
    pairs = loads(assembly, ground, anchor)
    ways = ((load, Vec(v.frame, _triple(slope(plain(c), rate) for c in v.components))) for load, v in pairs)
    return sp.Add(*(load.dot(way) for load, way in ways))


def momentum(assembly: Assembly, ground: Body) -> dict[str, Expr]:
    """Forces of the ground and weights less the rate of momentum of all bodies, by axes of the world [N]."""
    world = ground.frame
    total = zero(world)
    for action in assembly.actions:
        if ground in (action.on, action.by):
            total = total - action.sign(ground) * action.force.resolved(world)
    for body in assembly.bodies:
        for part in body.parts:
            total = total + part.mass * (assembly.gravity - assembly.motion.acceleration(part.centroid, world))
    return dict(zip(AXES, total.components, strict=True))


def kinetic(motion: Motion, bodies: Iterable[Body], world: Frame) -> Expr:
    """Kinetic energy of bodies [J]."""
    total = S.Zero
    for body in bodies:
        for part in body.parts:
            speed, spin = velocity(motion, part.centroid, world), motion.spin(body.frame)
            total += part.mass * speed.dot(speed) / 2 + part.momentum(spin).dot(spin) / 2
    return total


def potential(assembly: Assembly, bodies: Iterable[Body], origin: Point, world: Frame) -> Expr:
    """Potential energy of the weights of bodies [J]."""
    parts = [part for body in bodies for part in body.parts]
    places = [assembly.motion.arm(origin, part.centroid, world) for part in parts]
    return sp.Add(*(-part.mass * assembly.gravity.dot(place) for part, place in zip(parts, places, strict=True)))


def angular_momentum(assembly: Assembly, ground: Body, about: Point) -> dict[str, Expr]:
    """The same of moments about a point at rest [N m]."""
    world, motion = ground.frame, assembly.motion
    total = zero(world)
    for action in assembly.actions:
        if ground in (action.on, action.by):
            arm = displacement(about, action.at, world)
            moment = arm.cross(action.force.resolved(world)) + action.moment.resolved(world)
            total = total - action.sign(ground) * moment
    for body in assembly.bodies:
        for part in body.parts:
            fall = part.mass * (assembly.gravity - motion.acceleration(part.centroid, world))
            rate = motion.derivative(part.momentum(motion.spin(body.frame))).resolved(world)
            total = total + displacement(about, part.centroid, world).cross(fall) - rate
    return dict(zip(AXES, total.components, strict=True))


def _triple(components: Iterable[Expr]) -> Triple:
    x, y, z = components
    return x, y, z


def velocity(motion: Motion, point: Point, world: Frame) -> Vec:
    """A point's velocity, in the world."""
    origin = next(iter(point.chain()))
    return motion.derivative(displacement(origin, point, world))


def material(motion: Motion, body: Body, ground: Body, anchor: Anchor, at: Point) -> Vec:
    """Velocity of a body's own matter at a point, in the world."""
    world = ground.frame
    if body == ground:
        return zero(world)
    arm = displacement(anchor(body), at, world)
    return velocity(motion, anchor(body), world) + motion.spin(body.frame).resolved(world).cross(arm)


def sliding(motion: Motion, bodies: tuple[Body, Body], ground: Body, anchor: Anchor, at: Point) -> Vec:
    """Velocity of one body's matter over that of another at a point, in the world."""
    one, other = (material(motion, body, ground, anchor, at) for body in bodies)
    return one - other
