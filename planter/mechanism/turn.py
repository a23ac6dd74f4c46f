"""`planter turn`: every quantity of a mechanism over a turn, the works, and the laws that it must obey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.mechanism import lifting
from planter.mechanism.model import LAW, PIVOTS, STATES, Model
from planter.mechanism.results import Law, Quantity
from planter.mechanism.results import Turn as Result


@dataclass(frozen=True)
class Turn:
    """A turn: samples of all results in shown units (n,) by key, with their meanings, and what is read from them.

    `places` (n,) [m] are those of the bodies' points; a turn takes `seconds`.
    """

    angle: str
    angles_deg: Array
    columns: dict[str, Array]
    meanings: dict[str, str]
    places: dict[str, Array]
    seconds: float
    result: Result


def turn(model: Model, samples: int | None = None) -> Turn:
    """A turn of a mechanism in `samples` equal steps, the file's own unless told.

    Means are those of the samples; works [J] integrate what is told in W over the time of a turn. Raises
    ComputationError as the model does.
    """
    count = model.file.turn.samples if samples is None else samples
    angles = 2 * np.pi * np.arange(count) / count
    found = model(angles)
    told = [entry for entry in model.outputs if not entry["name"].startswith((LAW, PIVOTS, STATES))]
    keys = {entry["name"]: units.key(entry["name"], entry["unit"]) for entry in told}
    columns = {key: found[name] / units.factor(key) for name, key in keys.items()}
    degrees = np.degrees(angles)
    result = Result(
        machine=model.file.name,
        samples=count,
        quantities={key: _quantity(key, values, degrees) for key, values in columns.items()},
        work=_works(model, found),
        laws=_laws(model, found),
        warnings=lifting.warnings(model, angles, found),
    )
    meanings = {keys[entry["name"]]: entry["meaning"] for entry in told}
    seconds = 2 * np.pi / abs(model.speed) if model.speed else np.inf
    return Turn(model.angle, degrees, columns, meanings, model.places(angles), seconds, result)


def _quantity(key: str, values: Array, degrees: Array) -> Quantity:
    low, high = int(np.argmin(values)), int(np.argmax(values))
    return Quantity(
        unit=units.unit(key),
        min=float(values[low]),
        max=float(values[high]),
        mean=float(values.mean()),
        rms=float(np.sqrt((values**2).mean())),
        min_deg=float(degrees[low]),
        max_deg=float(degrees[high]),
    )


def _works(model: Model, found: dict[str, Array]) -> dict[str, float]:
    if model.speed == 0:
        return {}
    period = 2 * np.pi / abs(model.speed)
    powers = [entry["name"] for entry in model.outputs if entry["unit"] == "W" and not entry["name"].startswith(LAW)]
    return {f"{name.removeprefix('P_')}_J": period * float(found[name].mean()) for name in powers}


def _laws(model: Model, found: dict[str, Array]) -> list[Law]:
    """The laws of mechanics, and that friction has one state alone."""
    laws = [
        Law(entry["meaning"], float(np.abs(found[entry["name"]]).max()), entry["unit"])
        for entry in model.outputs
        if entry["name"].startswith(LAW)
    ]
    many = [entry for entry in model.outputs if entry["name"].startswith(STATES)]
    return laws + [Law(f"{e['meaning']}, beyond one", float(found[e["name"]].max()) - 1, "1") for e in many]
