"""Laws that any mechanism obeys as a whole, from its actions and its motion alone; each residual vanishes.

They are found on another way than the forces: the power of every action at the speed of the very points it acts on,
the momentum of all bodies together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import sympy as sp
from sympy import Expr, S

from .bodies import AXES, Action, Assembly, Body
from .frames import Frame, Motion, Point, Vec, displacement, zero

Anchor = Callable[[Body], Point]
"""A point that is fixed in a body."""


def power(assembly: Assembly, ground: Body, anchor: Anchor) -> Expr:
    """Power of actions, weights and inertia of all bodies [W]."""
    world, motion = ground.frame, assembly.motion

    def of_action(action: Action) -> Expr:
        slip = sliding(motion, (action.on, action.by), ground, anchor, action.at)
        turn = motion.spin(action.on.frame).resolved(world) - motion.spin(action.by.frame).resolved(world)
        return action.force.resolved(world).dot(slip) + action.moment.resolved(world).dot(turn)

    terms = [of_action(action) for action in assembly.actions]
    for body in assembly.bodies:
        for part in body.parts:
            fall = assembly.gravity - motion.acceleration(part.centroid, world)
            terms.append(part.mass * fall.dot(velocity(motion, part.centroid, world)))
            rate = motion.derivative(part.momentum(motion.spin(body.frame)))
            terms.append(-rate.dot(motion.spin(body.frame)))
    return sp.Add(*terms)


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
