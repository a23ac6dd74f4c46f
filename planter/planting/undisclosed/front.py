"""What range and variance the exact model can give within the stated bounds, beside the figures of a paper's table.

Found by search over all laws of the cam's flanks, kept with a key of all that it rests on, and sought anew where that
has changed. `python -m planter.planting.undisclosed` renews what is kept.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from itertools import product
from typing import Any

import numpy as np

from planter.kernels import Array, generated
from planter.planting import functions
from planter.planting.file import Machine, load
from planter.planting.model import Device
from planter.planting.undisclosed.attainable import Reached, largest_range, most_variance
from planter.planting.undisclosed.force import Force
from planter.planting.undisclosed.inputs import Inputs, data
from planter.progress import Listener, ProgressPhase

KEPT = "front.json"
SEED, STARTS = 0, 3
"""Random starts of each search; it also starts from the best points of the caps and of the contact before."""
STRETCHED = 24
"""Random starts of the searches for the largest range."""
CAPS = (60.0, 200.0, 300.0, 1e4)
"""Caps on the range [N]; those of the paper's table come besides, and the last one is none."""
CONTACTS = {"cam pushing": True, "free sign": False}
Kept = dict[str, Any]


def front(name: str, own: Mapping[str, Mapping[str, float]], progress: Listener | None = None) -> Kept:
    """The front of a built-in machine with some points of a paper, by name: each with `range_N`, `variance_N2`.

    Read, if it rests on what is there now; else sought, which takes some minutes.
    """
    machine = load(name)
    rests_on = key(machine, own)
    found = kept()
    if found is None or found["key"] != rests_on:
        found = {"key": rests_on, **sought(machine, own, progress)}
    return found


def kept() -> Kept | None:
    """What is kept, if anything is."""
    place = files("planter.planting.undisclosed").joinpath(KEPT)
    return json.loads(place.read_text(encoding="utf-8")) if place.is_file() else None


def key(machine: Machine, own: Mapping[str, Mapping[str, float]]) -> str:
    """A hash of the machine, the bounds, the generated code and the settings of the search."""
    names = ["planting_exact", *map(functions.find_flank_module, functions.list_flank_laws()),
             *(f"curve_{stage.family}" for stage in (machine.stage1, machine.stage2))]  # fmt: skip
    codes = [generated.text(module) for module in names]
    parts = [machine.table(), data()["bounds"], own, codes, [SEED, STARTS, STRETCHED, CAPS]]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def sought(machine: Machine, own: Mapping[str, Mapping[str, float]], progress: Listener | None = None) -> Kept:
    """The most variance within each cap on the range, of all laws, with the cam only pushing and with a free sign."""
    caps = sorted({*CAPS, *(point["range_N"] for point in own.values())})
    phase = ProgressPhase("front", "search", len(functions.list_flank_laws()) * len(CONTACTS) * len(caps), progress)
    searches = [Searches(_with_flank(machine, law)) for law in functions.list_flank_laws()]
    points: dict[str, list[Kept]] = {contact: [] for contact in CONTACTS}
    for cap, (contact, pushing) in product(caps, CONTACTS.items()):
        best: tuple[Reached, Searches] | None = None
        for search in searches:
            reached = search.best(cap, pushing)
            if reached is not None and (best is None or reached.variance > best[0].variance):
                best = reached, search
            phase.advance(f"{contact}, range up to {cap:g} N")
        if best is not None:
            points[contact].append({"cap_N": cap, **best[1].told(best[0])})
    points["free sign"] += points["cam pushing"]
    fronts = [
        {"contact": contact, "points": list(_kept(found)), "largest_range": longest(searches, CONTACTS[contact])}
        for contact, found in points.items()
    ]
    table = [
        {"name": name, **point, "most_variance_N2": {c: _at(points[c], point["range_N"]) for c in points}}
        for name, point in own.items()
    ]
    return {"machine": machine.name, "model": "exact", "bounds": data()["bounds"], "fronts": fronts, "table": table}


def longest(searches: Sequence[Searches], pushing: bool) -> Kept | None:
    """The point of the largest range that any law was found to give."""
    found = [(reached.range, search.told(reached)) for search in searches if (reached := search.longest(pushing))]
    return max(found, key=lambda pair: pair[0])[1] if found else None


class Searches:
    """Searches with one law: each starts at random, and from the best points of those before."""

    def __init__(self, machine: Machine) -> None:
        device = Device(machine, "exact")
        self.law, self.force = machine.cam.flank, Force(device, Inputs.wide(device))
        self._rng = np.random.default_rng(SEED)
        self._last: list[Array] = []

    def best(self, cap: float, pushing: bool) -> Reached | None:
        random = [self._rng.random(len(self.force.inputs)) for _ in range(STARTS)]
        found = most_variance(self.force, cap, pushing, [*random, *self._last])
        if found is not None:
            self._last = [found.z, *self._last[:1]]
        return found

    def longest(self, pushing: bool) -> Reached | None:
        """The point of the largest range that was found."""
        rng = np.random.default_rng(SEED)
        return largest_range(self.force, pushing, [rng.random(len(self.force.inputs)) for _ in range(STRETCHED)])

    def told(self, reached: Reached) -> Kept:
        rows = self.force.inputs.table(reached.z)
        return {"range_N": reached.range, "variance_N2": reached.variance, "least_push_N": reached.push,
                "flank": self.law, "inputs": {row["name"]: row["value"] for row in rows}}  # fmt: skip


def _kept(points: Sequence[Kept]) -> Iterator[Kept]:
    """Points in order of range, without those that give less variance than one before."""
    most = -1.0
    for point in sorted(points, key=lambda one: one["range_N"]):
        if point["variance_N2"] > most:
            most = point["variance_N2"]
            yield point


def _at(points: Sequence[Kept], cap: float) -> float | None:
    """The most variance within a cap on the range."""
    return max((p["variance_N2"] for p in points if p["cap_N"] <= cap), default=None)


def _with_flank(machine: Machine, law: str) -> Machine:
    table = machine.table()
    return Machine.read({**table, "cam": {**table["cam"], "flank": law}}, machine.source)
