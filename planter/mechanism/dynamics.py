"""Free motion of a mechanism: accelerations, and their integration on the constraints.

inertia accelerations = forces + slopes^T multipliers,    slopes accelerations = bends

Redundant constraints are left out: a QR decomposition with column pivoting selects independent rows
of the slopes.
"""

from __future__ import annotations

import copy
import itertools
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt
import scipy
from threadpoolctl import threadpool_limits

from planter.errors import ComputationError, InputError, NotFiniteError
from planter.kernels import Array, CallError, Kernel
from planter.kernels.elimination import InertiaFactor
from planter.kernels.formulas import Formulas
from planter.mechanism.file import MechanismFile
from planter.mechanism.input_history import InputHistory
from planter.mechanism.motion_equations import MotionEquations, place_balances
from planter.numerics.roots import bracket_sign_changes
from planter.progress import name_step

RANK = 1e-9
"""Rows of the slopes that add less than this share of the first are redundant."""
PASSAGE = 1e-3
"""Rows that fall below this share of the weakest one at the start are left out while a singular
pose is passed.
"""
GAP_TOLERANCE = 1e-12
"""Gaps below this, in SI units, are closed."""
DIFFERENCE_STEP = 1e-7
"""Step of the implicit integrator's differences, in parts of a state and one."""
EVENT_SAMPLES = 32
"""Parts of an integrator's step in which an event is looked for."""
SIGN_SAMPLES = 4
"""The same for signs of normal forces, each of which costs as much as an evaluation."""
TIME_RESOLUTION = 1e-12
"""Events are located to this share of a motion's last time, of which floating point resolves
1e-16.
"""
BRANCH_STEP = 1e-3
"""Step to the poses next to one [rad, m]: singular values grow with it."""
PENETRATION = 1e-9
"""Gaps of impacts below minus this [m] are contacts that stay closed."""
HOP_SHARE = 0.25
"""First step after an impact, as a share of the time to the next one if the gap's rate goes on to
change as it does.
"""
MOST_SIGN_CHANGES = 50
"""Steps to the sizes of normal forces that friction follows from."""
MOST_PROJECTIONS = 30
"""Newton steps onto the constraints."""
HELD_TOLERANCE = 1e-9
"""Gaps and shares of speeds below this, in SI units, vanish although rows that follow from others
are not closed.
"""
MOST_EVALUATIONS = 1_000_000
"""Evaluations of the accelerations that a motion may need: minutes."""
CHECK_INTERVAL = 10_000
"""Evaluations between two checks of whether a motion advances fast enough."""
LONG_MOTION = 20_000
"""Evaluations from which on compiling them pays."""
START_TOLERANCE = 1e-9
"""A start is used as stated if it changes by less than this, in parts of it and one."""
BALANCE_RANK = 1e-10
"""Singular values of the balances below this share of the largest leave a reaction undetermined."""
BALANCE_TOLERANCE = 1e-6
"""A balance holds if its residual is less than this share of the largest load of the motion."""
LEAST_LOAD = 1e-9
"""Loads [N, N m] below this are rounding: of a mechanism at rest all may be zero."""


@dataclass(frozen=True)
class MotionRun:
    """A motion: times (n,) [s], states (2k, n), accelerations (k, n) and results (n,) by name, in
    SI and radians.

    A state holds coordinates, then rates. Signs, axes and units of results are those of the
    statement (`derive.Mechanism`). ``undetermined`` names statically indeterminate reactions:
    results lack them unless they are of minimum norm. ``events`` are those of the statement, in the
    order of time: contacts that close or open, laws that take another case.
    """

    times: Array
    states: Array
    accelerations: Array
    results: dict[str, Array]
    undetermined: tuple[str, ...] = ()
    events: tuple[Passage, ...] = ()


@dataclass(frozen=True)
class Passage:
    """The time [s] at which an event's value, such as the gap of a contact, changes its sign,
    rising or falling.
    """

    event: str
    time: float
    rising: bool


@dataclass(frozen=True)
class MotionStep:
    """A step of an integrator from a time to another [s]: its states (2k, n) as a function of times
    (n,), and the events at its end.
    """

    start: float
    end: float
    states: Callable[[Array], Array]
    crossed: Sequence[Passage]


@dataclass(frozen=True)
class Equations:
    """Equations of motion in a state: inertia (k, k), forces (k,), slopes (c, k), bends (c,),
    speeds (c,) and gaps; SI.

    ``inertia accelerations = forces + slopes^T multipliers`` and ``slopes accelerations = bends``.
    Gaps come before slips among the c constraints, and only they have gaps.
    """

    inertia: Array
    forces: Array
    slopes: Array
    bends: Array
    speeds: Array
    gaps: Array


class Dynamics:
    r"""A mechanism that moves freely, with the values of its file; k coordinates, states (2k,), SI
    units and radians.

    A state holds the coordinates, then their rates, in the order of `names`. Raises InputError if
    an angle drives the mechanism. The example is a pendulum, whose file
    ``planter derive pendulum.py`` writes:

        from derive import Mechanism, quantities
        q = quantities("g | m/s2 | free fall | 9.81\nl | m | length | 0.4\nm | kg | bob | 1")
        m = Mechanism("pendulum", q, gravity=q.g)
        rod = m.frame("rod", m.coordinate("a", "rad", "angle from the horizontal"))
        bob = m.body("bob", rod, q.m, m.point("C", m.O, rod, q.l))
        m.pin("A", bob, m.ground, m.O)
        SYSTEM = m.system()

    >>> from planter.mechanism.file import load                              # doctest: +SKIP
    >>> pendulum = Dynamics(load("pendulum.toml"))                           # doctest: +SKIP
    >>> pendulum.names, pendulum.size, pendulum.constraints                  # doctest: +SKIP
    (['a', 'a_dot'], 1, [])
    >>> start = pendulum.start()                                             # doctest: +SKIP
    >>> pendulum.accelerations(0.0, start)[0].round(3)                       # doctest: +SKIP
    array([-24.525])
    >>> motion = pendulum.run(np.linspace(0.0, 0.5, 6), state=start)         # doctest: +SKIP
    >>> motion.states[0, [0, -1]].round(3)                                   # doctest: +SKIP
    array([ 0.   , -2.397])
    >>> list(motion.results)                                                 # doctest: +SKIP
    ['a_bob_x', 'a_bob_y', 'F_Ax', 'F_Ay', 'kinetic', 'potential']
    """

    def __init__(self, file: MechanismFile, history: InputHistory | None = None) -> None:
        """`history` holds values of the file that change over time."""
        self.file, self.formulas, self.data = file, file.model, file.data()
        self.history = InputHistory() if history is None else history
        if "start" not in self.formulas.sidecar["functions"]:
            raise InputError(
                f"{file.source}: {file.name} is driven along an angle; `planter simulate` takes it"
            )
        self._stages = self.formulas.sidecar["functions"].keys()
        self.graphs = MotionEquations(self.formulas, self.history.place(self.data))

    def with_data(self, data: Array) -> Dynamics:
        """Return the same dynamics at other values (d,) [SI] of what its history holds."""
        _ = self._free_kernel if self._is_free else self._kernel  # which all share
        same = copy.copy(self)
        vars(same).pop("_begun", None)
        same.data, same.history = data, self.history.with_data(data)
        return same

    def data_at(self, times: Array | float) -> Array:
        """Return the values of the file [SI] at times (n,) [s], (d, n); at all times (d,) if none
        changes.
        """
        return self.history.evaluate(self.data, times)

    @property
    def names(self) -> list[str]:
        """The names of the coordinates [rad or m], then of their rates [rad/s or m/s]: the entries
        of a state.
        """
        return self.formulas.outputs("start")

    @property
    def size(self) -> int:
        """The number of coordinates k, without unit."""
        return len(self.names) // 2

    @cached_property
    def constraints(self) -> list[str]:
        """The names of the constraints: gaps [m, or without unit], then slips [m/s]."""
        return [name.removeprefix("speed_") for name in self._list_outputs("speeds")]

    @property
    def stated(self) -> Array:
        """The state (2k,) [rad, m and per s] at the start as the statement gives it; what it does
        not give is zero.
        """
        return np.array(list(self.formulas.at("start", data=self.data).values()))

    def start(self) -> Array:
        """Return the start (2k,) [rad, m and per s] of the statement, brought onto the constraints.

        What `derive.Mechanism.begin` holds keeps its value, which is all that it sets unless it
        names some of it; the rest follows by the least change that the inertia measures. If set
        values contradict the constraints and none are named to hold, all may change, and a
        RuntimeWarning says how. A released mechanism starts as the angle would drive it. Raises
        ComputationError if the constraints cannot be met from there, InputError if they cannot be
        met while the values named hold.
        """
        if changes := self.find_contradictions():
            warnings.warn(
                f"{self.file.name}: {describe_contradictions(changes)}",
                RuntimeWarning,
                stacklevel=2,
            )
        return self.find_start()

    def find_start(self) -> Array:
        """Return the same start (2k,) [rad, m and per s] without a warning, for those who report
        `find_changes`.
        """
        return self._begun[0].copy()

    def find_changes(self, start: Array) -> list[int]:
        """Return the indices of entries of ``start`` (2k,) [rad, m and per s] that differ from the
        statement.

        Of a released mechanism there are none: the statement says only about where its loops start.
        """
        if "start_gaps" in self._stages:
            return []
        stated = self.stated
        moved = np.abs(start - stated) > START_TOLERANCE * (1 + np.abs(stated))
        indices: list[int] = np.flatnonzero(moved).tolist()
        return indices

    def find_contradictions(self) -> dict[str, tuple[float, float]]:
        """Return set values that the constraints change although nothing is named to hold, as
        stated and as used; SI.

        Entries are coordinates [rad or m] and rates [per s] by name.
        """
        start, is_held = self._begun
        if is_held:
            return {}
        begun, stated = self.formulas.sidecar.get("begun", ()), self.stated
        names = {index: self.names[index] for index in self.find_changes(start)}
        return {
            name: (stated[index], start[index]) for index, name in names.items() if name in begun
        }

    @cached_property
    def _begun(self) -> tuple[Array, bool]:
        """Return the start, and whether all values that are set, or those named to hold, keep
        theirs.
        """
        sidecar, is_released = self.formulas.sidecar, "start_gaps" in self._stages
        names = [*self._list_outputs("start_gaps"), *self.constraints]
        find = partial(self._project, 0.0, self.stated, RANK, self._start_equations, names)
        if "held" in sidecar:
            try:
                return find(fixed=sidecar["held"]), True
            except ComputationError as error:
                names_held = ", ".join(sidecar["held"])
                raise InputError(
                    f"{error}; the start holds {names_held}: let fewer of them hold, or change them"
                ) from None
        if not is_released:
            with suppress(ComputationError):
                return find(fixed=sidecar.get("begun", ())), True
        return find(), is_released

    @cached_property
    def function(self) -> ca.Function:
        """The CasADi function (time [s], state (2k,), sizes (f,) [N], inputs (m,)) -> parts of
        `Equations` [SI]; some are sparse.

        The sizes are those of the normal forces that friction follows from (`find_sizes`), the
        inputs those of the history.
        """
        graphs = self.graphs
        symbols = [graphs.time, graphs.state, graphs.sizes, self.history.symbols]
        names = [field.name for field in fields(Equations)]
        outputs = [graphs.inertia, graphs.forces, graphs.slopes, graphs.bends]
        outputs += [graphs.speeds, graphs.gap_values]
        return ca.Function("motion", symbols, outputs, ["time", "state", "sizes", "inputs"], names)

    @property
    def _pressing(self) -> list[str]:
        """The names of the forces whose sizes are needed: normal forces of friction, forces of
        rigid teeth.
        """
        return self.graphs.pressing

    @cached_property
    def _is_rubbing(self) -> bool:
        """Whether accelerations depend on the sizes: by friction, not by the flank on which rigid
        teeth bear.
        """
        return self.graphs.is_rubbing

    def _list_outputs(self, stage: str) -> list[str]:
        return self.formulas.outputs(stage) if stage in self._stages else []

    @cached_property
    def _start_function(self) -> ca.Function:
        """Return the function (time, state) -> gaps and speeds that vanish at the start only, and
        slopes of these.
        """
        graphs = self.graphs
        gaps, speeds = (graphs.evaluate(stage) for stage in ("start_gaps", "start_speeds"))
        slopes = ca.densify(ca.jacobian(speeds, graphs.state)[:, self.size :])
        symbols = [graphs.time, graphs.state, self.history.symbols]
        return ca.Function("start", symbols, [gaps, speeds, slopes])

    def _start_equations(self, time: float, state: Array) -> Equations:
        """Return the equations of motion, with what holds at the start only among the
        constraints.
        """
        now = self.equations(time, state)
        if "start_gaps" not in self._stages:
            return now
        gaps, speeds, slopes = map(
            np.asarray, self._start_function(time, state, self.history.at(time))
        )
        return replace(
            now,
            gaps=np.r_[gaps[:, 0], now.gaps],
            speeds=np.r_[speeds[:, 0], now.speeds],
            slopes=np.vstack([slopes, now.slopes]),
        )

    @cached_property
    def _kernel(self) -> Kernel:
        names, inputs = self.function.name_in(), self.function.sx_in()
        parts = list(map(ca.densify, self.function(*inputs)))
        return Kernel(ca.Function("motion", inputs, parts, names, self.function.name_out()))

    def equations(self, time: float, state: Array, sizes: Array | None = None) -> Equations:
        """Return the parts of the equations of motion [SI] in a state (2k,) [rad, m and per s] at a
        time [s].

        Without the ``sizes`` (f,) [N] of normal forces (`find_sizes`) it is as if there were no
        friction.
        """
        now = self._kernel(
            time=time,
            state=state,
            sizes=np.zeros(len(self._pressing)) if sizes is None else sizes,
            inputs=self.history.at(time),
        )
        columns = {name: now[name][:, 0] for name in ("forces", "bends", "speeds", "gaps")}
        return Equations(now["inertia"], slopes=now["slopes"], **columns)

    def accelerations(self, time: float, state: Array, share: float = RANK) -> tuple[Array, Array]:
        """Return accelerations (k,) [rad/s2 or m/s2] and multipliers (c,) of the constraints in a
        state (2k,).

        The time is in [s], the state in rad, m and per s. A multiplier is the generalised force per
        slope, [N] for a gap in m; it is zero for a constraint that follows from others. Rows of
        slopes that add less than ``share`` of the first follow from others. Raises ComputationError
        if neither inertia nor a constraint resists some motion, or as `find_sizes` does.
        """
        if self._is_free:
            with suppress(NotFiniteError):  # of which the dense equations tell the reason
                inputs = self.history.at(time)
                solved = self._free_kernel(time=time, state=state, inputs=inputs)
                return solved["accelerations"][:, 0], np.empty(0)
        sizes = (
            self.find_sizes(time, state, share)
            if self._is_rubbing
            else np.zeros(len(self._pressing))
        )
        return self._accelerate(time, state, sizes, share)

    def find_sizes(self, time: float, state: Array, share: float = RANK) -> Array:
        """Return the sizes (f,) [N or N m] of the forces that friction or the flank of teeth
        follows from.

        The forces are linear in their own sizes, through the accelerations. Arguments are those of
        `accelerations`. Raises ComputationError if no sizes do, since the mechanism jams, or if a
        force is statically indeterminate.
        """
        return np.abs(self.find_normal_forces(time, state, share))

    def find_normal_forces(self, time: float, state: Array, share: float = RANK) -> Array:
        """Return these forces (f,) [N or N m], as `find_sizes` their sizes."""
        count = len(self._pressing)
        if not count:
            return np.empty(0)
        trials = np.vstack([np.zeros(count), np.eye(count)])
        accelerations = [self._accelerate(time, state, sizes, share)[0] for sizes in trials]
        forces = self._normal_forces(time, state, trials, np.array(accelerations))
        alone, slopes = forces[0], (forces[1:] - forces[0]).T
        signs = np.copysign(1.0, alone)
        with suppress(np.linalg.LinAlgError):
            for _ in range(MOST_SIGN_CHANGES):
                sizes: Array = np.linalg.solve(
                    np.eye(count) - signs[:, None] * slopes, signs * alone
                )
                before, signs = signs, np.copysign(1.0, alone + slopes @ sizes)
                if np.array_equal(signs, before):
                    return signs * sizes
        raise ComputationError(
            f"{self.file.name}: at {time:.6g} s friction jams: no forces "
            f"{', '.join(self._pressing)} go with it"
        )

    def _normal_forces(
        self, time: float, state: Array, sizes: Array, accelerations: Array
    ) -> Array:
        """Return the normal forces (n, f) [N] at sizes (n, f) [N], with the accelerations (n, k)
        that they give.
        """
        inputs = {
            "time": np.full(len(sizes), time),
            "data": self.data_at(time),
            "state": np.tile(state, (len(sizes), 1)).T,
        }
        actions, undetermined = self._reactions.solve(
            inputs | {"sizes": sizes.T, "accelerations": accelerations.T}
        )
        if self._is_rubbing and (lacking := set(undetermined) & set(self._pressing)):
            raise ComputationError(
                f"{self.file.name}: the size of {', '.join(sorted(lacking))} decides on friction "
                f"or flanks, and it is "
                "statically indeterminate"
            )
        return actions[[self._reactions.names.index(name) for name in self._pressing]].T

    def _solve_reactions(
        self, inputs: Mapping[str, object], sizes: Array
    ) -> tuple[Array, tuple[str, ...]]:
        """Return reactions (u, n) at sizes (n, f), and the names of those that are undetermined.

        What follows from the size of an undetermined reaction, as a tooth's normal force, is
        undetermined, too.
        """
        loads = {"sizes": sizes.T} if self._pressing else {}
        actions, undetermined = self._reactions.solve({**inputs, **loads})
        unknown_sizes = np.array([name in undetermined for name in self._pressing], dtype=bool)
        if unknown_sizes.any():
            changed = (
                self._reactions.solve({**inputs, "sizes": (sizes + unknown_sizes).T})[0] - actions
            )
            depends = np.abs(changed).max(axis=1) > np.sqrt(BALANCE_RANK)
            names = self._reactions.names
            undetermined = tuple(
                name
                for name, is_changed in zip(names, depends, strict=True)
                if is_changed or name in undetermined
            )
        return actions, undetermined

    @cached_property
    def _reactions(self) -> Reactions:
        return Reactions(self.formulas)

    def _accelerate(
        self, time: float, state: Array, sizes: Array, share: float
    ) -> tuple[Array, Array]:
        """Return accelerations (k,) and multipliers (c,) with given sizes of the forces that
        friction follows from.
        """
        now = self.equations(time, state, sizes)
        rows = find_independent_rows(now.slopes, share)
        multipliers = np.zeros(len(now.slopes))
        accelerations, multipliers[rows] = self._solve(
            time, now.inertia, now.slopes[rows], now.forces, now.bends[rows]
        )
        return accelerations, multipliers

    def _bind_accelerations(self, share: float) -> Callable[[float, Array], Array]:
        """Return the function (time, state) -> accelerations (k,) for many calls in this thread.

        Where nothing constrains the motion, one call of a kernel solves for them, in memory that
        the next call writes again.
        """
        if not self._is_free:
            return lambda time, state: self.accelerations(time, state, share)[0]
        now, at = np.zeros((1, 1)), np.zeros((2 * self.size, 1))
        inputs = np.zeros((self.history.symbols.numel(), 1))
        solve = self._free_kernel.bind(time=now, state=at, inputs=inputs)
        accelerations, columns = solve.outputs["accelerations"][:, 0], at[:, 0]

        def accelerate(time: float, state: Array) -> Array:
            now[0, 0], columns[:] = time, state
            if len(inputs):
                inputs[:, 0] = self.history.at(time)
            solve()
            return accelerations

        return accelerate

    @cached_property
    def _free_kernel(self) -> Kernel:
        graphs = self.graphs
        accelerations = graphs.accelerations
        if accelerations is None:
            accelerations = InertiaFactor(graphs.inertia).solve(graphs.forces)
        symbols = [graphs.time, graphs.state, self.history.symbols]
        names = ["time", "state", "inputs"]
        solved = ca.Function("free", symbols, [accelerations], names, ["accelerations"])
        return Kernel(solved, names)

    def compile(self) -> None:
        """Compile what is evaluated most often, for many motions; results may change by
        rounding.
        """
        if self._is_free:
            self._free_kernel.compile()

    @property
    def _is_free(self) -> bool:
        """Whether neither constraints nor friction of unknown forces make the accelerations depend
        on reactions.
        """
        return not (self.constraints or self._is_rubbing)

    def dependent(self, state: Array, time: float = 0.0) -> list[str]:
        """Return the names of constraints that follow from one another in a state (2k,) [rad, m,
        per s] at a time [s].

        `redundant` says how many there are too many.
        """
        slopes = self.equations(time, state).slopes
        sizes = (
            np.linalg.norm(scipy.linalg.null_space(slopes.T, RANK), axis=1)
            if len(slopes)
            else np.empty(0)
        )
        return [
            name for name, size in zip(self.constraints, sizes, strict=True) if size > np.sqrt(RANK)
        ]

    def redundant(self, state: Array) -> int:
        """Return how many constraints follow from the others in a state (2k,) [rad, m and per s] at
        the start.
        """
        slopes = self.equations(0.0, state).slopes
        return len(slopes) - len(find_independent_rows(slopes))

    def project(self, time: float, state: Array, share: float = RANK) -> Array:
        """Return the state (2k,) [rad, m and per s] on the constraints that is nearest to one at a
        time [s].

        The inertia is the measure of distance. Rows of slopes that add less than ``share`` of the
        first follow from others. Raises ComputationError if the constraints cannot be met from
        there.
        """
        if not self.constraints:
            return np.array(state, dtype=float)
        return self._project(time, state, share, self.equations, self.constraints)

    def _project(
        self,
        time: float,
        state: Array,
        share: float,
        equations: Callable[[float, Array], Equations],
        names: Sequence[str],
        fixed: Sequence[str] = (),
    ) -> Array:
        """Return the nearest state on the constraints of some equations, which have names; gaps
        come first.

        Coordinates and rates that are ``fixed`` keep their values. Raises ComputationError if the
        others cannot follow.
        """
        at = np.array(state, dtype=float)
        free = np.array([name not in fixed for name in self.names]).reshape(2, -1)
        for _ in range(MOST_PROJECTIONS):
            now = equations(time, at)
            slopes = now.slopes[: len(now.gaps)][:, free[0]]
            rows = find_independent_rows(slopes, share)
            if np.all(np.abs(now.gaps[rows]) < GAP_TOLERANCE):
                break
            at[: self.size][free[0]] -= self._find_correction(
                time, now.inertia, slopes[rows], now.gaps[rows], free[0]
            )
        else:
            self._refuse_open(time, now.gaps, np.ones(len(now.gaps)), names)
        if fixed:
            self._refuse_open(time, now.gaps, np.ones(len(now.gaps)), names)
        for _ in range(MOST_PROJECTIONS if self._has_curved_slips else 1):  # else one step is exact
            slopes = now.slopes[:, free[1]]
            rows = find_independent_rows(slopes, share)
            at[self.size :][free[1]] -= self._find_correction(
                time, now.inertia, slopes[rows], now.speeds[rows], free[1]
            )
            if self._has_curved_slips or fixed:
                now = equations(time, at)
        if fixed or self._has_curved_slips:
            terms = np.abs(now.slopes) @ np.abs(at[self.size :])
            self._refuse_open(time, now.speeds, np.maximum(terms, 1.0), names)
        return at

    def _refuse_open(self, time: float, values: Array, sizes: Array, names: Sequence[str]) -> None:
        """Raise ComputationError for gaps or speeds that do not vanish, by their sizes."""
        worst = int(np.argmax(np.abs(values) / sizes)) if len(values) else None
        if worst is not None and np.abs(values[worst]) > HELD_TOLERANCE * sizes[worst]:
            raise ComputationError(
                f"{self.file.name}: the loops do not close at {time:.6g} s: {names[worst]} is "
                f"{np.abs(values[worst]):.3g} in SI"
            )

    @cached_property
    def _has_curved_slips(self) -> bool:
        """Whether a speed that vanishes is not linear in the rates."""
        slopes, rates = self.graphs.slopes, self.graphs.state[self.size :]
        return bool(len(self.constraints)) and any(
            ca.which_depends(ca.vec(slopes), rates, 1, False)
        )

    def _find_correction(
        self, time: float, inertia: Array, slopes: Array, gaps: Array, free: npt.NDArray[np.bool_]
    ) -> Array:
        """Return the smallest step of what is ``free`` (k,), by the inertia, that closes the
        gaps.
        """
        count = int(free.sum())
        return self._solve(time, inertia[np.ix_(free, free)], slopes, np.zeros(count), gaps)[0]

    def _solve(
        self, time: float, inertia: Array, slopes: Array, push: Array, bend: Array
    ) -> tuple[Array, Array]:
        """Return x, y of  inertia x - slopes^T y = push,  slopes x = bend."""
        count = len(slopes)
        system = np.block([[inertia, -slopes.T], [slopes, np.zeros((count, count))]])
        try:
            solution = np.linalg.solve(system, np.concatenate([push, bend]))
        except np.linalg.LinAlgError:
            raise ComputationError(
                f"{self.file.name}: at {time:.6g} s neither inertia nor a constraint resists some "
                f"motion"
            ) from None
        return solution[: len(push)], solution[len(push) :]

    def run(
        self,
        times: Array,
        tolerance: float = 1e-10,
        state: Array | None = None,
        minimum_norm: bool = False,
        stiff: bool = False,
        steps: list[MotionStep] | None = None,
    ) -> MotionRun:
        """Return the motion at times (n,) [s] that rise, from ``state`` (2k,) [rad, m and per s] at
        the first of them.

        The start of the statement is used unless a state is passed; each step is projected onto the
        constraints. ``tolerance`` is relative, the absolute one a hundredth of it in SI. The
        integrator is DOP853, or the implicit Radau IIA if springs and dampers are ``stiff``. With
        ``minimum_norm``, results have statically indeterminate reactions by least squares, else
        they lack them. ``steps`` are those of `integrate`. Raises ComputationError if the
        integrator fails, if the motion would need
        more than MOST_EVALUATIONS, or if the joints do not allow the motion.
        """
        times = np.asarray(times, dtype=float)
        with threadpool_limits(1, "blas"):  # more threads would wait, in many small linear systems
            at = self.project(times[0], self.start() if state is None else state)
            self.accelerations(
                times[0], at
            )  # refuses what neither inertia nor a constraint resists
            states, passages = self.integrate(times, tolerance, at, stiff, steps)
            with name_step(f"{self.file.name}: results at {len(times)} times"):
                return self._results(
                    times, states, minimum_norm, self._find_share(times[0], at), passages
                )

    def integrate(
        self,
        times: Array,
        tolerance: float,
        state: Array,
        stiff: bool = False,
        steps: list[MotionStep] | None = None,
    ) -> tuple[Array, list[Passage]]:
        """Return states (2k, n) [rad, m and per s] and events of a motion at times (n,) [s] from an
        allowed state.

        The integrator's steps are added to `steps`; if there are any to be added, events are also
        changes of signs of the normal forces that friction follows from. The rest is as for `run`.
        """
        pace, share = _Pace(self.file.name, times[0], times[-1]), self._find_share(times[0], state)
        self._refuse_branches(times[0], state)
        accelerate = self._bind_accelerations(share)

        size = self.size

        def rates(time: float, y: Array) -> Array:
            if pace.count(time) == LONG_MOTION:
                self.compile()
            try:
                return np.concatenate([y[size:], accelerate(time, y)])
            except (CallError, NotFiniteError):
                # the step is too long: the integrator tries a shorter one
                return np.full(2 * size, np.nan)

        def differentiate(time: float, y: Array) -> Array:
            steps = DIFFERENCE_STEP * (1 + np.abs(y))
            jacobian: Array = scipy.optimize.approx_fprime(
                y, lambda point: rates(time, point), steps
            )
            return jacobian

        method = (
            partial(scipy.integrate.Radau, jac=differentiate) if stiff else scipy.integrate.DOP853
        )
        begin = partial(method, rates, rtol=tolerance, atol=1e-2 * tolerance)
        solver, states, passages = begin(times[0], state, times[-1]), [state], []
        resolution = TIME_RESOLUTION * np.abs(times[[0, -1]]).max()
        names = [*self.event_names, *(self._sign_names if steps is not None else ())]
        signs = np.zeros(len(names))
        with name_step(
            lambda: f"{self.file.name}: integrated {solver.t:.4g} s of {times[-1]:.4g} s"
        ):
            while solver.t < times[-1]:
                at = solver.y
                if (message := solver.step()) is not None:
                    raise ComputationError(
                        f"{self.file.name}: the motion stops at {solver.t:.6g} s: {message}"
                    )
                crossed, after = (
                    self._find_passages(solver, signs, resolution, names, share)
                    if names
                    else ([], signs)
                )
                impact = next(
                    (passage for passage in crossed if passage.event in self.impacts), None
                )
                inside = [
                    passage.time
                    for passage in crossed
                    if passage.time > solver.t_old + 2 * resolution
                ]
                if (
                    inside and solver.t > inside[0] + 2 * resolution
                ):  # another law holds in part of the step
                    solver = begin(solver.t_old, at, inside[0] + resolution)
                    continue
                end = solver.t
                if impact is not None:  # what else happens later in the step is found again
                    end, crossed = impact.time, crossed[: crossed.index(impact) + 1]
                    changed = [passage.event for passage in crossed]
                    after = np.where(np.isin(names, changed), after, signs)
                    after[names.index(impact.event)] = 0.0
                    after[len(self.event_names) :] = 0.0  # normal forces may be others after it
                signs = after
                passages += crossed
                passed = times[len(states) :][times[len(states) :] <= end]
                dense: Any = None
                if len(passed) or impact is not None or steps is not None:
                    dense = solver.dense_output()  # takes three evaluations
                if steps is not None:
                    _add_step(steps, MotionStep(solver.t_old, end, dense, crossed), resolution)
                states += [self.project(time, dense(time), share) for time in passed]
                at = self.project(end, dense(end) if impact else solver.y, share)
                if impact is not None:
                    at = self.rebound(end, at, impact.event)
                    hop = self._estimate_hop(end, at, impact.event, rates)
                    solver = begin(end, at, times[-1], first_step=min(hop, times[-1] - end) or None)
                elif crossed or solver.status == "finished":
                    solver = begin(solver.t, at, times[-1])
                elif self.constraints:
                    solver.y, solver.f = at, solver.fun(solver.t, at)
        return np.array(states).T, passages

    def _refuse_branches(self, time: float, state: Array) -> None:
        """Raise ComputationError if more constraints depend on each other in a state than in poses
        next to it: several motions go on from there.
        """
        slopes = self.equations(time, state).slopes
        rank = len(find_independent_rows(slopes))
        if rank == len(slopes):
            return
        ways, moved = scipy.linalg.null_space(slopes, RANK), np.array(state, dtype=float)
        moved[: self.size] += BRANCH_STEP * ways.sum(axis=1)  # a way that no branch takes alone
        try:
            moved = self.project(time, moved)
        except ComputationError:  # no other pose is next to it
            return
        if len(find_independent_rows(self.equations(time, moved).slopes)) > rank:
            names, places = ", ".join(self.dependent(state, time)), self.names[: self.size]
            pose = (f"{name} = {value:.6g}" for name, value in zip(places, state, strict=False))
            raise ComputationError(
                f"{self.file.name}: at {time:.6g} s the pose {', '.join(pose)} (SI) is singular: "
                f"{names} depend on each other there, and several motions go on; start beside it"
            )

    @cached_property
    def impacts(self) -> list[str]:
        """The names of the events at which rates jump."""
        return [f"impact of {name}" for name in self.graphs.impacts]

    @cached_property
    def _impact_function(self) -> ca.Function:
        """(time, state, inputs) -> rates of gaps, their slopes, and restitutions."""
        graphs = self.graphs
        symbols = [graphs.time, graphs.state, self.history.symbols]
        outputs = [graphs.openings, graphs.opening_slopes, graphs.restitutions]
        return ca.Function("impacts", symbols, list(map(ca.densify, outputs)))

    def rebound(self, time: float, state: Array, event: str) -> Array:
        """Return the state (2k,) [rad, m and per s] after an impact, the same if its gap opens.

        Raises ComputationError if nothing resists the impulse.
        """
        jump = self.find_impulses(time, state, event)[0]
        return np.concatenate([state[: self.size], state[self.size :] + jump])

    def find_impulses(self, time: float, state: Array, event: str) -> tuple[Array, Array]:
        """Return the jump (k,) of the rates [rad/s, m/s] at an impact, and the impulses (c + i,) of
        constraints and impacts, of which those that have no part vanish [N s for a gap in m].
        """
        opening, row, restitution = self._find_opening(time, state, event)
        now = self.equations(time, state)
        impulses = np.zeros(len(now.slopes) + len(self.impacts))
        if opening >= 0:
            return np.zeros(self.size), impulses
        rows = find_independent_rows(now.slopes)
        bends = np.append(np.zeros(len(rows)), -(1 + restitution) * opening)
        slopes = np.vstack([now.slopes[rows], row])
        chosen = np.append(rows, len(now.slopes) + self.impacts.index(event))
        jump, impulses[chosen] = self._solve(time, now.inertia, slopes, np.zeros(self.size), bends)
        return jump, impulses

    def _find_opening(self, time: float, state: Array, event: str) -> tuple[float, Array, float]:
        """Return the rate of the gap of an impact [m/s], its slopes (k,), and the restitution."""
        values = self._impact_function(time, state, self.history.at(time))
        openings, slopes, restitutions = map(np.array, values)
        index = self.impacts.index(event)
        return openings[index, 0], slopes[index], restitutions[index, 0]

    def _estimate_hop(
        self, time: float, state: Array, event: str, rates: Callable[[float, Array], Array]
    ) -> float:
        """Return a first step [s] after an impact, a share of the time in which its gap is open; 0
        if it goes on to open.
        """
        step = DIFFERENCE_STEP
        opening, later = (
            self._find_opening(time + shift, state + shift * rates(time, state), event)[0]
            for shift in (0.0, step)
        )
        return HOP_SHARE * 2 * opening * step / max(opening - later, 0) if later < opening else 0.0

    def _find_share(self, time: float, state: Array) -> float:
        """Return the share of the first row of slopes below which others follow from it, in a
        motion from a state.
        """
        if not self.constraints:
            return RANK
        return max(RANK, PASSAGE * find_weakest_share(self.equations(time, state).slopes))

    @cached_property
    def event_names(self) -> list[str]:
        """The names of the events, which the meanings of their values are."""
        return [
            entry["meaning"] for entry in self.formulas.sidecar["vectors"].get("events_outputs", ())
        ]

    @cached_property
    def _sign_names(self) -> list[str]:
        """The names of the events at which normal forces that friction follows from change signs."""
        return [f"sign of {name}" for name in self._pressing] if self._is_rubbing else []

    def _find_passages(
        self,
        solver: scipy.integrate.OdeSolver,
        signs: Array,
        resolution: float,
        names: Sequence[str],
        share: float,
    ) -> tuple[list[Passage], Array]:
        """Return the events of an integrator's last step by time, and the signs (e,) of their
        values after it.

        `signs` are those before it, zero if unknown. Values within GAP_TOLERANCE of zero have no
        sign of their own: rounding decides on it where flanks touch without load.
        """
        state = solver.dense_output()

        def evaluate_events(times: Array) -> Array:
            inputs = {"time": times, "data": self.data_at(times), "state": state(times)}
            return np.array(list(self.formulas("events", **inputs).values()))

        def evaluate_forces(times: Array) -> Array:
            pairs = zip(times, state(times).T, strict=True)
            return np.array([self.find_normal_forces(*pair, share) for pair in pairs]).T

        rows, kinds = [], [(evaluate_events, EVENT_SAMPLES)] if self.event_names else []
        if len(names) > len(self.event_names):
            kinds.append((evaluate_forces, SIGN_SAMPLES))
        for evaluate, parts in kinds:
            times = np.linspace(solver.t_old, solver.t, parts + 1)
            rows += [(evaluate, times, row, values) for row, values in enumerate(evaluate(times))]
        passages, after = [], signs.copy()
        for index, (evaluate, times, row, values) in enumerate(rows):

            def value(
                time: float, row: int = row, evaluate: Callable[[Array], Array] = evaluate
            ) -> float:
                return float(evaluate(np.array([time]))[row, 0])

            for start, end, is_rising in bracket_sign_changes(
                value, times, values, float(signs[index]), GAP_TOLERANCE
            ):
                is_over = start == end or (value(start) > 0) == is_rising  # within the tolerance
                time = (
                    start if is_over else scipy.optimize.brentq(value, start, end, xtol=resolution)
                )
                passages.append(Passage(names[index], float(time), is_rising))
            if names[index] in self.impacts:
                passages = [p for p in passages if p.event not in self.impacts or not p.rising]
                self._refuse_closed(solver.t, names[index], values[-1], passages)
            outside = values[np.abs(values) > GAP_TOLERANCE]
            if len(outside):
                after[index] = np.sign(outside[-1])
        return sorted(passages, key=lambda passage: passage.time), after

    def _refuse_closed(
        self, time: float, event: str, gap: float, passages: Sequence[Passage]
    ) -> None:
        """Raise ComputationError if the gap [m] of an impact is closed without one."""
        if gap < -PENETRATION and event not in [passage.event for passage in passages]:
            contact = event.removeprefix("impact of ")
            raise ComputationError(
                f"{self.file.name}: at {time:.6g} s the contact {contact} stays closed, which no "
                f"impact opens; let the motion end before that, or state it by `compliant_contact`"
            )

    def _results(
        self,
        times: Array,
        states: Array,
        minimum_norm: bool,
        share: float,
        passages: Sequence[Passage],
    ) -> MotionRun:
        pairs = zip(times, states.T, strict=True)
        accelerations = np.array(
            [self.accelerations(time, state, share)[0] for time, state in pairs]
        ).T
        inputs = {
            "time": times,
            "data": self.data_at(times),
            "state": states,
            "accelerations": accelerations,
        }
        undetermined: tuple[str, ...] = ()
        if "balances" in self._stages:
            sizes = np.array(
                [
                    self.find_sizes(time, state, share)
                    for time, state in zip(times, states.T, strict=True)
                ]
            )
            inputs["actions"], undetermined = self._solve_reactions(inputs, sizes)
        results = {
            name: values
            for name, values in self.formulas("lane", **inputs).items()
            if minimum_norm or name not in undetermined
        }
        return MotionRun(times, states, accelerations, results, undetermined, tuple(passages))


def _add_step(steps: list[MotionStep], step: MotionStep, resolution: float) -> None:
    """Add a step to those before it; events at its start are those of the end of the last one.

    Within the tolerance of its value an event is told by the step that begins at it.
    """
    begun = [passage for passage in step.crossed if passage.time <= step.start + 2 * resolution]
    if begun and steps:
        steps[-1] = replace(steps[-1], crossed=[*steps[-1].crossed, *begun])
    if step.end > step.start + 2 * resolution or not begun:
        later = [passage for passage in step.crossed if passage not in begun]
        steps.append(replace(step, crossed=later))


class _Pace:
    """Watches the progress of a motion: extreme values make steps so short that it would not
    end.
    """

    def __init__(self, name: str, start: float, end: float) -> None:
        self._name, self._start, self._end, self._count = name, start, end, 0

    def count(self, time: float) -> int:
        """Count an evaluation at a time [s], and return its number.

        Raises ComputationError if there would have to be too many of them.
        """
        self._count += 1
        if self._count % CHECK_INTERVAL == 0 and (
            abs(time - self._start) * MOST_EVALUATIONS < self._count * abs(self._end - self._start)
        ):
            raise ComputationError(
                f"{self._name}: after {self._count} evaluations the motion is only at {time:.6g} "
                f"s of {self._end:.6g} "
                "s: its values are extreme, or stiff, or the time is long; --stiff, a larger "
                "--tolerance or a smaller "
                "--until may help"
            )
        return self._count


def describe_contradictions(changes: Mapping[str, tuple[float, float]]) -> str:
    """Return the sentence on values (stated, used) [SI] of a start that contradict the
    constraints.
    """
    values = ", ".join(
        f"{name} is {used:.6g} instead of {stated:.6g}" for name, (stated, used) in changes.items()
    )
    return (
        f"the start contradicts the constraints: {values}; name the coordinates or rates that "
        f"hold: "
        "m.begin(..., hold=[...])"
    )


def find_independent_rows(slopes: Array, share: float = RANK) -> npt.NDArray[np.intp]:
    """Return independent rows (m,) of slopes (c, k), in their order."""
    order, sizes = _rank_rows(slopes)
    return np.sort(order[sizes > share])


def find_weakest_share(slopes: Array) -> float:
    """Return the contribution of the weakest independent row, over that of the first."""
    _, sizes = _rank_rows(slopes)
    return float(np.min(sizes[sizes > RANK], initial=1.0))


def _rank_rows(slopes: Array) -> tuple[npt.NDArray[np.intp], Array]:
    """Return rows in the order of a pivoting QR decomposition, and their contributions over that of
    the first.
    """
    if not slopes.any():
        return np.arange(0), np.empty(0)
    triangle, order = scipy.linalg.qr(slopes.T, mode="r", pivoting=True)
    sizes = np.abs(np.diagonal(triangle))
    return order[: len(sizes)], sizes / sizes[0]


class Reactions:
    """Reactions of joints in free motion, from the generated balances of all bodies by least
    squares.

    Without redundant constraints the balances determine them in every pose, also where bars are
    collinear: then the solution of least squares is unique. Outputs of the balances are
    ``held_i_u`` and ``pushed_i``.
    """

    def __init__(self, formulas: Formulas) -> None:
        self.formulas = formulas
        self.names = [entry["name"] for entry in formulas.sidecar["vectors"]["actions"]]
        self._places = place_balances(formulas.outputs("balances"), self.names)

    def solve(self, inputs: Mapping[str, object]) -> tuple[Array, tuple[str, ...]]:
        """Return reactions (u, n) of states, and the names of those that some pose leaves
        undetermined.

        Raises ComputationError if no reactions of the joints allow the motion.
        """
        matrix, right = self.build_rows(inputs)
        size = float(np.abs(right).max(initial=LEAST_LOAD))
        reactions, undetermined = [], np.zeros(len(self.names), dtype=bool)
        for rows, loads in zip(matrix, right, strict=True):
            actions, _, rank, _ = np.linalg.lstsq(rows, -loads, rcond=BALANCE_RANK)
            self._check(rows @ actions + loads, size)
            reactions.append(actions)
            if rank < len(self.names):
                null_sizes = np.linalg.norm(scipy.linalg.null_space(rows, BALANCE_RANK), axis=1)
                undetermined |= null_sizes > np.sqrt(BALANCE_RANK)
        return np.array(reactions).T, tuple(itertools.compress(self.names, undetermined))

    def _check(self, residuals: Array, size: float) -> None:
        worst = int(np.argmax(np.abs(residuals)))
        if abs(residuals[worst]) > BALANCE_TOLERANCE * size:
            entry = next(
                e
                for e in self.formulas.sidecar["vectors"]["balances_outputs"]
                if e["name"].split("_", 2)[1] == str(worst)
            )
            raise ComputationError(
                f"{self.formulas.name}: the joints do not allow the motion of the coordinates: "
                f"{entry['meaning'].rpartition(', ')[0]} is off by {abs(residuals[worst]):.3g}; a "
                f"joint or force is "
                "missing"
            )

    def build_rows(self, inputs: Mapping[str, object]) -> tuple[Array, Array]:
        """Return slopes (n, rows, u) of the balances in the reactions, and the loads (n, rows)."""
        values = list(self.formulas("balances", **inputs).values())
        rows = 1 + max(row for row, _ in self._places)
        matrix = np.zeros((len(values[0]), rows, len(self.names) + 1))
        for (row, column), value in zip(self._places, values, strict=True):
            matrix[:, row, column] = value
        return matrix[:, :, :-1], matrix[:, :, -1]
