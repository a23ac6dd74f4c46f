"""`planter turn`: every quantity of a mechanism over a turn, the works, and the laws that it must obey."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.mechanism.model import Model

LAW = "law_"
HIDDEN = (LAW, "pivot_")
"""Beginnings of names that say how sound the results are, and are no results themselves."""


@dataclass(frozen=True)
class Quantity:
    """A result over a turn, in its shown unit: extremes with their angles [deg], mean, root mean square."""

    unit: str
    min: float
    max: float
    mean: float
    rms: float
    min_deg: float
    max_deg: float


@dataclass(frozen=True)
class Law:
    """A law of mechanics, and the largest amount by which the results break it."""

    law: str
    violation: float
    unit: str


@dataclass(frozen=True)
class Turn:
    """A turn: samples of all results in shown units (n,) by key, and what is read from them."""

    machine: str
    angle: str
    angles_deg: Array
    columns: dict[str, Array]
    meanings: dict[str, str]
    quantities: dict[str, Quantity]
    work: dict[str, float]
    laws: list[Law]

    def table(self) -> dict[str, Any]:
        """As JSON has it."""
        return {
            "machine": self.machine,
            "samples": len(self.angles_deg),
            "quantities": {key: asdict(quantity) for key, quantity in self.quantities.items()},
            "work": self.work,
            "laws": [asdict(law) for law in self.laws],
        }


def turn(model: Model, samples: int | None = None) -> Turn:
    """A turn of a mechanism in `samples` equal steps, the file's own unless told.

    Means are those of the samples; works [J] integrate what is told in W over the time of a turn.
    """
    count = model.file.turn.samples if samples is None else samples
    angles = 2 * np.pi * np.arange(count) / count
    found = model(angles)
    columns: dict[str, Array] = {}
    meanings: dict[str, str] = {}
    for entry in model.outputs:
        if not entry["name"].startswith(HIDDEN):
            key = units.key(entry["name"], entry["unit"])
            columns[key] = found[entry["name"]] / units.factor(key)
            meanings[key] = entry["meaning"]
    degrees = np.degrees(angles)
    return Turn(
        machine=model.file.name,
        angle=model.angle,
        angles_deg=degrees,
        columns=columns,
        meanings=meanings,
        quantities={key: _quantity(key, values, degrees) for key, values in columns.items()},
        work=_works(model, found),
        laws=[
            Law(entry["meaning"], float(np.abs(found[entry["name"]]).max()), entry["unit"])
            for entry in model.outputs
            if entry["name"].startswith(LAW)
        ],
    )


def _quantity(key: str, values: Array, degrees: Array) -> Quantity:
    low, high = int(np.argmin(values)), int(np.argmax(values))
    return Quantity(
        units.unit(key), float(values[low]), float(values[high]), float(values.mean()),
        float(np.sqrt((values**2).mean())), float(degrees[low]), float(degrees[high]),
    )  # fmt: skip


def _works(model: Model, found: dict[str, Array]) -> dict[str, float]:
    """Works of a turn [J] by what does them."""
    period = 2 * np.pi / abs(model.speed)
    powers = [entry["name"] for entry in model.outputs if entry["unit"] == "W" and not entry["name"].startswith(LAW)]
    return {f"{name.removeprefix('P_')}_J": period * float(found[name].mean()) for name in powers}
