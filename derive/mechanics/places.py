"""Where the joints and centroids of every body are, for those who draw a mechanism."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..meshes import PLACES, Packed, build_function
from ..model import ClosedForm, Let, Step, let
from ..quantity import word
from .bodies import Body
from .frames import Point, displacement
from .statement import Statement, quantity


def places(stated: Statement, inputs: Sequence[Packed], before: Sequence[Step]) -> tuple[ClosedForm, ...]:
    """``x_BODY__POINT`` and its like [m] for each body and each of its points, from what a lane takes.

    ``before`` are the steps that places may need.
    """
    found = (
        step
        for body in stated.assembly.bodies
        for point in _points(stated, body)
        for step in _place(stated, body, point)
    )
    return build_function(PLACES, found, inputs, before)


def _points(stated: Statement, body: Body) -> Iterator[Point]:
    """Where forces act on a body, and its centroids; each once."""
    acting = [action.at for action in stated.assembly.actions if action.sign(body) and any(action.force.components)]
    yield from dict.fromkeys([*acting, *(part.centroid for part in body.parts)])


def _place(stated: Statement, body: Body, point: Point) -> list[Let]:
    at = displacement(stated.O, point, stated.world)
    name = f"{word(body.name)}__{word(point.name)}"
    return [
        let(quantity(f"{axis}_{name}", "m", f"{point.name} of {body}, {axis}"), component)
        for axis, component in zip(stated.axes, at.components, strict=False)
    ]
