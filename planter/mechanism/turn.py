"""`planter turn`: every quantity of a mechanism over a turn, the works, and the laws that it must obey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.mechanism import lifting
from planter.mechanism.model import LAW, PIVOTS, STATES, Model, component_axes
from planter.mechanism.optimisation import evaluate_limits
from planter.mechanism.periodicity import Periodicity, periodicity
from planter.mechanism.results import Law, Quantity
from planter.mechanism.results import Turn as Result
from planter.numerics.angles import turn_deg
from planter.numerics.extremes import first_extreme


@dataclass(frozen=True)
class Turn:
    """A turn: samples of all results in shown units (n,) by key, with their meanings, and what is read from them.

    `ends` are the results at the end of the turn by key; `places` (n,) [m] are those of the bodies' points; a turn
    takes `seconds`.
    """

    angle: str
    angles_deg: Array
    columns: dict[str, Array]
    ends: dict[str, float]
    meanings: dict[str, str]
    places: dict[str, Array]
    seconds: float
    result: Result

    @property
    def repeats(self) -> bool:
        """Whether it ends in the state in which it began."""
        return not self.result.not_repeating


def turn(model: Model, samples: int | None = None) -> Turn:
    """A turn of a mechanism in `samples` equal steps, the file's own unless told.

    Means are those of the samples, by the trapezoidal rule where an angle gains whole turns; works [J] integrate what
    is told in W over the time of a turn. What does not end the turn as it began has neither, and a warning says so.
    Raises ComputationError as the model does.
    """
    count = model.file.turn.samples if samples is None else samples
    angles = 2 * np.pi * np.arange(count) / count
    found = model(angles)
    told = [entry for entry in model.outputs if not entry["name"].startswith((LAW, PIVOTS, STATES))]
    keys = {entry["name"]: units.key(entry["name"], entry["unit"]) for entry in told}
    columns = {key: found[name] / units.factor(key) for name, key in keys.items()}
    axes = {keys[name]: frame for name, frame in component_axes(model.formulas).items() if name in keys}
    degrees, repeats = np.degrees(angles), periodicity(model, angles, found)
    holds = evaluate_limits(model.file, repeats.changes) if model.file.limits else None
    ends = {keys[name]: value / units.factor(keys[name]) for name, value in repeats.end.items()}
    result = Result(
        machine=model.file.name,
        samples=count,
        quantities={
            key: describe_quantity(key, values, angles, ends.get(key), repeats, axes.get(key))
            for key, values in columns.items()
        },
        work=_works(model, found, repeats),
        laws=_laws(model, found),
        warnings=[*repeats.warnings(), *lifting.warnings(model, angles, found, not repeats.changes)],
        repeats_after_turns=repeats.turns,
        not_repeating=repeats.changes,
        holds=holds,
        met=None if holds is None else all(hold.met for hold in holds),
    )
    meanings = {keys[entry["name"]]: entry["meaning"] for entry in told}
    seconds = 2 * np.pi / abs(model.speed) if model.speed else np.inf
    return Turn(model.angle, degrees, columns, ends, meanings, model.places(angles), seconds, result)


def describe_quantity(
    key: str, values: Array, angles: Array, end: float | None, repeats: Periodicity, axes: str | None
) -> Quantity:
    """Return extremes, mean and root mean square of samples (n,) of a cycle at angles (n,) [rad]."""
    low, high = (turn_deg(float(angles[first_extreme(angles, values, sign)])) for sign in (-1, 1))
    mean, square = (None, None) if key in repeats.changes or end is None else _means(values, end)
    return Quantity(
        unit=units.unit(key),
        min=float(values.min()),
        max=float(values.max()),
        mean=mean,
        rms=None if square is None else float(np.sqrt(square)),
        min_deg=low,
        max_deg=high,
        axes=axes,
    )


def _means(values: Array, end: float) -> tuple[float, float]:
    """Mean and mean square of values (n,) by the trapezoidal rule with the value at the end of the turn.

    Only an angle that gains whole turns ends elsewhere than it began; otherwise the rule is the mean of the samples.
    """
    gains = abs(end - values[0]) > 1.0
    last = (end - values[0], end**2 - values[0] ** 2) if gains else (0.0, 0.0)
    count = len(values)
    return float(values.mean() + last[0] / (2 * count)), float((values**2).mean() + last[1] / (2 * count))


def _works(model: Model, found: dict[str, Array], repeats: Periodicity) -> dict[str, float | None]:
    """Work [J] of each power over the time of a turn; None where it does not repeat."""
    if model.speed == 0:
        return {}
    period = 2 * np.pi / abs(model.speed)
    powers = [entry["name"] for entry in model.outputs if entry["unit"] == "W" and not entry["name"].startswith(LAW)]
    return {
        f"{name.removeprefix('P_')}_J": None
        if units.key(name, "W") in repeats.changes
        else period * float(found[name].mean())
        for name in powers
    }


def _laws(model: Model, found: dict[str, Array]) -> list[Law]:
    """The laws of mechanics, and that friction has one state alone."""
    laws = [
        Law(entry["meaning"], float(np.abs(found[entry["name"]]).max()), entry["unit"])
        for entry in model.outputs
        if entry["name"].startswith(LAW)
    ]
    many = [entry for entry in model.outputs if entry["name"].startswith(STATES)]
    return laws + [Law(f"{e['meaning']}, beyond one", float(found[e["name"]].max()) - 1, "1") for e in many]
