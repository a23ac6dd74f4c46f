"""A mechanism that moves by itself: what its accelerations follow from, by the principle of virtual power.

    inertia accelerations = forces + slopes^T multipliers,    slopes accelerations = bends

Every body and every given action is projected on the rates of the coordinates; joints do no virtual work and stay out.
Gaps of closed loops and slips of rolling bodies vanish. Source: W. Schiehlen, "Multibody system dynamics: roots and
perspectives", Multibody Syst. Dyn. 1 (1997) 149-188, section 3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import sympy as sp
from sympy import Expr, S

from ..equations import Balance
from ..functions import directional_derivative, partial_derivative
from ..model import ClosedForm, Let, Step, let, list_kinks, list_passing_events, needed, sorted_steps
from ..quantity import Quantity, Vector
from .bodies import Action, Body, Part, action_load, body_loads, kinetic_energy, point_velocity, potential_energy
from .frames import Motion, Vec, zero
from .loops import Coordinate
from .statement import MechanismError, Statement, check_unit, place_functions, quantity

_OF = {"rad": "m", "m": "1", "1": "m"}
_FORCE = {"rad": "N m", "m": "N", "1": "N m"}
_INERTIA = {("rad", "rad"): "kg m2", ("m", "rad"): "kg m", ("m", "m"): "kg"}


def derive_free_motion(
    stated: Statement, time: Quantity, reported: Sequence[str | Quantity] | None
) -> tuple[ClosedForm, ...]:
    """The functions that an integrator needs, and what is reported of a state and its accelerations.

    Raises MechanismError, ChainError or DimensionError where they cannot be derived.
    """
    if not stated.loops.coordinates:
        raise MechanismError(f"{stated.name}: it has neither an angle to move along nor a coordinate to move in")
    return Free(stated, time).functions(reported)


def symbolic_accelerations(stated: Statement, time: Quantity) -> tuple[Expr, ...]:
    """Return the accelerations of the coordinates. Raises MechanismError if loops or rolling constrain them."""
    if constraints := [*stated.loops.gaps, *stated.slips]:
        raise MechanismError(f"{stated.name}: accelerations in symbols are those without {', '.join(constraints)}")
    return Free(stated, time).solved()


def project_on_rates(stated: Statement, time: Quantity) -> tuple[list[list[Expr]], list[Expr]]:
    """Return inertia (k, k) and forces (k,) of virtual power on the rates of the k coordinates.

    Joints, and whatever else guides bodies along their coordinates, do no work and stay out. Raises MechanismError for
    friction of a force that a joint would have to determine.
    """
    return Free(stated, time).project()


class FreeMotion(Motion):
    """Motion of many coordinates: rates of expressions in one pass."""

    def rate(self, expr: Expr) -> Expr:
        """Return the derivative of an expression in time."""
        return directional_derivative(expr, self.rates)


class Free:
    """A statement read as one of free motion."""

    def __init__(self, stated: Statement, time: Quantity) -> None:
        self.stated, self.motion, self.coordinates = stated, stated.motion, stated.loops.coordinates
        self.state = Vector("state", (*(c.value for c in self.coordinates), *(c.rate for c in self.coordinates)))
        self.accelerations = Vector("accelerations", tuple(c.acceleration for c in self.coordinates))
        self.inputs: tuple[Vector | Quantity, ...] = (time, stated.data(time), self.state)
        self._sizes = {
            sp.Abs(force): quantity(f"size_{force}", force.unit, f"size of {force}")
            for force in stated.assembly.unknowns
            if any(sp.Abs(force) in e.atoms(sp.Abs) for a in stated.assembly.actions for e in a.force.components)
        }
        sizes = Vector("sizes", tuple(self._sizes.values()))
        self.loaded = (*self.inputs, sizes) if self._sizes else self.inputs
        self._moving = stated.told_in({q for c in self.coordinates for q in (c.rate, c.acceleration)}) | self._sizes

    def functions(self, reported: Sequence[str | Quantity] | None) -> tuple[ClosedForm, ...]:
        """Build the functions in closed form that integrate the motion, and those of what is ``reported``."""
        self._refuse()
        names, constrained_speeds = [str(c.value) for c in self.coordinates], self._constrained_speeds()
        inertia, forces, starts = self._inertia(), self._forces(), self.stated.start_conditions
        rows = {
            "inertia": [
                self._let(f"inertia_{a}_{b}", self._inertia_unit(c, d), inertia[i][j])
                for i, (a, c) in enumerate(zip(names, self.coordinates, strict=True))
                for j, (b, d) in enumerate(zip(names, self.coordinates, strict=True))
            ],
            "forces": [
                self._let(f"force_{a}", _FORCE[c.value.unit], force)
                for a, c, force in zip(names, self.coordinates, forces, strict=True)
            ],
            "events": list(self._events()),
            "gaps": [self._let(name, "m", gap) for name, gap in self.stated.loops.gaps.items()],
            "start_gaps": [self._let(f"start_{name}", "m", gap) for name, (gap, _) in starts.items()],
            "start_speeds": [self._let(f"start_speed_{name}", "m/s", speed) for name, (_, speed) in starts.items()],
            "speeds": [self._let(f"speed_{name}", "m/s", speed) for name, speed in constrained_speeds.items()],
            "slopes": [
                self._let(f"slope_{name}_{c.value}", _OF[c.value.unit], partial_derivative(speed, c.rate))
                for name, speed in constrained_speeds.items()
                for c in self.coordinates
            ],
            "bends": [
                self._let(f"bend_{name}", "m/s2", -self._resting(self._plain(self.motion.rate(speed))))
                for name, speed in constrained_speeds.items()
            ],
        }
        full = {name: [step for step in steps if step.expr != 0] for name, steps in rows.items()}
        forms = [
            self._form(name, self.loaded if name == "forces" else self.inputs, steps)
            for name, steps in full.items() if steps
        ]  # fmt: skip
        drawing_functions = place_functions(self.stated, self.inputs, self.stated.named)
        return (self._start(), *forms, *self._outputs(reported), *drawing_functions)

    def solved(self) -> tuple[Expr, ...]:
        """Accelerations of the coordinates, if nothing holds them."""
        inertia, forces = self.project()
        return tuple(sp.Matrix(inertia).LUsolve(sp.Matrix(forces)))

    def project(self) -> tuple[list[list[Expr]], list[Expr]]:
        """Inertia and forces on the coordinates' rates."""
        if self._sizes:
            forces = ", ".join(str(size.args[0]) for size in self._sizes)
            raise MechanismError(
                f"{self.stated.name}: friction depends on the size of {forces}, which depends on the accelerations; "
                "state the normal force of this friction as a value, or leave the friction out"
            )
        return self._inertia(), self._forces()

    def _start(self) -> ClosedForm:
        start = self.stated.loops.start | self.stated.start
        steps = tuple(let(q, start.get(q, S.Zero)) for q in self.state)
        return ClosedForm("start", (self.stated.data(),), steps, Vector("start_state", self.state.quantities))

    def _outputs(self, reported: Sequence[str | Quantity] | None) -> tuple[ClosedForm, ...]:
        """Build the functions that report a state, its accelerations and, if needed, the joints' actions."""
        stated = self.stated
        energies = self._energies()
        reports = [*stated.reports, *stated.world_components(), *energies]
        stated.name_accelerations()
        actions = Vector("actions", tuple(stated.assembly.unknowns))
        reportable = [*(n.symbol for n in stated.named), *actions, *(r.symbol for r in reports)]
        if reported is not None:
            reported = list(dict.fromkeys([*map(str, reported), *(energy.symbol.name for energy in energies)]))
        outputs = Vector("outputs", stated.chosen(reportable, reported))
        steps = sorted_steps(needed((*stated.defined, *reports), frozenset(outputs)))
        taken = frozenset(outputs).union(*(step.needs for step in steps))
        inputs = (*self.inputs, self.accelerations)
        if not (taken & frozenset(actions) or self._sizes):
            return (ClosedForm("lane", inputs, steps, outputs),)
        return (
            self._form("balances", (*self.loaded, self.accelerations), self._balances()),
            ClosedForm("lane", (*inputs, actions), steps, outputs),
        )

    def _balances(self) -> list[Let]:
        """Every balance as a row: ``held_i_u``, its slope in the action u, and ``pushed_i``, all that is no joint's.

        The rows of all bodies determine the actions in any pose, where the mechanism holds nothing twice.
        """
        unknowns = self.stated.assembly.unknowns
        nothing = dict.fromkeys(unknowns, S.Zero)
        rows = []
        for i, equation in enumerate(self.stated.equations()):
            moment = isinstance(equation.claims, Balance) and equation.claims.kind == "moment"
            residual = equation.residual.xreplace(self._sizes)
            actions = [u for u in unknowns if u in residual.free_symbols]
            for u in actions:
                unit = "m" if moment and u.unit == "N" else "1"
                name = f"held_{i}_{u}"
                rows.append(let(quantity(name, unit, f"{equation.number}, by {u}"), partial_derivative(residual, u)))
            rest = residual.xreplace(nothing)
            pushed = quantity(f"pushed_{i}", "N m" if moment else "N", f"{equation.number}, without joints")
            rows.append(let(pushed, rest))
        return [step for step in rows if step.expr != 0]

    def _energies(self) -> tuple[Let, Let]:
        """Kinetic energy, and potential energy of weights and springs [J]."""
        stated, bodies = self.stated, self.stated.assembly.bodies
        moving = kinetic_energy(self.motion, bodies, stated.world)
        stored = sp.Add(*stated.potentials) + potential_energy(stated.assembly, bodies, stated.origin, stated.world)
        stored_name = quantity("potential", "J", "potential energy of weights and springs")
        return let(quantity("kinetic", "J", "kinetic energy"), moving), let(stored_name, stored)

    def _inertia(self) -> list[list[Expr]]:
        """Kinetic energy's slopes in two rates each; what given actions say of accelerations."""
        count = len(self.coordinates)
        total = [[S.Zero] * count for _ in range(count)]
        for body, part in self._parts():
            ways = self._ways(point_velocity(self.motion, part.centroid, self.stated.world))
            turns = self._ways(self.motion.spin(body.frame))
            rest = zero(self.stated.world), zero(body.frame)
            moved = sorted(ways.keys() | turns.keys())
            for i in moved:
                push, twist = ways.get(i, rest[0]), part.momentum(turns.get(i, rest[1]))
                for j in moved[: moved.index(i) + 1]:
                    total[i][j] += part.mass * push.dot(ways.get(j, rest[0])) + twist.dot(turns.get(j, rest[1]))
        added = [
            [-partial_derivative(push, a) if a in push.free_symbols else S.Zero for a in self.accelerations]
            for push in self._on_rates(self._given_loads())
        ]
        return [[total[max(i, j)][min(i, j)] + added[i][j] for j in range(count)] for i in range(count)]

    def _ways(self, speed: Vec) -> dict[int, Vec]:
        """Slopes of a velocity in the rates of those coordinates that it depends on, by their places."""
        x, y, z = map(self._plain, speed.components)
        felt = x.free_symbols | y.free_symbols | z.free_symbols
        return {
            i: Vec(
                speed.frame,
                (partial_derivative(x, c.rate), partial_derivative(y, c.rate), partial_derivative(z, c.rate)),
            )
            for i, c in enumerate(self.coordinates)
            if c.rate in felt
        }

    def _forces(self) -> list[Expr]:
        """Virtual power on each coordinate's rate of given actions, weights, and what inertia does at rest."""
        resting = [
            (Vec(load.frame, tuple(self._resting(self._plain(c)) for c in load.components)), speed)
            for load, speed in (*self._given_loads(), *self._body_loads())
        ]
        return self._on_rates(resting)

    def _on_rates(self, loads: Sequence[tuple[Vec, Vec]]) -> list[Expr]:
        """Virtual power of forces and moments at the velocities that they work on, on each coordinate's rate."""
        total = [S.Zero] * len(self.coordinates)
        for load, speed in loads:
            push = Vec(load.frame, tuple(map(self._plain, load.components)))
            for j, way in self._ways(speed).items():
                total[j] += push.dot(way)
        return total

    def _given_loads(self) -> list[tuple[Vec, Vec]]:
        stated = self.stated
        return [p for a in self._given_actions() for p in action_load(self.motion, a, stated.earth, stated.anchor)]

    def _body_loads(self) -> list[tuple[Vec, Vec]]:
        assembly = self.stated.assembly
        return [pair for body in assembly.bodies for pair in body_loads(assembly, body, self.stated.earth)]

    def _parts(self) -> list[tuple[Body, Part]]:
        return [(body, part) for body in self.stated.assembly.bodies for part in body.parts]

    def _refuse(self) -> None:
        """Raises DimensionError for a given action of another unit, MechanismError for friction that jumps at rest."""
        for action in self._given_actions():
            for load, unit in ((action.force, "N"), (action.moment, "N m")):
                for component in load.components:
                    check_unit(action.name, component, unit)
        for action in self.stated.assembly.actions:
            if any(self._sizes.keys() & e.atoms(sp.Abs) and e.has(sp.Piecewise) for e in action.force.components):
                raise MechanismError(
                    f"{self.stated.name}: {action.name} jumps where the sliding turns; in free motion it needs "
                    "`creep`, the speed below which it is smooth"
                )

    def _events(self) -> Iterator[Let]:
        """Yield a step for each event of a state; its value vanishes there."""
        stated, unavailable = self.stated, {*self.stated.assembly.unknowns, *self.accelerations}
        actions = [(a.name, (*a.force.components, *a.moment.components)) for a in stated.assembly.actions]
        moving = frozenset({self.inputs[0], *self.state})
        steps = (*stated.named, *stated.reports)
        kinks = list_kinks(steps, moving, list_passing_events(steps, stated.events, moving), actions)
        # An integrator passes a corner by itself, with smaller steps, but not a jump.
        jumps = [event for event in kinks if event.order == 0 and event.period is None]
        for number, event in enumerate(jumps):
            gap = self._plain(event.argument - event.target)
            if not gap.free_symbols & unavailable:
                yield let(quantity(f"event_{number}", "1", event.name), gap)

    def _given_actions(self) -> list[Action]:
        """Actions without an unknown."""
        unknowns = set(self.stated.assembly.unknowns)
        return [
            a
            for a in self.stated.assembly.actions
            if not any(self._plain(e).free_symbols & unknowns for e in (*a.force.components, *a.moment.components))
        ]

    def _constrained_speeds(self) -> Mapping[str, Expr]:
        """Speeds that vanish: the rates of the gaps, then slips."""
        rates = {name: self.motion.rate(gap) for name, gap in self.stated.loops.gaps.items()}
        constrained_speeds = {name: self._plain(speed) for name, speed in (rates | self.stated.slips).items()}
        for name, speed in constrained_speeds.items():
            if not speed.free_symbols & {c.rate for c in self.coordinates}:
                raise MechanismError(f"{self.stated.name}: {name} holds none of the coordinates")
        return constrained_speeds

    def _plain(self, expr: Expr) -> Expr:
        return sp.sympify(expr).xreplace(self._moving)

    def _resting(self, expr: Expr) -> Expr:
        """Return an expression at zero accelerations."""
        return expr.xreplace(dict.fromkeys(self.accelerations, S.Zero))

    def _form(self, name: str, inputs: tuple[Vector | Quantity, ...], steps: Sequence[Let]) -> ClosedForm:
        outputs = Vector(f"{name}_outputs", tuple(step.symbol for step in steps))
        steps_before = (*self.stated.named, *self.stated.reports)
        everything: tuple[Step, ...] = sorted_steps(needed((*steps_before, *steps), frozenset(outputs)))
        return ClosedForm(name, inputs, everything, outputs)

    @staticmethod
    def _let(name: str, unit: str, expr: Expr) -> Let:
        return let(quantity(name, unit, name.replace("_", " ")), expr)

    @staticmethod
    def _inertia_unit(a: Coordinate, b: Coordinate) -> str:
        pair = sorted("rad" if c.value.unit == "1" else c.value.unit for c in (a, b))
        return _INERTIA[pair[0], pair[1]]
