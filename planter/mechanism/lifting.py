"""Contacts that would have to pull: where they do, between samples too."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planter.kernels import Array
from planter.mechanism.model import Model
from planter.mechanism.results import Warned
from planter.numerics import extremes
from planter.numerics.arrays import Flags

CLOSE = 1e-10
"""How close the angle of a change is looked for [rad]."""


def warnings(model: Model, angles: Array, found: dict[str, Array], repeats: bool = True) -> list[Warned]:
    """A warning for every stretch of a turn in which a contact would have to pull.

    `angles` (n,) [rad] go once round in equal steps, `found` are the results there; `repeats` says whether the turn
    ends as it began. A stretch between two samples is found where the force has a hollow there.
    """
    pushing = [quantity.name for quantity in model.machine.quantities if quantity.is_push]
    return [warned for name in pushing for warned in _warned(model, name, angles, found[name], repeats)]


def _warned(model: Model, name: str, angles: Array, values: Array, repeats: bool) -> Iterator[Warned]:
    lowest = extremes.least(lambda at: model(at)[name], angles, closed=repeats)
    if lowest.value >= 0:
        return
    what = f"{name} ({model.machine.find_quantity(name).meaning}) falls to {lowest.value:.4g} N"
    places = np.append(angles, lowest.place % model.machine.turn)
    order = np.argsort(places)
    places, pulls = places[order], np.append(values, lowest.value)[order] < 0
    if pulls.all():
        yield _told(f"{what}: the contact would have to pull all over the turn", 0.0)
        return
    for low, high in _stretches(model, name, places, pulls, repeats):
        yield _told(
            f"{what}: the contact would have to pull from {low:.6g} to {high:.6g} deg, so it lifts off there and "
            "nothing told beyond holds",
            low,
        )


def _stretches(model: Model, name: str, places: Array, pulls: Flags, repeats: bool) -> Iterator[tuple[float, float]]:
    """Where stretches of places that pull begin and end [deg]; one may pass the end of a turn that repeats."""
    before = np.roll(pulls, 1)
    before[0] &= repeats
    for begin in np.flatnonzero(pulls & ~before).tolist():
        length = int(np.argmin(np.append(pulls[begin:], pulls[:begin] if repeats else False)))
        low = 0.0 if begin == 0 and not repeats else np.degrees(_change(model, name, places, begin))
        ends = begin + length == len(places) and not repeats
        yield low, np.degrees(model.machine.turn if ends else _change(model, name, places, begin + length))


def _change(model: Model, name: str, places: Array, k: int) -> float:
    """Return the angle in a cycle at which the force changes sign between a place and the one before it, all round."""
    from scipy.optimize import brentq

    turn, high, low = model.machine.turn, float(places[k % len(places)]), float(places[(k - 1) % len(places)])
    found = brentq(lambda at: float(model(np.array([at]))[name][0]), low - turn * (low > high), high, xtol=CLOSE)
    return float(found) % turn


def _told(message: str, angle: float) -> Warned:
    return Warned(name="contact_would_pull", angle_deg=float(angle), message=message)
