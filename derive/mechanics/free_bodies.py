"""Loads on the bodies of a mechanism, cut free: actions at their points, weights, and inertia
forces (d'Alembert), which together are in equilibrium.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from sympy import Expr, Integer, Symbol

from ..model import ClosedForm, Let, build_function, let, needed
from ..quantity import Quantity, Vector
from .bodies import AXES, Action, Body
from .frames import Point, Vec, displacement, zero
from .statement import Statement, quantity

LOADS = "loads"
"""The function of the loads on all bodies."""
TEETH = "F_"
"""Beginning of the names of teeth's actions, before the tag of their mesh."""
PARTS = {"F": "N", "M": "N m"}
"""Units of the components of forces and of moments."""


@dataclass(frozen=True)
class StatedLoad:
    """A force at a point and a moment on a body, along the axes of the world; ``by`` is empty for
    weight and inertia.

    On a body that equal sides share, a load that acts ``twice`` has its like half a turn behind.
    """

    name: str
    body: str
    by: str
    point: str
    place: Vec
    force: Vec
    moment: Vec
    twice: bool = False

    def list_components(self, number: int, axes: Sequence[str]) -> Iterator[Let]:
        """Yield ``load_NUMBER_x`` and its like [m], ``load_NUMBER_Fx`` [N], ``load_NUMBER_Mz``
        [N m]; forces and moments only where they are not zero.
        """
        words = f"{self.name} on {self.body} at {self.point}"
        for axis, component in zip(AXES, self.place.components, strict=True):
            if axis in axes:
                yield self._let(number, axis, "m", f"point of {words}, {axis}", component)
        for part, vector in (("F", self.force), ("M", self.moment)):
            for axis, component in zip(AXES, vector.components, strict=True):
                if component != 0:
                    meaning = f"{'force' if part == 'F' else 'moment'} of {words}, {axis}"
                    yield self._let(number, f"{part}{axis}", PARTS[part], meaning, component)

    def _let(self, number: int, end: str, unit: str, meaning: str, value: Expr) -> Let:
        return let(quantity(f"load_{number}_{end}", unit, meaning), value)

    def describe(self) -> dict[str, str | bool]:
        """Return the texts of the load, for the sidecar."""
        texts: dict[str, str | bool] = {
            "body": self.body,
            "name": self.name,
            "by": self.by,
            "point": self.point,
        }
        return texts | ({"twice": True} if self.twice else {})


def list_loads(stated: Statement) -> list[StatedLoad]:
    """Return the loads on all bodies but the ground, in the order of the bodies."""
    bodies = [body for body in stated.assembly.bodies if body != stated.ground]
    return [load for body in bodies for load in _list_body_loads(stated, body)]


def _list_body_loads(stated: Statement, body: Body) -> Iterator[StatedLoad]:
    world, shared = stated.world, body in stated.shared
    for action in stated.assembly.actions:
        if sign := action.sign(body):
            at, force, moment = _find_wrench(stated, action)
            yield StatedLoad(
                action.name,
                body.name,
                (action.by if action.on == body else action.on).name,
                at.name,
                _locate(stated, at),
                Integer(sign) * force,
                Integer(sign) * moment,
                shared and action not in stated.common,
            )
    for number, part in enumerate(body.parts, 1):
        suffix = f" {number}" if len(body.parts) > 1 else ""
        place, name = _locate(stated, part.centroid), part.centroid.name
        gravity = stated.assembly.gravity.resolved(world)
        weight, still = part.mass * gravity, zero(world)
        yield StatedLoad(f"weight{suffix}", body.name, "", name, place, weight, still)
        inertia = -part.mass * stated.motion.acceleration(part.centroid, world)
        rate = stated.motion.momentum_rate(part.tensor, body.frame).resolved(world)
        moment = -rate
        yield StatedLoad(f"inertia{suffix}", body.name, "", name, place, inertia, moment)


def _find_wrench(stated: Statement, action: Action) -> tuple[Point, Vec, Vec]:
    """Return point, force and moment of an action; those of teeth act at their pitch point, where
    the moment about a shaft that the statement has vanishes.
    """
    force, moment = action.force.resolved(stated.world), action.moment.resolved(stated.world)
    tag = action.name.removeprefix(TEETH)
    if not action.name.startswith(TEETH) or tag not in stated.rolling:
        return action.at, force, moment
    *_, pitch = stated.rolling[tag]
    arm = _locate(stated, action.at) - _locate(stated, pitch)
    return pitch, force, moment + arm.cross(force)


def _locate(stated: Statement, point: Point) -> Vec:
    return displacement(stated.O, point, stated.world)


def build_load_function(
    stated: Statement, inputs: Sequence[Quantity], axes: Sequence[str]
) -> tuple[tuple[ClosedForm, ...], list[StatedLoad]]:
    """Return the function of the loads, and the loads, with places along ``axes``.

    It takes a packed ``state``: those of ``inputs`` that the loads depend on, then other quantities
    from which these follow.
    """
    loads = list_loads(stated)
    components = [
        step for number, load in enumerate(loads, 1) for step in load.list_components(number, axes)
    ]
    named = [step for step in stated.named if step.symbol not in inputs]
    steps = needed((*named, *components), frozenset(step.symbol for step in components))
    free = frozenset[Symbol]().union(*(step.needs for step in steps))
    free -= frozenset[Symbol]().union(*(step.defines for step in steps))
    further = sorted(free - set(inputs), key=str)
    state = Vector("state", (*(symbol for symbol in inputs if symbol in free), *further))
    functions = build_function(LOADS, components, (state,), named)
    return functions, loads if functions else []
