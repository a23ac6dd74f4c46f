"""A mechanism that is driven along an angle at a constant speed: its motion, then the forces from the balances."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from ..blocks import STATES
from ..chain import Chain, ordered
from ..equations import Equation
from ..meshes import MESHES, Mesh, Packed, build_function
from ..model import ClosedForm, Lane, Let, LinearSolve, Step, let, needed, sorted_steps
from ..quantity import Quantity, Vector
from .frames import Frame, Z, displacement
from .lawful import LAW, lawful
from .places import places
from .statement import MechanismError, Statement, quantity

FOLLOWERS = "followers"


@dataclass(frozen=True)
class DrivenLane(Lane):
    """A lane along an angle whose speed changes at the rate ``acceleration``, one of its inputs."""

    acceleration: Quantity | None = None


def along(
    stated: Statement, angle: Quantity, speed: Quantity, acceleration: Quantity | None,
    reported: Sequence[str | Quantity] | None,
) -> tuple[Lane, tuple[ClosedForm, ...]]:  # fmt: skip
    """The lane with what is reported (everything, unless told), and the functions that close its loops.

    Raises MechanismError, LoopError, ChainError or DimensionError where it cannot be derived.
    """
    if stated.slips:
        raise MechanismError(
            f"{stated.name}: {', '.join(stated.slips)}: slips vanish in free motion only; along an angle state "
            "rolling as a gap, by `constrain`"
        )
    steps, reports = motion(stated), [*stated.reports, *stated.world_components()]
    if reported is None or any(str(asked).startswith(LAW) for asked in reported):
        reports += lawful(stated, [(angle, speed), *((c.value, c.rate) for c in stated.loops.coordinates)])
    outputs = stated.chosen(_known(stated, steps, reports, reported is None), reported)
    found = forces(stated)
    tested = [s for s in needed((*steps, *found), frozenset(outputs)) if isinstance(s, LinearSolve)]
    pivots = [s.pivot for s in tested if s.pivot not in stated.loops.pivots]
    counts = [s.symbol for s in found if isinstance(s, Let) and s.symbol.name.startswith(STATES)]
    told, data = Vector("outputs", (*outputs, *pivots, *counts)), stated.data(angle)
    needs = sorted_steps(needed((*steps, *found, *reports), frozenset(told)))
    lane = DrivenLane(
        angle, (data,), needs, told, tuple(stated.events), along=stated.loops.inputs, speed=speed,
        acceleration=acceleration,
    )  # fmt: skip
    inputs: tuple[Packed, ...] = (angle, data, *stated.loops.inputs)
    drawn = places(stated, inputs, _found(stated))
    cut = build_function(MESHES, (s for mesh in in_mesh(stated) for s in mesh.lets()), inputs, steps)
    followed = build_function(FOLLOWERS, rollers(stated, angle), inputs, steps)
    return lane, (*stated.loops.functions(angle, data, stated.named), *drawn, *cut, *followed)


def rollers(stated: Statement, angle: Quantity) -> Iterator[Let]:
    """Where the centres of rollers on plane cams are from the cams' axes, as if the cams turned by the angle itself."""
    for name, (cam, centre) in stated.rollers.items():
        if not stated.spatial:
            place = centre.resolved(Frame(f"{cam.name}, turned back", cam.frame, Z, -angle))
            for axis, component in zip("xy", place.components, strict=False):
                yield let(quantity(f"{name}_centre_{axis}", "m", f"centre of the roller at {name}, {axis}"), component)


def in_mesh(stated: Statement) -> Iterator[Mesh]:
    """The gears that mesh in a plane, with the pitch curves that their motion has."""
    for tag, (inner, outer, at) in stated.meshing.items():
        assert at.base is not None
        assert at.offset is not None
        line, place = at.offset.frame, displacement(stated.O, at.base, stated.world)
        way, radius = _direction(line), -at.offset[0]
        polar = way - _direction(inner.frame), way + sp.pi - _direction(outer.frame)
        rates = [stated.motion.rate(angle) for angle in polar]
        yield Mesh(
            tag, (inner.name, outer.name), way, (place[0], place[1]), polar, (-radius * rates[1] / rates[0], radius)
        )


def _direction(frame: Frame) -> Expr:
    """Angle of a frame that turns about z alone, from the world's."""
    return sp.Add(*(angle for _, angle in frame.turns()))


def _found(stated: Statement) -> tuple[Step, ...]:
    """What places follow from: the named steps, and the coordinates of loops as they were found."""
    return (*(let(c.value, c.given) for c in stated.loops.coordinates), *stated.named)


def motion(stated: Statement) -> tuple[Step, ...]:
    """Coordinates, loops, and the accelerations of all centroids, which get names."""
    loops = stated.loops.steps(stated.motion)
    stated.name_accelerations()
    return (*loops, *stated.defined)


def _known(stated: Statement, steps: Sequence[Step], reports: Sequence[Let], told: bool) -> list[Quantity]:
    """What can be reported; on its own only what has a meaning to a person is."""
    named = [s.symbol for s in (stated.named if told else steps) if isinstance(s, Let)]
    return [*stated.loops.all, *named, *stated.assembly.unknowns, *(report.symbol for report in reports)]


def forces(stated: Statement) -> tuple[Step, ...]:
    """The unknown actions from the balances; raises MechanismError where some are left that nothing can keep."""
    return solved(stated, stated.equations(), stated.unknowns).steps()


def solved(stated: Statement, equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> Chain:
    """The chain that gives unknown actions from balances; raises MechanismError where some of these are left."""
    chain = ordered(equations, unknowns, unknowns)
    if left := [e.number for e in equations if e.number not in chain.spent]:
        raise MechanismError(
            f"{stated.name}: {len(equations)} balances for {len(unknowns)} forces and torques, so a joint or a drive "
            f"is lacking: nothing is left to keep {'; '.join(left)}"
        )
    return chain
