"""A mechanism that moves by itself: what its accelerations follow from, by the principle of virtual
power.

    inertia accelerations = forces + slopes^T multipliers,    slopes accelerations = bends

Every body and every given action is projected on the rates of the coordinates; joints do no virtual
work and stay out. Gaps of closed loops and slips of rolling bodies vanish. Source: W. Schiehlen,
"Multibody system dynamics: roots and perspectives", Multibody Syst. Dyn. 1 (1997) 149-188, section
3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp
from sympy import Expr, S

from ..equations import Balance, Equation, Kind
from ..functions import directional_derivative, partial_derivative
from ..model import (
    COMMON,
    ELEMENTS,
    PLACES,
    ClosedForm,
    Let,
    Step,
    let,
    list_kinks,
    list_passing_events,
    needed,
    sorted_steps,
)
from ..quantity import NONE, Quantity, Vector, dimension, of_unit
from .bodies import AXES, Action, Assembly, Body, kinetic_energy, potential_energy
from .carrying import (
    RandomPoses,
    count_rank,
    find_resistance,
    find_uncarried,
    find_unsupported,
    null_space,
)
from .frames import Motion, Point, Vec, multiply_cross, zero
from .motion_steps import MotionSteps, add_slopes
from .recursion import ArticulatedInertias, Loads, Tree
from .statement import MechanismError, Statement, check_unit, list_places, quantity

_OF = {"rad": "m", "m": "1", "1": "m"}
_FORCE = {"rad": "N m", "m": "N", "1": "N m"}
MOST_TOGETHER = 4
"""Coordinates that a reaction may act on at once where they move the same bodies: its formula grows
with each.
"""


def derive_free_motion(
    stated: Statement, time: Quantity, reported: Sequence[str | Quantity] | None
) -> tuple[tuple[ClosedForm, ...], tuple[str, ...]]:
    """The functions that an integrator needs, and what is reported of a state and its
    accelerations; then the names of given actions that depend on these.

    Raises MechanismError, ChainError or DimensionError where they cannot be derived.
    """
    if not stated.loops.coordinates:
        raise MechanismError(
            f"{stated.name}: it has neither an angle to move along nor a coordinate to move in"
        )
    motion = Free(stated, time)
    return motion.functions(reported), tuple(motion.find_added_inertia())


def symbolic_accelerations(stated: Statement, time: Quantity) -> tuple[Expr, ...]:
    """Return the accelerations of the coordinates.

    Raises MechanismError if loops or rolling constrain them.
    """
    if constraints := [*stated.loops.gaps, *stated.slips]:
        raise MechanismError(
            f"{stated.name}: accelerations in symbols are those without {', '.join(constraints)}"
        )
    return Free(stated, time).solved()


def project_on_rates(stated: Statement, time: Quantity) -> tuple[list[list[Expr]], list[Expr]]:
    """Return inertia (k, k) and forces (k,) of virtual power on the rates of the k coordinates.

    Joints, and whatever else guides bodies along their coordinates, do no work and stay out. Raises
    MechanismError for friction of a force that a joint would have to determine.
    """
    return Free(stated, time).project()


class CoordinateMotion(Motion):
    """Motion of many coordinates: rates of expressions in one pass."""

    def rate(self, expr: Expr) -> Expr:
        """Return the derivative of an expression in time. Raises as `Motion.rate`."""
        self._refuse_inputs(expr)
        return directional_derivative(expr, self.rates)


class Free:
    """A statement read as one of free motion."""

    def __init__(self, stated: Statement, time: Quantity) -> None:
        self.stated, self.motion, self.coordinates = stated, stated.motion, stated.loops.coordinates
        self.state = Vector(
            "state", (*(c.value for c in self.coordinates), *(c.rate for c in self.coordinates))
        )
        self.accelerations = Vector(
            "accelerations", tuple(c.acceleration for c in self.coordinates)
        )
        self.inputs: tuple[Vector | Quantity, ...] = (time, stated.data(time), self.state)
        assembly = stated.assembly
        rubbing = {
            e for a in assembly.actions for force in a.force.components for e in force.atoms(sp.Abs)
        }
        of_friction = [u for u in assembly.unknowns if sp.Abs(u) in rubbing]
        deciding = {
            test.lhs for law in assembly.laws for test in law.expr.atoms(sp.Ge) if test.rhs == 0
        }
        of_flanks = [u for u in assembly.unknowns if u in deciding]
        names = {
            u: quantity(f"size_{u}", u.unit, f"size of {u}") for u in (*of_friction, *of_flanks)
        }
        self._sizes = {sp.Abs(u): names[u] for u in of_friction}
        self._flanks = {u: names[u] for u in of_flanks}
        self._cache_ways: dict[tuple[str, Kind, Point], dict[int, Vec]] = {}
        sizes = Vector("sizes", tuple(names.values()))
        self.loaded = (*self.inputs, sizes) if self._sizes else self.inputs
        self.balanced = (*self.inputs, sizes) if names else self.inputs
        self._moving = (
            stated.told_in({q for c in self.coordinates for q in (c.rate, c.acceleration)})
            | self._sizes
        )

    def functions(self, reported: Sequence[str | Quantity] | None) -> tuple[ClosedForm, ...]:
        """Build the functions in closed form that integrate the motion, and those of what is
        ``reported``.
        """
        self._refuse()
        constrained_speeds = self._constrained_speeds()
        starts = self.stated.start_conditions
        rows = {
            "events": list(self._events()),
            "impacts": list(self._impacts()),
            "gaps": [self._let(name, "m", gap) for name, gap in self.stated.loops.gaps.items()],
            "start_gaps": [
                self._let(f"start_{name}", "m", gap) for name, (gap, _) in starts.items()
            ],
            "start_speeds": [
                self._let(f"start_speed_{name}", "m/s", speed)
                for name, (_, speed) in starts.items()
            ],
            "speeds": [
                self._let(f"speed_{name}", "m/s", speed)
                for name, speed in constrained_speeds.items()
            ],
            "slopes": [
                self._let(
                    f"slope_{name}_{c.value}", _OF[c.value.unit], partial_derivative(speed, c.rate)
                )
                for name, speed in constrained_speeds.items()
                for c in self.coordinates
            ],
            "bends": [
                self._let(
                    f"bend_{name}", "m/s2", -self._resting(self._plain(self.motion.rate(speed)))
                )
                for name, speed in constrained_speeds.items()
            ],
        }
        full = {name: [step for step in steps if step.expr != 0] for name, steps in rows.items()}
        forms = [self._form(name, self.inputs, steps) for name, steps in full.items() if steps]
        return (
            self._start(),
            *self._residuals(),
            *self._accelerations(),
            *forms,
            *self._outputs(reported),
            *self._drawing_functions(),
        )

    @cached_property
    def steps(self) -> MotionSteps:
        """The motion in named steps."""
        motion = self._write_steps(self._plain)
        motion.name_accelerations(self.stated.list_centroids())
        return motion

    def _write_steps(self, plain: Callable[[Expr], Expr]) -> MotionSteps:
        stated = self.stated
        taken = {
            *map(str, (*stated.given.values(), *self.state, *self.accelerations)),
            *map(str, (*stated.assembly.unknowns, *self._sizes.values(), *self._flanks.values())),
            *(str(step.symbol) for step in (*stated.named, *stated.reports)),
            *(str(symbol) for _, symbols in stated.list_centroids() for symbol in symbols),
        }
        frames = [body.frame for body in stated.assembly.bodies]
        return MotionSteps(self.motion, self.coordinates, plain, taken, frames)

    def _write_residuals(self) -> list[Expr]:
        return Loads(self.stated, self.steps, self._given_actions()).find_residuals()

    def _residuals(self) -> tuple[ClosedForm, ...]:
        """``residual_COORDINATE``: inertia times accelerations less forces."""
        pairs = zip(self.coordinates, self._write_residuals(), strict=True)
        lets = [
            let(
                quantity(f"residual_{c.value}", _FORCE[c.value.unit], f"residual of {c.value}"),
                residual,
                "residual: inertia times accelerations less forces",
            )
            for c, residual in pairs
        ]
        inputs = (*self.loaded, self.accelerations)
        return (self._form("residual", inputs, lets, self.steps),)

    def _accelerations(self) -> tuple[ClosedForm, ...]:
        """The accelerations, where articulated inertias give them: of a tree without constraints,
        whose loads do not depend on what is to be found.
        """
        if self._constrained_speeds() or self._sizes or self.find_added_inertia():
            return ()
        motion = self._write_steps(lambda expr: self._resting(self._plain(expr)))
        loads = Loads(self.stated, motion, self._given_actions())
        links = Tree(loads, len(self.coordinates)).links
        if links is None:
            return ()
        with suppress(MechanismError):  # where nothing resists a motion, its simulation says so
            ArticulatedInertias(loads, links, len(self.coordinates)).define_accelerations()
            outputs = Vector("accelerations_outputs", self.accelerations.quantities)
            steps = self._list_steps(motion, [], frozenset(outputs))
            return (ClosedForm("accelerations", self.inputs, steps, outputs),)
        return ()

    def find_added_inertia(self) -> list[str]:
        """Return the names of given actions that depend on accelerations."""
        accelerations = frozenset(self.accelerations)
        return [
            action.name
            for action in self._given_actions()
            if any(
                self._plain(component).free_symbols & accelerations
                for component in (*action.force.components, *action.moment.components)
            )
        ]

    def _drawing_functions(self) -> tuple[ClosedForm, ...]:
        stated = self.stated
        places = [
            replace(step, source="derived: places")
            for step in list_places(
                stated, lambda point: self.steps.arm(stated.O, point, stated.world)
            )
        ]
        elements = [
            replace(step, source="derived: drawing")
            for name, element in stated.elements.items()
            for step in element.list_components(name, stated.axes)
        ]
        return tuple(
            self._form(name, self.inputs, steps, self.steps, name)
            for name, steps in ((PLACES, places), (ELEMENTS, elements))
            if steps
        )

    def solved(self) -> tuple[Expr, ...]:
        """Accelerations of the coordinates, if nothing holds them."""
        inertia, forces = self.project()
        return tuple(sp.Matrix(inertia).LUsolve(sp.Matrix(forces)))

    def project(self) -> tuple[list[list[Expr]], list[Expr]]:
        """Inertia and forces on the coordinates' rates, without named steps."""
        if self._sizes:
            forces = ", ".join(str(size.args[0]) for size in self._sizes)
            raise MechanismError(
                f"{self.stated.name}: friction depends on the size of {forces}, which depends on "
                f"the accelerations; "
                "state the normal force of this friction as a value, or leave the friction out"
            )
        residuals = self._write_residuals()
        definitions: dict[sp.Symbol, Expr] = {}
        for step in self.steps.steps:
            definitions[step.symbol] = step.expr.xreplace(definitions)
        residuals = [residual.xreplace(definitions) for residual in residuals]
        inertia = [[partial_derivative(r, a) for a in self.accelerations] for r in residuals]
        return inertia, [-self._resting(residual) for residual in residuals]

    def _start(self) -> ClosedForm:
        start = self.stated.loops.start | self.stated.start
        steps = _note_once([let(q, start.get(q, S.Zero), "start") for q in self.state])
        outputs = Vector("start_state", self.state.quantities)
        return ClosedForm("start", (self.stated.data(),), tuple(steps), outputs)

    def _outputs(self, reported: Sequence[str | Quantity] | None) -> tuple[ClosedForm, ...]:
        """Build the functions that report a state, its accelerations and, if needed, the joints'
        actions.
        """
        stated = self.stated
        defined = {step.symbol for step in self.steps.steps}
        accelerations = [q for _, names in stated.list_centroids() for q in names if q in defined]
        energies = self._energies()
        reports = [*stated.reports, *stated.world_components(), *energies]
        unknowns, reactions = stated.assembly.unknowns, self._reactions
        candidates = list(reactions.values()) if unknowns or reported is not None else []
        reportable = [
            *(n.symbol for n in stated.named),
            *accelerations,
            *unknowns,
            *candidates,
            *(r.symbol for r in reports),
        ]
        if reported is not None:
            reported = list(
                dict.fromkeys([*map(str, reported), *(energy.symbol.name for energy in energies)])
            )
        requested = stated.chosen(reportable, reported)
        steps = self._list_steps(self.steps, reports, frozenset(requested))
        taken = frozenset(requested).union(*(step.needs for step in steps))
        inputs = (*self.inputs, self.accelerations)
        if not (taken & {*unknowns, *candidates} or self._sizes):
            return (ClosedForm("lane", inputs, steps, Vector("outputs", requested)),)
        rows = [self._row(equation) for equation in stated.equations(self._assembly)]
        columns = self._carry(rows)
        used = [q for q in requested if q not in candidates or q in columns]
        if reported is not None and len(used) < len(requested):
            carried = ", ".join(str(q) for q in requested if q not in used)
            raise MechanismError(
                f"{stated.name}: {carried}: joints carry this constraint; ask for their forces "
                f"instead"
            )
        actions = Vector("actions", (*unknowns, *columns))
        balances = [step for step in _steps_of_balances(rows, columns) if step.expr != 0]
        return (
            self._form("balances", (*self.balanced, self.accelerations), balances, self.steps),
            ClosedForm("lane", (*inputs, actions), steps, Vector("outputs", tuple(used))),
        )

    def _row(self, equation: Equation) -> BalanceRow:
        """Return a balance, or a contact's law, with its slopes in the actions."""
        residual = equation.residual.xreplace(self._sizes)
        if self._flanks and equation.defines is not None:
            residual = equation.defines - self._both_flanks(equation.defines - residual)
        unknowns = [u for u in self.stated.assembly.unknowns if u in residual.free_symbols]
        slopes = {u: partial_derivative(residual, u) for u in unknowns}
        return BalanceRow(equation, slopes, residual.xreplace(dict.fromkeys(unknowns, S.Zero)))

    def _both_flanks(self, law: Expr) -> Expr:
        """Return a law of teeth without cases: on each flank it is proportional to the force that
        decides on it.

        With the factors a and b of a force u and its size |u| it is a u + b |u|.
        """
        for earlier in reversed(self.stated.assembly.laws):
            if law.has(sp.Ge) and law != earlier.expr:
                law = law.xreplace({earlier.symbol: earlier.expr})
        for force, size in self._flanks.items():
            on, off = (
                law.xreplace({sp.Ge(force, 0): sp.sympify(bears)}) for bears in (True, False)
            )
            if on != off:
                law = (on + off) / 2 + ((on - off) / 2).xreplace({force: size})
        return law

    def _carry(self, rows: Sequence[BalanceRow]) -> dict[Quantity, list[Expr]]:
        """Return the reactions of constraints that no joint carries, with their slopes in the
        balances.

        Raises MechanismError if joints resist a motion that the constraints allow, or do not resist
        one that they forbid. Where no pose is found near the start, nothing is known, and the
        joints are taken as stated.
        """
        stated, speeds = self.stated, self._constrained_speeds()
        slopes = [
            [partial_derivative(speed, c.rate) for c in self.coordinates]
            for speed in speeds.values()
        ]
        rates = [*(c.rate for c in self.coordinates), *self.accelerations]
        parameters = [self.inputs[0], *rates, *self._sizes.values(), *self._flanks.values()]
        starts = stated.loops.start | stated.start
        poses = RandomPoses(
            stated.given,
            starts,
            [c.value for c in self.coordinates],
            parameters,
            stated.named,
            self.steps.steps,
        )
        motions = self._virtual_motions(rows)
        pose = poses.draw([self._plain(gap) for gap in stated.loops.gaps.values()], slopes)
        if pose is None:
            return {}
        unknowns = (*stated.assembly.unknowns, *self._flanks.values())
        action_slopes, jacobian = (
            pose.matrix([[row.by(u) for u in unknowns] for row in rows]),
            pose.matrix(slopes),
        )
        ways = pose.matrix(motions) @ null_space(jacobian)
        if resisting := find_resistance(action_slopes, [row.is_law for row in rows], ways):
            names = ", ".join(str(unknowns[i]).removeprefix("size_") for i in resisting)
            raise MechanismError(
                f"{stated.name}: {names}: the joint resists a motion that its coordinates allow: "
                f"state the constraint "
                "that it keeps (`close` for a pin between two chains, `constrain` for a toothing "
                "or a drive), or leave "
                "it out; teeth or followers with friction are compliant in free motion "
                "(`compliant_mesh`)"
            )
        action_slopes = action_slopes[:, : len(stated.assembly.unknowns)]
        if count_rank(action_slopes) == len(rows) - ways.shape[1]:
            return {}
        columns = {
            q: self._column(rows, self._reaction_loads(speeds[key]))
            for key, q in self._reactions.items()
        }
        poses.finish(pose)  # of steps that the columns need
        values = [pose.matrix([column])[0] for column in columns.values()]
        uncarried = [list(columns)[i] for i in find_uncarried(action_slopes, values)]
        action_slopes = np.column_stack(
            [action_slopes, *(values[list(columns).index(reaction)] for reaction in uncarried)]
        )
        bends = [-self._resting(self._plain(self.motion.rate(speed))) for speed in speeds.values()]
        pushed = poses.derive_in(list(self.accelerations), pose, [row.rest for row in rows])
        unsupported = find_unsupported(action_slopes, *pushed, jacobian, pose.matrix([bends])[0])
        if unsupported is not None:
            worst = rows[int(np.argmax(np.abs(unsupported)))].equation.number
            raise MechanismError(
                f"{stated.name}: no joint carries {worst}: state what holds it (a joint, `mesh` "
                f"or `couple` for a "
                "toothing, `contact` for a rope or a rolling body), or leave the forces of joints "
                "out by `reported`"
            )
        return {reaction: columns[reaction] for reaction in uncarried}

    @cached_property
    def _reactions(self) -> dict[str, Quantity]:
        """The reactions of gaps and slips that need no joint: such that their power is that of the
        constraint [W].
        """
        reactions = {}
        for constraint, name in self.stated.reactive.items():
            speed = self._constrained_speeds()[constraint]
            kind = {of_unit("m/s"): "N", of_unit("rad/s"): "N m"}.get(dimension(speed) or NONE, "1")
            reactions[constraint] = quantity(
                name, kind, f"reaction of the constraint {name.removeprefix('R_')}"
            )
        return reactions

    def _virtual_motions(self, rows: Sequence[BalanceRow]) -> list[list[Expr]]:
        """Return the slopes in the rates of what the load of each balance works on: its body's
        matter; none of laws.
        """
        stated, bodies = self.stated, {body.name: body for body in self.stated.assembly.bodies}
        motions = []
        for row in rows:
            slopes = [S.Zero] * len(self.coordinates)
            if isinstance(claim := row.equation.claims, Balance):
                pin = stated.pin_of(bodies[claim.body])
                for i, way in self._matter_ways(bodies[claim.body], claim.kind, pin.at).items():
                    slopes[i] = self.steps.resolve(way, pin.axes)[AXES.index(claim.axis)]
            motions.append(slopes)
        return motions

    def _matter_ways(self, body: Body, kind: Kind, at: Point) -> dict[int, Vec]:
        """Return slopes in the rates of a body's spin, or of its velocity at a point."""
        key = body.name, kind, at
        if key not in self._cache_ways:
            motion, spins = self.steps, self.steps.spin_ways(body.frame)
            anchor, ways = self.stated.anchor(body), spins
            if kind == "force":
                arm = motion.reach(anchor, at)
                swept = {i: multiply_cross(spin, arm) for i, spin in spins.items()}
                ways = add_slopes([motion.velocity_ways(anchor), swept])
            self._cache_ways[key] = {
                i: Vec(self.stated.world, way) for i, way in ways.items() if any(way)
            }
        return self._cache_ways[key]

    def _reaction_loads(self, speed: Expr) -> list[Action]:
        """Return forces and moments on bodies whose power at all rates is that of a unit force on
        ``speed``.

        Each coordinate is acted on by a load on a body that it moves with the fewest others, along
        the direction in which it does. There is none if a coordinate moves no body, or too many of
        them move the same ones.
        """
        pending = [i for i, c in enumerate(self.coordinates) if c.rate in speed.free_symbols]
        levers: dict[int, Lever] = {}
        while pending:
            if (place := pending.pop()) not in levers:
                lever = self._lever(place)
                if lever is None:
                    return []
                levers[place] = lever
                pending += [i for i in lever.ways if lever.slope(i) != 0]
        order = sorted(
            levers, key=lambda i: -len(levers[i].ways)
        )  # then only a few entries are above the diagonal
        if len(order) > MOST_TOGETHER:
            return []
        matrix = [[levers[j].slope(i) for j in order] for i in order]
        right = [partial_derivative(speed, self.coordinates[i].rate) for i in order]
        sizes = solve_in_order(matrix, right)
        return [
            levers[i].load(size, self.stated.earth) for i, size in zip(order, sizes, strict=True)
        ]

    def _lever(self, place: int) -> Lever | None:
        """Return what a coordinate moves with the fewest others: a turn of a body rather than a
        point of it.
        """
        stated, levers = self.stated, []
        for body in stated.assembly.bodies[1:]:
            at = next((part.centroid for part in body.parts), stated.O)
            kinds: tuple[Kind, ...] = ("moment", "force") if body.parts else ("moment",)
            for kind in kinds:
                ways = self._matter_ways(body, kind, at)
                levers += [Lever(body, kind, at, place, ways)] if place in ways else []
        turns = self.coordinates[place].value.unit != "m"
        return min(
            levers,
            key=lambda lever: (len(lever.ways), turns != (lever.kind == "moment")),
            default=None,
        )

    def _column(self, rows: Sequence[BalanceRow], loads: Sequence[Action]) -> list[Expr]:
        """Return what loads add to the balances, by their rows."""
        stated, bodies = self.stated, {action.on.name: action.on for action in loads}
        column = []
        for row in rows:
            claim = row.equation.claims
            if not isinstance(claim, Balance) or claim.body not in bodies:
                column.append(S.Zero)
                continue
            pin = stated.pin_of(bodies[claim.body])
            added = self._assembly.loads(bodies[claim.body], pin, loads)
            column.append(added[pin.asked.index((claim.kind, AXES.index(claim.axis)))])
        return column

    @cached_property
    def _assembly(self) -> Assembly:
        """The assembly with its motion in named steps."""
        return replace(self.stated.assembly, motion=self.steps)

    def _energies(self) -> tuple[Let, Let]:
        """Kinetic energy, and potential energy of weights and springs [J]."""
        stated, bodies = self.stated, self.stated.assembly.bodies
        moving = kinetic_energy(self.steps, bodies, stated.world)
        lifted = potential_energy(self._assembly, bodies, stated.origin, stated.world)
        stored = sp.Add(*stated.potentials) + lifted
        stored_name = quantity("potential", "J", "potential energy of weights and springs")
        return let(quantity("kinetic", "J", "kinetic energy"), moving), let(stored_name, stored)

    def _refuse(self) -> None:
        """Raises DimensionError for a given action of another unit, MechanismError for friction
        that jumps at rest.
        """
        for action in self._given_actions():
            for load, unit in ((action.force, "N"), (action.moment, "N m")):
                for component in load.components:
                    check_unit(action.name, component, unit)
        for action in self.stated.assembly.actions:
            if any(
                self._sizes.keys() & e.atoms(sp.Abs) and e.has(sp.Piecewise)
                for e in action.force.components
            ):
                raise MechanismError(
                    f"{self.stated.name}: {action.name} jumps where the sliding turns; in free "
                    f"motion it needs "
                    "`creep`, the speed below which it is smooth"
                )

    def _events(self) -> Iterator[Let]:
        """Yield a step for each event of a state; its value vanishes there."""
        stated, unavailable = self.stated, {*self.stated.assembly.unknowns, *self.accelerations}
        actions = [
            (a.name, (*a.force.components, *a.moment.components)) for a in stated.assembly.actions
        ]
        moving = frozenset({self.inputs[0], *self.state})
        steps = (*stated.named, *stated.reports)
        kinks = list_kinks(
            steps, moving, list_passing_events(steps, stated.events, moving), actions
        )
        # An integrator passes a corner by itself, with smaller steps, but not a jump.
        jumps = [event for event in kinks if event.order == 0 and event.period is None]
        for number, event in enumerate(jumps):
            gap = self._plain(event.argument - event.target)
            if not gap.free_symbols & unavailable:
                yield let(quantity(f"event_{number}", "1", event.name), gap)

    def _impacts(self) -> Iterator[Let]:
        """Yield the steps of each impact: rate of its gap, slopes of that in the rates,
        restitution.
        """
        for name, (gap, restitution) in self.stated.impacts.items():
            speed = self._plain(self.motion.rate(gap))
            yield self._let(f"opening_{name}", "m/s", speed)
            yield self._let(f"restitution_{name}", "1", self._plain(restitution))
            for c in self.coordinates:
                slope = partial_derivative(speed, c.rate)
                yield self._let(f"opening_{name}_{c.value}", _OF[c.value.unit], slope)

    def _given_actions(self) -> list[Action]:
        """Actions without an unknown."""
        unknowns = set(self.stated.assembly.unknowns)
        return [
            a
            for a in self.stated.assembly.actions
            if not any(
                self._plain(e).free_symbols & unknowns
                for e in (*a.force.components, *a.moment.components)
            )
        ]

    def _constrained_speeds(self) -> Mapping[str, Expr]:
        """Speeds that vanish: the rates of the gaps, then slips."""
        rates = {name: self.motion.rate(gap) for name, gap in self.stated.loops.gaps.items()}
        constrained_speeds = {
            name: self._plain(speed) for name, speed in (rates | self.stated.slips).items()
        }
        for name, speed in constrained_speeds.items():
            if not speed.free_symbols & {c.rate for c in self.coordinates}:
                raise MechanismError(f"{self.stated.name}: {name} holds none of the coordinates")
        return constrained_speeds

    def _plain(self, expr: Expr) -> Expr:
        return sp.sympify(expr).xreplace(self._moving)

    def _resting(self, expr: Expr) -> Expr:
        """Return an expression at zero accelerations."""
        return expr.xreplace(dict.fromkeys(self.accelerations, S.Zero))

    def _form(
        self,
        name: str,
        inputs: tuple[Vector | Quantity, ...],
        steps: Sequence[Let],
        motion: MotionSteps | None = None,
        output: str = "",
    ) -> ClosedForm:
        outputs = Vector(output or f"{name}_outputs", tuple(step.symbol for step in steps))
        listed = self._list_steps(motion, [*self.stated.reports, *steps], frozenset(outputs))
        return ClosedForm(name, inputs, listed, outputs)

    def _list_steps(
        self, motion: MotionSteps | None, last: Sequence[Step], symbols: frozenset[sp.Symbol]
    ) -> tuple[Step, ...]:
        """Return what symbols need of named expressions, of the steps of a motion, which may need
        these, and of last steps.
        """
        between = [] if motion is None else motion.steps
        required = frozenset().union(*(step.needs for step in between))
        early = needed(self.stated.reports, required)  # loads may be stated by them
        first = (*self.stated.defined, *early)
        stated, moving = set(map(id, first)), set(map(id, between))
        last = [step for step in last if id(step) not in stated]
        steps = needed((*first, *between, *last), symbols)
        return (
            *sorted_steps([step for step in steps if id(step) in stated]),
            *_note_once([step for step in steps if id(step) in moving]),
            *_note_once(sorted_steps([step for step in steps if id(step) not in stated | moving])),
        )

    @staticmethod
    def _let(name: str, unit: str, expr: Expr) -> Let:
        return let(quantity(name, unit, name.replace("_", " ")), expr)


def _note_once(steps: Sequence[Step]) -> list[Step]:
    """Return steps of which those that continue the one before have no note of their own."""
    before = [None, *(step.source for step in steps)]
    return [
        replace(step, source=COMMON) if step.source == source else step
        for step, source in zip(steps, before, strict=False)
    ]


@dataclass(frozen=True)
class BalanceRow:
    """A balance, or a law between actions: its slopes in these, and the rest."""

    equation: Equation
    slopes: Mapping[Quantity, Expr]
    rest: Expr

    @property
    def is_law(self) -> bool:
        """Whether the row is no balance."""
        return not isinstance(self.equation.claims, Balance)

    def by(self, action: Quantity) -> Expr:
        """Return the slope in an action, or in the size of one."""
        if action in self.slopes:
            return self.slopes[action]
        return partial_derivative(self.rest, action) if action in self.rest.free_symbols else S.Zero


@dataclass(frozen=True)
class Lever:
    """A body that a coordinate moves at its place among the coordinates, with the slopes of its
    spin or velocity.
    """

    body: Body
    kind: Kind
    at: Point
    place: int
    ways: Mapping[int, Vec]

    def slope(self, place: int) -> Expr:
        """Return the slope of the speed along the direction of this coordinate in the rate of
        one.
        """
        return self.ways[self.place].dot(self.ways[place]) if place in self.ways else S.Zero

    def load(self, size: Expr, ground: Body) -> Action:
        """Return a load along that direction."""
        way, nothing = size * self.ways[self.place], zero(self.ways[self.place].frame)
        force, moment = (way, nothing) if self.kind == "force" else (nothing, way)
        return Action("reaction", self.body, ground, self.at, force, moment)


def solve_in_order(matrix: list[list[Expr]], right: list[Expr]) -> list[Expr]:
    """Return the solution of equations whose pivots, in their order, do not vanish; it is not
    simplified.
    """
    count, right = len(right), list(right)
    for k, pivot_row in enumerate(matrix):
        for i in range(k + 1, count):
            if (share := matrix[i][k] / pivot_row[k]) != 0:
                matrix[i] = [a - share * b for a, b in zip(matrix[i], pivot_row, strict=True)]
                right[i] -= share * right[k]
    solution: list[Expr] = [S.Zero] * count
    for k in reversed(range(count)):
        partial_sum = sp.Add(*(matrix[k][j] * solution[j] for j in range(k + 1, count)))
        solution[k] = (right[k] - partial_sum) / matrix[k][k]
    return solution


def _steps_of_balances(
    rows: Sequence[BalanceRow], reactions: Mapping[Quantity, Sequence[Expr]]
) -> Iterator[Let]:
    """Yield ``held_i_u``, the slope of row i in the action u, and ``pushed_i``, all that is no
    joint's.

    The rows of all bodies determine the actions in any pose, where the mechanism holds nothing
    twice.
    """
    for i, row in enumerate(rows):
        claim = row.equation.claims
        moment = isinstance(claim, Balance) and claim.kind == "moment"
        for action, slope in (
            *row.slopes.items(),
            *((u, column[i]) for u, column in reactions.items()),
        ):
            unit = "m" if moment and action.unit == "N" else "1"
            name = f"held_{i}_{action}"
            yield let(quantity(name, unit, f"{row.equation.number}, by {action}"), slope)
        meaning = f"{row.equation.number}, without joints"
        yield let(quantity(f"pushed_{i}", "N m" if moment else "N", meaning), row.rest)
