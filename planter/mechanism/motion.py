"""`planter move`: a mechanism that moves by itself, over a time: every result, energies, rest and small motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.results import ChangedStart, Course, Energy
from planter.mechanism.results import Motion as Result
from planter.mechanism.small import eigenvalues, equilibrium


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
