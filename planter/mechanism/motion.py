"""`planter move`: a mechanism that moves by itself, over a time: every result, energies, rest and small motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy.linalg
import scipy.optimize

from planter.errors import ComputationError, InputError
from planter.files import units
from planter.kernels import Array
from planter.mechanism.dynamics import Dynamics, independent
from planter.mechanism.results import ChangedStart, Course, Energy
from planter.mechanism.results import Motion as Result


@dataclass(frozen=True)
class Motion:
    """A motion: times (n,) [s], columns (n,) in shown units by key, with their meanings, what is read from them.

    `places` (n,) [m] are those of the bodies' points.
    """

    times: Array
    columns: dict[str, Array]
    meanings: dict[str, str]
    places: dict[str, Array]
    result: Result


def move(
    dynamics: Dynamics, until: float, points: int, tolerance: float, rest: bool = False, least: bool = False,
    stiff: bool = False,
) -> Motion:  # fmt: skip
    """The motion from the start to a time [s] at equal steps; with `rest` also a state of rest and its eigenvalues.

    With `stiff` the integrator is an implicit one. With `least` actions that the balances leave undetermined are those
    of least squares; without they are not told.
    Raises ComputationError as `Dynamics` does.
    """
    run = dynamics.run(np.linspace(0.0, until, points), tolerance, least=least, stiff=stiff)
    vectors = dynamics.formulas.sidecar["vectors"]
    values = dict(zip(dynamics.names, run.states, strict=True)) | run.results
    told = [entry for entry in (*vectors["start_state"], *vectors["outputs"]) if entry["name"] in values]
    keys = {entry["name"]: units.key(entry["name"], entry["unit"]) for entry in told}
    columns = {key: values[name] / units.factor(key) for name, key in keys.items()}
    axes = {keys[name]: frame for name, frame in dynamics.formulas.sidecar.get("axes", {}).items() if name in keys}
    result = Result(
        machine=dynamics.file.name,
        until_s=until,
        quantities={key: _course(key, column, axes.get(key)) for key, column in columns.items()},
        energy=_energy(run.results),
        redundant_constraints=dynamics.redundant(run.states[:, 0]),
        dependent_constraints=dynamics.dependent(run.states[:, 0]),
        undetermined_actions=list(run.undetermined),
        changed_start=_changed(dynamics, run.states[:, 0]),
        **(_rest(dynamics) if rest else {}),
    )
    meanings = {keys[entry["name"]]: entry["meaning"] for entry in told}
    places = dynamics.formulas("places", time=run.times, data=dynamics.data, state=run.states)
    return Motion(run.times, columns, meanings, places, result)


def _changed(dynamics: Dynamics, start: Array) -> list[ChangedStart]:
    """What starts elsewhere than stated, in shown units."""
    entries, stated = dynamics.formulas.sidecar["vectors"]["start_state"], dynamics.stated
    found = []
    for place in dynamics.changed(start):
        key = units.key(entries[place]["name"], entries[place]["unit"])
        ends = (float(state[place] / units.factor(key)) for state in (stated, start))
        found.append(ChangedStart(key, units.unit(key), *ends))
    return found


def _course(key: str, values: Array, axes: str | None) -> Course:
    return Course(units.unit(key), float(values.min()), float(values.max()), float(values[-1]), axes)


def _energy(results: dict[str, Array]) -> Energy:
    total = results["kinetic"] + results["potential"]
    return Energy(float(total[0]), float(total.min()), float(total.max()))


def _rest(dynamics: Dynamics) -> dict[str, Any]:
    at = equilibrium(dynamics)
    entries = dynamics.formulas.sidecar["vectors"]["start_state"][: dynamics.size]
    keys = [units.key(entry["name"], entry["unit"]) for entry in entries]
    shown = {key: float(value / units.factor(key)) for key, value in zip(keys, at, strict=False)}
    found = eigenvalues(dynamics, at)
    return {"equilibrium": shown, "eigenvalues_per_s": [(float(one.real), float(one.imag)) for one in found]}


AT_REST = 1e-8
"""Forces and gaps below this, in SI units, vanish."""


@dataclass(frozen=True)
class Linear:
    """inertia b' + damping b + stiffness a = 0,  a' = speeds b + drift a:  small motions about a steady one.

    Rates are ways b (r,), places are turns a (p,): free directions of each, columns of ``rates`` (k, r), ``places``.
    """

    inertia: Array
    damping: Array
    stiffness: Array
    speeds: Array
    drift: Array

    def eigenvalues(self) -> Array:
        """Eigenvalues (r + p,) [1/s], by falling real part."""
        pulls = -np.linalg.solve(self.inertia, np.hstack([self.stiffness, self.damping]))
        found = scipy.linalg.eigvals(np.vstack([np.hstack([self.drift, self.speeds]), pulls]))
        return found[np.lexsort((-found.imag, -found.real))]


def equilibrium(dynamics: Dynamics, state: Array | None = None) -> Array:
    """A state of rest (2k,) near one, the start unless told. Raises ComputationError where none is found."""
    at = dynamics.start() if state is None else state
    here = dynamics.equations(0.0, at)
    size, count = dynamics.size, len(here.gaps)
    pulls = np.linalg.lstsq(here.slopes[:count].T, -here.forces, rcond=None)[0]

    def residual(x: Array) -> Array:
        now = dynamics.equations(0.0, np.concatenate([x[:size], np.zeros(size)]))
        return np.concatenate([now.forces + now.slopes[:count].T @ x[size:], now.gaps])

    first = np.concatenate([at[:size], pulls])
    found = scipy.optimize.least_squares(residual, first, xtol=1e-15, ftol=None, gtol=None)
    if np.abs(found.fun).max() > AT_REST:
        raise ComputationError(f"{dynamics.file.name}: no state of rest is found near the given one")
    return np.concatenate([found.x[:size], np.zeros(size)])


def linear(
    dynamics: Dynamics, state: Array, rates: Sequence[str] | None = None, places: Sequence[str] | None = None,
    time: float = 0.0,
) -> Linear:  # fmt: skip
    """Small motions about a state of rest or steady motion, in which the linearised equations do not change.

    ``rates`` name as many coordinates as move freely: the ways b are their rates; ``places`` those whose values the
    turns a are. Unless told both are orthonormal. Raises InputError where the names do not determine the motion.
    """
    slopes, by_place, by_rate, shift, inertia, held = _derivatives(dynamics, time, state)
    names, kept = dynamics.names[: dynamics.size], independent(slopes)
    gaps = kept[kept < held]
    ways = _basis(slopes[kept], names, rates)
    turns = _basis(slopes[gaps], names, places)
    carried = -np.linalg.pinv(slopes[kept]) @ shift[kept] @ turns if len(kept) else np.zeros_like(turns)
    if rates is not None:
        carried -= ways @ carried[[names.index(name) for name in rates]]
    back = np.linalg.pinv(turns)
    speeds, drift = back @ ways, back @ carried
    weighed = ways.T @ inertia
    return Linear(
        inertia=weighed @ ways,
        damping=weighed @ carried @ speeds - ways.T @ by_rate @ ways,
        stiffness=weighed @ carried @ drift - ways.T @ (by_place @ turns + by_rate @ carried),
        speeds=speeds,
        drift=drift,
    )


def eigenvalues(dynamics: Dynamics, state: Array, time: float = 0.0) -> Array:
    """Eigenvalues (m,) [1/s] of small motions about a state of rest or steady motion, by falling real part."""
    return linear(dynamics, state, time=time).eigenvalues()


def _derivatives(dynamics: Dynamics, time: float, state: Array) -> tuple[Array, Array, Array, Array, Array, int]:
    """Slopes; the forces' derivatives by place and by rate; the speeds' by place; inertia; the number of gaps."""
    acceleration, multipliers = dynamics.accelerations(time, state)
    symbol, k = ca.SX.sym("state", 2 * dynamics.size), dynamics.size
    inertia, forces, slopes, _, speeds, gaps = dynamics.function(time, symbol)
    force = forces + slopes.T @ multipliers - inertia @ acceleration
    parts = [slopes, ca.jacobian(force, symbol), ca.jacobian(speeds, symbol), inertia]
    rows, by_state, by_speed, mass = (
        np.array(part) for part in ca.Function("about", [symbol], list(map(ca.densify, parts)))(state)
    )
    return rows, by_state[:, :k], by_state[:, k:], by_speed[:, :k], mass, gaps.numel()


def _basis(slopes: Array, names: Sequence[str], free: Sequence[str] | None) -> Array:
    """Columns that keep the slopes' rows at zero: orthonormal, or with the free coordinates' own entries those of one.

    Raises InputError where the free coordinates do not determine the others.
    """
    if free is None:
        return scipy.linalg.null_space(slopes) if len(slopes) else np.eye(len(names))
    chosen = [names.index(name) for name in free]
    rest = [i for i in range(len(names)) if i not in chosen]
    if len(rest) != len(slopes) or np.linalg.cond(slopes[:, rest]) > 1e12:
        raise InputError(f"{', '.join(free)} do not determine how the others of {', '.join(names)} move")
    found = np.zeros((len(names), len(chosen)))
    found[chosen] = np.eye(len(chosen))
    found[rest] = -np.linalg.solve(slopes[:, rest], slopes[:, chosen])
    return found
