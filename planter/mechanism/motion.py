"""Free motion of a mechanism over a time, its energy, its equilibria, and small vibrations about
them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import scipy

from planter.errors import ComputationError, InputError
from planter.files import units
from planter.kernels import Array
from planter.mechanism.dynamics import (
    Dynamics,
    MotionStep,
    describe_contradictions,
    find_independent_rows,
)
from planter.mechanism.file import MechanismFile
from planter.mechanism.results import (
    ChangedStart,
    MachineValidation,
    MechanismEnergy,
    MechanismWarning,
    MotionEvent,
    MotionResult,
    QuantityHistory,
)


@dataclass(frozen=True)
class MechanismMotion:
    """A motion: times (n,) [s], columns (n,) in display units by key with their meanings, and its
    result.

    `places` (n,) [m] are coordinates of the bodies' points, `shapes` (n,) [SI] what its springs and
    guides are drawn from.
    """

    times: Array
    columns: dict[str, Array]
    meanings: dict[str, str]
    places: dict[str, Array]
    result: MotionResult
    shapes: Mapping[str, Array] = field(default_factory=dict)


def compute_motion(
    dynamics: Dynamics,
    until: float,
    points: int,
    tolerance: float,
    rest: bool = False,
    minimum_norm: bool = False,
    stiff: bool = False,
    steps: list[MotionStep] | None = None,
) -> MechanismMotion:
    """Return the motion from the start to a time [s] in equal steps; with `rest` also an
    equilibrium with eigenvalues.

    `stiff` takes an implicit integrator. `minimum_norm` reports statically indeterminate reactions
    by least squares; results lack them otherwise. `steps` take those of the integrator, if there
    are any to be taken. Raises ComputationError as `Dynamics` does.
    """
    times = np.linspace(0.0, until, points)
    run = dynamics.run(times, tolerance, dynamics.find_start(), minimum_norm, stiff, steps)
    vectors = dynamics.formulas.sidecar["vectors"]
    values = dict(zip(dynamics.names, run.states, strict=True)) | run.results
    entries = [
        entry for entry in (*vectors["start_state"], *vectors["outputs"]) if entry["name"] in values
    ]
    keys = units.display_keys(entries)
    columns = {key: values[name] / units.unit_factor(key) for name, key in keys.items()}
    axes = {
        keys[name]: frame
        for name, frame in dynamics.formulas.sidecar.get("axes", {}).items()
        if name in keys
    }
    total = run.results["kinetic"] + run.results["potential"]
    result = MotionResult(
        machine=dynamics.file.name,
        until_s=until,
        quantities={
            key: QuantityHistory(
                units.display_unit(key),
                float(column.min()),
                float(column.max()),
                float(column[-1]),
                axes.get(key),
            )
            for key, column in columns.items()
        },
        energy=MechanismEnergy(float(total[0]), float(total.min()), float(total.max())),
        redundant_constraints=dynamics.redundant(run.states[:, 0]),
        dependent_constraints=dynamics.dependent(run.states[:, 0]),
        undetermined_actions=list(run.undetermined),
        changed_start=list_start_changes(dynamics),
        events=[
            MotionEvent(passage.event, passage.time, passage.rising)
            for passage in run.events
            if passage.event in dynamics.event_names
        ],
        **(_describe_equilibrium(dynamics) if rest else {}),
    )
    meanings = {keys[entry["name"]]: entry["meaning"] for entry in entries}
    at = {"time": run.times, "data": dynamics.data_at(run.times), "state": run.states}
    has_shapes = "elements" in dynamics.formulas.sidecar["functions"]
    return MechanismMotion(
        run.times,
        columns,
        meanings,
        dynamics.formulas("places", **at),
        result,
        shapes=dynamics.formulas("elements", **at) if has_shapes else {},
    )


def list_start_changes(dynamics: Dynamics) -> list[ChangedStart]:
    """Return the entries of the initial state that differ from the stated ones, in display
    units.
    """
    entries, stated, start = (
        dynamics.formulas.sidecar["vectors"]["start_state"],
        dynamics.stated,
        dynamics.find_start(),
    )
    changes = []
    for index in dynamics.find_changes(start):
        key = units.display_key(entries[index]["name"], entries[index]["unit"])
        ends = (float(state[index] / units.unit_factor(key)) for state in (stated, start))
        changes.append(ChangedStart(key, units.display_unit(key), *ends))
    return changes


def _describe_equilibrium(dynamics: Dynamics) -> dict[str, Any]:
    state = equilibrium(dynamics)
    entries = dynamics.formulas.sidecar["vectors"]["start_state"][: dynamics.size]
    keys = units.display_keys(entries).values()
    values = {
        key: float(value / units.unit_factor(key)) for key, value in zip(keys, state, strict=False)
    }
    roots = [(float(root.real), float(root.imag)) for root in eigenvalues(dynamics, state)]
    return {"equilibrium": values, "eigenvalues_per_s": roots}


EQUILIBRIUM_TOLERANCE = 1e-8
"""Largest remaining force or gap of an equilibrium, in SI units, of forces of up to 1; of larger
ones that share.
"""
MOST_CONDITION = 1e12
"""Largest condition number of the constraints in the dependent coordinates."""


@dataclass(frozen=True)
class LinearisedMotion:
    """Small vibrations about a steady motion: inertia b' + damping b + stiffness a = 0,  a' =
    speeds b + drift a.

    b (r,) are independent rates and a (p,) independent displacements: columns of ``rates`` (k, r)
    and ``places``.
    """

    inertia: Array
    damping: Array
    stiffness: Array
    speeds: Array
    drift: Array

    def eigenvalues(self) -> Array:
        """Return the eigenvalues (r + p,) [1/s] by decreasing real part."""
        lower = -np.linalg.solve(self.inertia, np.hstack([self.stiffness, self.damping]))
        roots = scipy.linalg.eigvals(np.vstack([np.hstack([self.drift, self.speeds]), lower]))
        return roots[np.lexsort((-roots.imag, -roots.real))]


def equilibrium(dynamics: Dynamics, state: Array | None = None) -> Array:
    """Return an equilibrium (2k,) near a state, the start unless one is given.

    Raises ComputationError if no equilibrium is nearby.
    """
    start = dynamics.find_start() if state is None else state
    initial = dynamics.equations(0.0, start)
    size, count = dynamics.size, len(initial.gaps)
    multipliers = np.linalg.lstsq(initial.slopes[:count].T, -initial.forces, rcond=None)[0]

    def residual(x: Array) -> Array:
        now = dynamics.equations(0.0, np.concatenate([x[:size], np.zeros(size)]))
        return np.concatenate([now.forces + now.slopes[:count].T @ x[size:], now.gaps])

    first = np.concatenate([start[:size], multipliers])
    solution = scipy.optimize.least_squares(residual, first, method="lm", xtol=1e-15)
    if np.abs(solution.fun).max() > EQUILIBRIUM_TOLERANCE * np.abs(initial.forces).max(initial=1.0):
        raise ComputationError(
            f"{dynamics.file.name}: no equilibrium is found near the given state"
        )
    return np.concatenate([solution.x[:size], np.zeros(size)])


def linearise(
    dynamics: Dynamics,
    state: Array,
    rates: Sequence[str] | None = None,
    places: Sequence[str] | None = None,
    time: float = 0.0,
) -> LinearisedMotion:
    """Return small vibrations about an equilibrium or a steady motion, in which the linearised
    equations are constant.

    ``rates`` name the coordinates whose rates are independent, b; ``places`` those whose
    displacements are, a. Without names both are orthonormal. Raises InputError if the names do not
    determine the motion.
    """
    slopes, by_place, by_rate, shift, inertia, gap_count = _differentiate(dynamics, time, state)
    names, independent = dynamics.names[: dynamics.size], find_independent_rows(slopes)
    ways = _find_basis(slopes[independent], names, rates)
    displacements = _find_basis(slopes[independent[independent < gap_count]], names, places)
    carried = np.zeros_like(displacements)
    if len(independent):
        carried = -np.linalg.pinv(slopes[independent]) @ shift[independent] @ displacements
    if rates is not None:
        carried -= ways @ carried[[names.index(name) for name in rates]]
    back = np.linalg.pinv(displacements)
    speeds, drift = back @ ways, back @ carried
    projected = ways.T @ inertia
    return LinearisedMotion(
        inertia=projected @ ways,
        damping=projected @ carried @ speeds - ways.T @ by_rate @ ways,
        stiffness=projected @ carried @ drift
        - ways.T @ (by_place @ displacements + by_rate @ carried),
        speeds=speeds,
        drift=drift,
    )


def eigenvalues(dynamics: Dynamics, state: Array) -> Array:
    """Return eigenvalues (m,) [1/s] of small vibrations about an equilibrium, by decreasing real
    part.
    """
    return linearise(dynamics, state).eigenvalues()


def _differentiate(
    dynamics: Dynamics, time: float, state: Array
) -> tuple[Array, Array, Array, Array, Array, int]:
    """Return slopes; derivatives of forces by place and by rate, of speeds by place; inertia; the
    number of gaps.
    """
    acceleration, multipliers = dynamics.accelerations(time, state)
    sizes = dynamics.find_sizes(time, state)
    symbol, k = ca.SX.sym("state", 2 * dynamics.size), dynamics.size
    inertia, forces, slopes, _, speeds, gaps = dynamics.function(
        time, symbol, sizes, dynamics.history.at(time)
    )
    force = forces + slopes.T @ multipliers - inertia @ acceleration
    parts = [slopes, ca.jacobian(force, symbol), ca.jacobian(speeds, symbol), inertia]
    rows, by_state, by_speed, mass = (
        np.array(part)
        for part in ca.Function("about", [symbol], list(map(ca.densify, parts)))(state)
    )
    return rows, by_state[:, :k], by_state[:, k:], by_speed[:, :k], mass, gaps.numel()


def _find_basis(slopes: Array, names: Sequence[str], free: Sequence[str] | None) -> Array:
    """Return columns that the slopes' rows map to zero: orthonormal, or unit vectors in the free
    coordinates.

    Raises InputError if the free coordinates do not determine the others.
    """
    if free is None:
        return scipy.linalg.null_space(slopes) if len(slopes) else np.eye(len(names))
    chosen = [names.index(name) for name in free]
    rest = [i for i in range(len(names)) if i not in chosen]
    if len(rest) != len(slopes) or np.linalg.cond(slopes[:, rest]) > MOST_CONDITION:
        raise InputError(
            f"{', '.join(free)} do not determine how the others of {', '.join(names)} move"
        )
    basis = np.zeros((len(names), len(chosen)))
    basis[chosen] = np.eye(len(chosen))
    basis[rest] = -np.linalg.solve(slopes[:, rest], slopes[:, chosen])
    return basis


def validate_free_motion(mechanism: MechanismFile) -> MachineValidation:
    """Return the entries of a mechanism's initial state that its constraints change, as warnings.

    Raises ComputationError if no state near the stated one satisfies its constraints, InputError if
    none does while what is named to hold does.
    """
    dynamics = Dynamics(mechanism)
    stated, start, contradictions = (
        dynamics.stated,
        dynamics.find_start(),
        dynamics.find_contradictions(),
    )
    warnings = []
    for index in dynamics.find_changes(start):
        name = dynamics.names[index]
        message = f"the constraints change it from {stated[index]:.6g} to {start[index]:.6g} (SI)"
        if name in contradictions:
            message = describe_contradictions({name: contradictions[name]})
        warnings.append(MechanismWarning(name=name, message=message))
    numbers = mechanism.own_numbers()
    return MachineValidation(
        machine=mechanism.name, valid=True, design=[], own_numbers=numbers, warnings=warnings
    )
