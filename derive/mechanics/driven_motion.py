"""A mechanism that an angle drives: its motion, forces, conservation laws, and two equal sides half
a cycle apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy import Expr, S

from ..chain import STATES, BlockError, Chain, ChainError, ordered
from ..equations import Definition, Equation, derived_equation
from ..model import (
    ELEMENTS,
    MESHES,
    PLACES,
    ClosedForm,
    Input,
    Lane,
    Let,
    LinearSolve,
    Mesh,
    Packed,
    Shared,
    Step,
    Twin,
    build_function,
    let,
    list_passing_events,
    needed,
    sorted_steps,
)
from ..quantity import Quantity, Vector
from .bodies import (
    AXES,
    Body,
    angular_momentum_residuals,
    momentum_residuals,
    sliding_velocity,
    total_power,
    virtual_works,
)
from .frames import Frame, Vec, Z, displacement
from .free_bodies import StatedLoad, build_load_function
from .statement import MechanismError, Statement, list_places, quantity

LAW = "law_"
"""Beginning of the names of laws."""
VANISHES = ", which vanishes"
WORK = {"rad": "N m", "m": "N", "1": "N m"}
"""Unit of the virtual work on a coordinate, by the coordinate's."""


def build_law_residuals(
    stated: Statement, coordinates: Sequence[tuple[Quantity, Quantity]]
) -> list[Let]:
    """Power, momentum, angular momentum, and virtual work on each of the coordinates, which come
    with their rates.
    """
    parts = stated.assembly, stated.ground
    moving = stated.told_in({rate for _, rate in coordinates})
    residuals = [
        _law("power", "W", "power of all forces and of inertia", total_power(*parts, stated.anchor))
    ]
    momentum, angular = momentum_residuals(*parts), angular_momentum_residuals(*parts, stated.O)
    residuals += [
        _law(f"force_{a}", "N", f"rate of momentum less outer forces, {a}", momentum[a])
        for a in stated.axes
    ]
    moment_axes = AXES if stated.spatial else AXES[2:]
    residuals += [
        _law(f"moment_{a}", "N m", f"rate of angular momentum less outer moments, {a}", angular[a])
        for a in moment_axes
    ]
    for tag, (inner, outer, at) in stated.rolling.items():
        slip = sliding_velocity(stated.motion, (inner, outer), stated.ground, stated.anchor, at)
        for axis, component in zip(stated.axes, slip.components, strict=False):
            residuals.append(
                _law(
                    f"roll_{tag}{axis}",
                    "m/s",
                    f"sliding of the pitch curves at {tag}, {axis}",
                    component,
                )
            )
    rates = [rate for _, rate in coordinates]
    works = virtual_works(*parts, stated.anchor, rates, lambda expr: expr.xreplace(moving))
    for (value, _), work in zip(coordinates, works, strict=True):
        residuals.append(
            _law(f"work_{value}", WORK[value.unit], f"virtual work where {value} alone moves", work)
        )
    return residuals


def _law(name: str, unit: str, meaning: str, vanishes: Expr) -> Let:
    return let(quantity(f"{LAW}{name}", unit, f"{meaning}{VANISHES}"), vanishes)


FOLLOWERS = "followers"


@dataclass(frozen=True)
class DrivenLane(Lane):
    """A lane along an angle whose speed changes at the rate ``acceleration``, one of its inputs."""

    acceleration: Quantity | None = None


def derive_driven_motion(
    stated: Statement,
    angle: Quantity,
    speed: Quantity,
    acceleration: Quantity | None,
    reported: Sequence[str | Quantity] | None,
) -> tuple[Lane, tuple[ClosedForm, ...], list[StatedLoad]]:
    """The lane with what is reported (everything, unless told), the functions that close its loops
    and those of drawings, and the loads of which one of these is the function.

    Raises MechanismError, LoopError, ChainError or DimensionError where it cannot be derived.
    """
    if stated.slips:
        raise MechanismError(
            f"{stated.name}: {', '.join(stated.slips)}: slips vanish in free motion only; along "
            f"an angle state "
            "rolling as a gap, by `constrain`"
        )
    steps, reports = motion_steps(stated), [*stated.reports, *stated.world_components()]
    if reported is None or any(str(name).startswith(LAW) for name in reported):
        reports += build_law_residuals(
            stated, [(angle, speed), *((c.value, c.rate) for c in stated.loops.coordinates)]
        )
    if reported is None:
        supports = [
            force for forces in stated.support_forces().values() for force in forces.values()
        ]
        reports += [force for force in supports if force.symbol != force.expr]
    outputs = stated.chosen(_reportable(stated, steps, reports, reported is None), reported)
    forces = solve_forces(stated, speed)
    tested = [
        s for s in needed((*steps, *forces), frozenset(outputs)) if isinstance(s, LinearSolve)
    ]
    pivots = [s.pivot for s in tested if s.pivot not in stated.loops.pivots]
    counts = [s.symbol for s in forces if isinstance(s, Let) and s.symbol.name.startswith(STATES)]
    results, data = Vector("outputs", (*outputs, *pivots, *counts)), stated.data(angle)
    needs = sorted_steps(needed((*steps, *forces, *reports), frozenset(results)))
    events = list_passing_events(
        needs, stated.events, frozenset({angle}.union(*stated.loops.inputs))
    )
    lane = DrivenLane(
        angle,
        (data,),
        needs,
        results,
        events,
        along=stated.loops.inputs,
        speed=speed,
        acceleration=acceleration,
    )
    inputs: tuple[Packed, ...] = (angle, data, *stated.loops.inputs)
    drawing_functions = build_function(
        PLACES,
        list_places(stated, lambda point: displacement(stated.O, point, stated.world)),
        inputs,
        _point_sources(stated),
    )
    element_functions = build_function(
        ELEMENTS,
        (s for name, e in stated.elements.items() for s in e.list_components(name, stated.axes)),
        inputs,
        (*_point_sources(stated), *stated.loops.rate_steps),
    )
    mesh_functions = build_function(
        MESHES, (s for mesh in find_meshes(stated) for s in mesh.lets()), inputs, steps
    )
    roller_functions = build_function(FOLLOWERS, roller_centres(stated, angle), inputs, steps)
    load_functions, loads = build_load_function(stated, (angle, *data, *outputs), stated.axes)
    if any(set(function.inputs[0]) - {angle, *data, *outputs} for function in load_functions):
        load_functions, loads = (), []
    functions = (
        *stated.loops.functions(angle, data, stated.named),
        *drawing_functions,
        *element_functions,
        *mesh_functions,
        *roller_functions,
        *load_functions,
    )
    return lane, functions, loads


def roller_centres(stated: Statement, angle: Quantity) -> Iterator[Let]:
    """Yield the rollers' centres on plane cams, seen from the cams' axes as if the cams turned by
    the angle.

    Where a cam turns otherwise, that frame is not at rest, so that the slope of the centre is not
    what the follower does: its guide sees the centre move, along the guide's own axes, of which x
    is given in that frame.
    """
    if stated.spatial:
        return
    for name, (follower, cam, centre) in stated.rollers.items():
        frame = Frame(f"{cam.name}, turned back", cam.frame, Z, -angle)
        guide = find_guide(stated, follower, cam)
        velocity = stated.motion.relative_derivative(centre, guide.frame)
        guide_axis = Vec(guide.frame, (S.One, S.Zero, S.Zero))
        for key, unit, meaning, vector in (
            ("centre", "m", "centre of the roller", centre.resolved(frame)),
            (
                "way",
                "m/s",
                "velocity of the centre of the roller against its guide",
                velocity.resolved(guide.frame),
            ),
            ("guide", "1", "axis x of what guides the roller", guide_axis.resolved(frame)),
        ):
            for axis, component in zip("xy", vector.components, strict=False):
                yield let(
                    quantity(f"{name}_{key}_{axis}", unit, f"{meaning} at {name}, {axis}"),
                    component,
                )


def find_guide(stated: Statement, follower: Body, cam: Body) -> Body:
    """Return the body whose joints hold both a follower and its cam, the ground if there are none
    or several.
    """

    def list_partners(body: Body) -> set[Body]:
        unknowns = frozenset(stated.assembly.unknowns)
        joints = [
            action
            for action in stated.assembly.actions
            if body in (action.on, action.by)
            and action.needs & unknowns
            and any(action.force.components)
        ]
        return {partner for joint in joints for partner in (joint.on, joint.by)}

    common = (list_partners(follower) & list_partners(cam)) - {follower, cam}
    return common.pop() if len(common) == 1 else stated.ground


def find_meshes(stated: Statement) -> Iterator[Mesh]:
    """The gears that mesh in a plane, with the pitch curves that their motion has."""
    for tag, (inner, outer, at) in stated.meshing.items():
        assert at.base is not None
        assert at.offset is not None
        line, centre = at.offset.frame, displacement(stated.O, at.base, stated.world)
        direction, radius = _direction(line), -at.offset[0]
        polar = direction - _direction(inner.frame), direction + sp.pi - _direction(outer.frame)
        rates = [stated.motion.rate(angle) for angle in polar]
        yield Mesh(
            tag,
            (inner.name, outer.name),
            direction,
            (centre[0], centre[1]),
            polar,
            (-radius * rates[1] / rates[0], radius),
        )


def _direction(frame: Frame) -> Expr:
    """Angle of a frame that turns about z alone, from the world's."""
    return sp.Add(*(angle for _, angle in frame.turns()))


def _point_sources(stated: Statement) -> tuple[Step, ...]:
    """Return the steps from which points follow: named steps, and the values of the loops'
    coordinates.
    """
    return (*(let(c.value, c.given) for c in stated.loops.coordinates), *stated.named)


def motion_steps(stated: Statement) -> tuple[Step, ...]:
    """Coordinates, loops, and the accelerations of all centroids, which get names."""
    loops = stated.loops.steps(stated.motion)
    stated.name_accelerations()
    return (*loops, *stated.defined)


def _reportable(
    stated: Statement, steps: Sequence[Step], reports: Sequence[Let], told: bool
) -> list[Quantity]:
    """Return the quantities that can be reported; without ``told``, only those with a meaning to
    the user.
    """
    named = [s.symbol for s in (stated.named if told else steps) if isinstance(s, Let)]
    return [
        *stated.loops.all,
        *named,
        *stated.assembly.unknowns,
        *(report.symbol for report in reports),
    ]


def solve_forces(stated: Statement, rate: Quantity | None = None) -> tuple[Step, ...]:
    """The unknown actions from the balances; raises MechanismError where some are left that nothing
    can keep.

    Where the side on which teeth bear leaves a set of balances that is not linear, the virtual work
    of what does work gives the force of the drive first, whose speed is ``rate``; one balance then
    follows from the others, and remains as a law that vanishes.
    """
    equations = stated.equations()
    try:
        return solve_balances(stated, equations, stated.unknowns).steps()
    except BlockError:
        if rate is None or stated.loops.coordinates:
            raise
        chain = ordered(
            (_virtual_work_balance(stated, rate), *equations), stated.unknowns, stated.unknowns
        )
        return chain.steps()


def _virtual_work_balance(stated: Statement, rate: Quantity) -> Equation:
    """Return the virtual work of all but ideal joints and contacts, where the drive alone moves
    (d'Alembert).
    """
    moving = stated.told_in({rate})
    working = [action for action in stated.assembly.actions if not action.workless]
    (work,) = virtual_works(
        stated.assembly,
        stated.ground,
        stated.anchor,
        [rate],
        lambda expr: expr.xreplace(moving),
        working,
    )
    return Equation(
        "virtual work",
        work,
        "derived: virtual work of loads and inertia",
        Definition("virtual work"),
    )


def solve_balances(
    stated: Statement, equations: Sequence[Equation], unknowns: Sequence[Quantity]
) -> Chain:
    """The chain that gives unknown actions from balances; raises MechanismError where some of these
    are left.
    """
    try:
        chain = ordered(equations, unknowns, unknowns)
    except ChainError:
        _refuse_free_spins(stated)
        raise
    if left := [e.number for e in equations if e.number not in chain.spent]:
        _refuse_free_spins(stated)
        raise MechanismError(
            f"{stated.name}: {len(equations)} balances for {len(unknowns)} forces and torques, so "
            f"a joint or a drive "
            f"is lacking: nothing is left to keep {'; '.join(left)}"
        )
    return chain


def _refuse_free_spins(stated: Statement) -> None:
    """Raise MechanismError for a body in space that only two forces at points hold: it spins about
    their line.
    """
    bodies = (body for body in stated.assembly.bodies if body != stated.ground)
    for body in bodies if stated.spatial else ():
        holding = [
            a for a in stated.assembly.actions if a.sign(body) and a.needs & set(stated.unknowns)
        ]
        if len(holding) == 2 and not any(any(a.moment.components) for a in holding):
            first, second = (action.at.name for action in holding)
            raise MechanismError(
                f"{stated.name}: {body} spins freely about the line from {first} to {second}: "
                f"make one of its ball "
                "joints a universal one, or state a light rod by `constrain` and `contact`"
            )


@dataclass(frozen=True)
class Sides:
    """The results, in SI, of one of two equal sides and of both; ``twin`` names a quantity of the
    other side.
    """

    twin: Twin
    reported: tuple[Quantity, ...]
    totals: tuple[Quantity, ...]


@dataclass(frozen=True)
class Other:
    """Turns an expression in quantities of one side into the same in those of the other, half a
    turn behind.
    """

    angle: Quantity
    twin: Twin
    symbols: frozenset[Quantity]

    def __call__(self, expr: Expr) -> Expr:
        ours = sorted(expr.free_symbols & self.symbols, key=str)
        return expr.xreplace({s: self.twin(s) for s in ours} | {self.angle: self.angle - sp.pi})


def side_quantities(stated: Statement) -> frozenset[Quantity]:
    """Quantities of each side: its motion, and what acts in it."""
    return frozenset(s for step in stated.steps for s in step.defines) | set(stated.unknowns)


def shared_balances(stated: Statement, other: Other) -> list[Equation]:
    """Balances of the bodies that both sides share, with the actions of one side and the same of
    the other.
    """
    of_side = [action for action in stated.assembly.actions if action not in stated.common]
    equations = []
    for body in stated.shared:
        pin = stated.pin_of(body)
        loads = stated.assembly.loads(body, pin, of_side)
        balances = stated.assembly.balances(body, pin)
        equations += [
            derived_equation(e.claims, e.residual + other(load))
            for e, load in zip(balances, loads, strict=True)
        ]
    return equations


def derive_twin_lane(
    stated: Statement,
    sides: Sides,
    inputs: Sequence[Input],
    forces: Sequence[Step] | None,
    frame: Sequence[Let] | None,
) -> Lane:
    """The lane of one side, and what both add up to; see `Mechanism.twin_lane`."""
    if stated.angle is None:
        raise MechanismError(
            f"{stated.name}: equal sides follow each other along an angle, and none is given"
        )
    side = (*motion_steps(stated), *(solve_forces(stated) if forces is None else forces))
    if frame is None:
        other = Other(stated.angle, sides.twin, side_quantities(stated))
        both = [unknown for unknown in stated.assembly.unknowns if unknown not in stated.unknowns]
        frame = solve_balances(stated, shared_balances(stated, other), both).lets()
    sums = needed((*frame, *stated.reports), frozenset(sides.totals))
    summed = frozenset().union(*(step.needs for step in sums))
    passed = [s for step in side for s in step.defines if s in summed or sides.twin(s) in summed]
    side_outputs = Vector("side", tuple(dict.fromkeys((*sides.reported, *passed))))
    needed_symbols = frozenset(side_outputs).union(
        *(event.argument.free_symbols for event in stated.events)
    )
    totals = Shared(sides.twin, sums, Vector("totals", sides.totals))
    steps = needed(side, needed_symbols)
    events = list_passing_events(steps, stated.events, frozenset({stated.angle}))
    return Lane(stated.angle, tuple(inputs), steps, side_outputs, events, totals)
