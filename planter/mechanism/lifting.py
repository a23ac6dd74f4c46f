"""Contacts that would have to pull: where they do, between samples too."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planter.kernels import Array
from planter.mechanism.model import Model
from planter.mechanism.results import Warned
from planter.numerics import extremes

CLOSE = 1e-10
"""How close the angle of a change is looked for [rad]."""


def warnings(model: Model, angles: Array, found: dict[str, Array]) -> list[Warned]:
    """A warning for every stretch of a turn in which a contact would have to pull.

    `angles` (n,) [rad] go once round in equal steps, `found` are the results there. A stretch between two samples is
    found where the force has a hollow there.
    """
    return [warned for name in model.pushing for warned in _warned(model, name, angles, found[name])]


def _warned(model: Model, name: str, angles: Array, values: Array) -> Iterator[Warned]:
    lowest = extremes.least(lambda at: model(at)[name], angles, closed=True)
    if lowest.value >= 0:
        return
    meaning = next(entry["meaning"] for entry in model.outputs if entry["name"] == name)
    what = f"{name} ({meaning}) falls to {lowest.value:.4g} N"
    places = np.append(angles, lowest.place % (2 * np.pi))
    order = np.argsort(places)
    places, pulls = places[order], np.append(values, lowest.value)[order] < 0
    if pulls.all():
        yield _told(f"{what}: the contact would have to pull all over the turn", 0.0)
    for begin in np.flatnonzero(pulls & ~np.roll(pulls, 1)):
        end = int(begin + np.argmin(np.roll(pulls, -begin)))
        low, high = (np.degrees(_change(model, name, places, k)) for k in (int(begin), end))
        yield _told(
            f"{what}: the contact would have to pull from {low:.6g} to {high:.6g} deg, so it lifts off there and "
            "nothing told beyond holds",
            low,
        )


def _change(model: Model, name: str, places: Array, k: int) -> float:
    """The angle in [0, 2 pi) at which the force changes sign between a place and the one before it, round the turn."""
    from scipy.optimize import brentq

    high = float(places[k % len(places)])
    low = float(places[(k - 1) % len(places)])
    found = brentq(lambda at: float(model(np.array([at]))[name][0]), low - 2 * np.pi * (low > high), high, xtol=CLOSE)
    return float(found) % (2 * np.pi)


def _told(message: str, angle: float) -> Warned:
    return Warned(name="contact_would_pull", angle_deg=float(angle), message=message)
