"""`planter move`: a mechanism that moves by itself, over a time: every result, energies, what the constraints are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.mechanism.dynamics import Dynamics


@dataclass(frozen=True)
class Motion:
    """A motion in shown units: times (n,) [s] and columns (n,) by key, what is read from them, eigenvalues if asked."""

    machine: str
    times: Array
    columns: dict[str, Array]
    meanings: dict[str, str]
    redundant: int
    energy_J: dict[str, float]
    equilibrium: dict[str, float] | None = None
    eigenvalues: list[tuple[float, float]] | None = None

    def table(self) -> dict[str, Any]:
        """As JSON has it: of each quantity its extremes and its last value."""
        quantities = {
            key: {"unit": units.unit(key), "min": float(v.min()), "max": float(v.max()), "last": float(v[-1])}
            for key, v in self.columns.items()
        }
        rest = (
            {} if self.equilibrium is None else {"equilibrium": self.equilibrium, "eigenvalues_per_s": self.eigenvalues}
        )
        return {
            "machine": self.machine,
            "until_s": float(self.times[-1]),
            "quantities": quantities,
            "energy": self.energy_J,
            "redundant_constraints": self.redundant,
            **rest,
        }


def move(dynamics: Dynamics, until: float, points: int, tolerance: float, rest: bool = False) -> Motion:
    """The motion from the start to a time [s] at equal steps; with `rest` also a state of rest and its eigenvalues."""
    run = dynamics.run(np.linspace(0.0, until, points), tolerance)
    state = dict(zip(dynamics.names, run.states, strict=True))
    vectors = dynamics.formulas.sidecar["vectors"]
    known = [*vectors["start_state"], *vectors["outputs"]]
    columns: dict[str, Array] = {}
    for entry in known:
        key = units.key(entry["name"], entry["unit"])
        columns[key] = (state | run.results)[entry["name"]] / units.factor(key)
    return Motion(
        machine=dynamics.file.name,
        times=run.times,
        columns=columns,
        meanings={units.key(entry["name"], entry["unit"]): entry["meaning"] for entry in known},
        redundant=dynamics.redundant(run.states[:, 0]),
        energy_J=_energy(run.results),
        **(_rest(dynamics) if rest else {}),
    )


def _energy(results: dict[str, Array]) -> dict[str, float]:
    """Energy of weights, springs and motion at the start, and by how much it moves; loads and dampers move it too."""
    total = results["kinetic"] + results["potential"]
    return {"start_J": float(total[0]), "least_J": float(total.min()), "most_J": float(total.max())}


def _rest(dynamics: Dynamics) -> dict[str, Any]:
    at = dynamics.equilibrium()
    entries = dynamics.formulas.sidecar["vectors"]["start_state"][: dynamics.size]
    keys = [units.key(entry["name"], entry["unit"]) for entry in entries]
    shown = {key: float(value / units.factor(key)) for key, value in zip(keys, at, strict=False)}
    found = dynamics.eigenvalues(at)
    return {"equilibrium": shown, "eigenvalues": [(float(one.real), float(one.imag)) for one in found]}
