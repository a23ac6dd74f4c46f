"""Attainable ranges and variances of the exact model's force: searches, and the Pareto front
compared with a paper.

The searches are L-BFGS-B with exact gradients from several starts, range and contact as growing
penalties. They are heuristic: known inputs attain every point of a front, and nothing proves that
no point lies beyond.

The front is searched for over all laws of the cam's flanks and saved with a key of all that it
depends on, where `planter audit wang2017 --front` finds it.
`python docs/studies/attainable_front.py` renews it, which takes some minutes.
"""

from __future__ import annotations

import ast
import hashlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from planter.kernels import Array, generated
from planter.papers.planting import functions
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.model import Device
from planter.papers.planting.printed import attainable
from planter.papers.planting.unpublished_inputs import (
    PUSH_MARGIN,
    SEARCH_UNIT,
    CalibrationForce,
    CalibrationInputs,
    load_calibration_data,
)
from planter.progress import Listener, ProgressPhase

PENALTIES = (0.1, 100.0)
"""Weights of violations against the variance: a small one first, which lets a search pass through
them.
"""
MAX_ITERATIONS = 200
SEED, STARTS = 0, 3
"""Random starts of each search; it also starts from the best points of the previous caps and of the
other contact.
"""
RANGE_STARTS = 24
"""Random starts of the searches for the largest range."""
CAPS = (60.0, 200.0, 300.0, 1e4)
"""Caps on the range [N], in addition to those of the paper's table; the last one is no
restriction.
"""
CONTACTS = {"cam pushing": True, "free sign": False}
Front = dict[str, Any]
PaperPoints = Mapping[str, Mapping[str, float]]
Cost = Callable[[Array, float], tuple[float, Array]]


@dataclass(frozen=True)
class AttainablePoint:
    """A point z of the unit box with its range [N], its variance [N2] and the smallest force of cam
    on roller [N].
    """

    z: Array
    range: float
    variance: float
    push: float


def _minimise_with_penalties(
    cost: Cost, start: Array, bounds: Sequence[tuple[float | None, float | None]]
) -> Array:
    """Return the end of a search with growing weights of the penalties; `cost` gives value and
    gradient.
    """
    w, options = start, {"maxiter": MAX_ITERATIONS}
    for weight in PENALTIES:
        w = scipy.optimize.minimize(
            cost, w, (weight,), "L-BFGS-B", jac=True, bounds=bounds, options=options
        ).x
    return w


class VarianceSearch:
    """Search for the largest variance within a cap on the range [N]; with `pushing` the cam must
    not pull.

    A point is (z, m): the force must stay within half the cap about m, which is free.
    """

    def __init__(self, force: CalibrationForce, cap: float, pushing: bool) -> None:
        self.force, self.cap, self.pushing = force, cap, pushing
        self.bounds = [*[(0.0, 1.0)] * len(force.inputs), (None, None)]

    def start(self, z: Array) -> Array:
        """Return the point (z, m) with the middle of the force at z."""
        curve = self.force(z)
        return np.append(z, (curve.force.max() + curve.force.min()) / 2 / SEARCH_UNIT)

    def cost(self, w: Array, weight: float) -> tuple[float, Array]:
        """Return the negative variance plus penalties, in squares of the unit, and its gradient."""
        curve = self.force(w[:-1])
        deviation = curve.force - SEARCH_UNIT * w[-1]
        excess = np.sign(deviation) * np.maximum(np.abs(deviation) - self.cap / 2, 0)
        pull = np.maximum(PUSH_MARGIN - curve.push, 0) if self.pushing else np.zeros(1)
        value = -curve.variance + weight * float(excess @ excess + pull @ pull / 10)
        gradient = -curve.variance_slopes + weight * 2 * excess @ curve.slopes
        if self.pushing:
            gradient -= weight * 2 * pull @ curve.push_slopes / 10
        return value / SEARCH_UNIT**2, np.append(
            gradient, -weight * 2 * SEARCH_UNIT * excess.sum()
        ) / SEARCH_UNIT**2

    def run(self, z: Array) -> AttainablePoint:
        """Return the end of the search from a point of the unit box."""
        return _evaluate(
            self.force, _minimise_with_penalties(self.cost, self.start(z), self.bounds)[:-1]
        )


def _search_largest_range(force: CalibrationForce, pushing: bool, z: Array) -> AttainablePoint:
    """Return the end of a search for the largest range."""

    def cost(z: Array, weight: float) -> tuple[float, Array]:
        curve = force(z)
        high, low = int(curve.force.argmax()), int(curve.force.argmin())
        value, gradient = -curve.range, curve.slopes[low] - curve.slopes[high]
        if pushing:
            pull = np.maximum(PUSH_MARGIN - curve.push, 0)
            value += weight * float(pull @ pull) / SEARCH_UNIT
            gradient = gradient - weight * 2 * pull @ curve.push_slopes / SEARCH_UNIT
        return value / SEARCH_UNIT, gradient / SEARCH_UNIT

    return _evaluate(force, _minimise_with_penalties(cost, z, [(0.0, 1.0)] * len(z)))


def _evaluate(force: CalibrationForce, z: Array) -> AttainablePoint:
    curve = force(z)
    return AttainablePoint(z, curve.range, curve.variance, float(curve.push.min()))


def find_largest_variance(
    force: CalibrationForce, cap: float, pushing: bool, starts: Iterable[Array]
) -> AttainablePoint | None:
    """Return the point of largest variance; with `pushing` among those where the cam never pulls,
    None if none is.
    """
    search = VarianceSearch(force, cap, pushing)
    points = [search.run(z) for z in starts]
    return max(
        (p for p in points if p.push >= 0 or not pushing), key=lambda p: p.variance, default=None
    )


def find_largest_range(
    force: CalibrationForce, pushing: bool, starts: Iterable[Array]
) -> AttainablePoint | None:
    """Return the point of largest range; with `pushing` among those where the cam never pulls, None
    if none is.
    """
    points = [_search_largest_range(force, pushing, z) for z in starts]
    return max(
        (p for p in points if p.push >= 0 or not pushing), key=lambda p: p.range, default=None
    )


def compute_key(machine: PlantingMachine, points: PaperPoints) -> str:
    """Return a hash of the machine, the bounds, the generated code without its comments, and the
    search's settings.
    """
    names = [
        "planting_exact",
        *map(functions.find_flank_module, functions.list_flank_laws()),
        *(f"curve_{stage.family}" for stage in (machine.stage1, machine.stage2)),
    ]
    codes = [ast.unparse(ast.parse(generated.text(module))) for module in names]
    parts = [
        machine.table(),
        load_calibration_data()["bounds"],
        points,
        codes,
        [SEED, STARTS, RANGE_STARTS, CAPS],
    ]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def search_front(
    machine: PlantingMachine, paper_points: PaperPoints, progress: Listener | None = None
) -> Front:
    """Return the largest variance within each cap on the range, over all laws, for each sign of the
    contact force.
    """
    caps = sorted({*CAPS, *(point["range_N"] for point in paper_points.values())})
    phase = ProgressPhase(
        "front", "search", len(functions.list_flank_laws()) * len(CONTACTS) * len(caps), progress
    )
    searches = [LawSearch(_with_flank(machine, law)) for law in functions.list_flank_laws()]
    points: dict[str, list[Front]] = {contact: [] for contact in CONTACTS}
    for cap, (contact, pushing) in product(caps, CONTACTS.items()):
        best: tuple[AttainablePoint, LawSearch] | None = None
        for search in searches:
            point = search.find_largest_variance(cap, pushing)
            if point is not None and (best is None or point.variance > best[0].variance):
                best = point, search
            phase.advance(f"{contact}, range up to {cap:g} N")
        if best is not None:
            points[contact].append({"cap_N": cap, **best[1].describe(best[0])})
    # A force that only pushes is also one of free sign
    points["free sign"] += points["cam pushing"]
    fronts = [
        {
            "contact": contact,
            "points": list(_drop_dominated(attained)),
            "largest_range": find_largest_range_of_laws(searches, CONTACTS[contact]),
        }
        for contact, attained in points.items()
    ]
    table = [
        {
            "name": name,
            **point,
            "most_variance_N2": {
                c: _largest_variance_within(points[c], point["range_N"]) for c in points
            },
        }
        for name, point in paper_points.items()
    ]
    return {
        "machine": machine.name,
        "model": "exact",
        "bounds": load_calibration_data()["bounds"],
        "fronts": fronts,
        "table": table,
    }


def find_largest_range_of_laws(searches: Sequence[LawSearch], pushing: bool) -> Front | None:
    """Return the point of the largest range over all laws."""
    points = [
        (point.range, search.describe(point))
        for search in searches
        if (point := search.find_range(pushing))
    ]
    return max(points, key=lambda pair: pair[0])[1] if points else None


class LawSearch:
    """Searches with one law: each starts at random, and from the best points of the previous
    ones.
    """

    def __init__(self, machine: PlantingMachine) -> None:
        device = Device(machine, "exact")
        self.law, self.force = (
            machine.cam.flank,
            CalibrationForce(device, CalibrationInputs.wide(device)),
        )
        self._rng = np.random.default_rng(SEED)
        self._previous: list[Array] = []

    def find_largest_variance(self, cap: float, pushing: bool) -> AttainablePoint | None:
        """Return the point of largest variance within a cap."""
        random = [self._rng.random(len(self.force.inputs)) for _ in range(STARTS)]
        point = find_largest_variance(self.force, cap, pushing, [*random, *self._previous])
        if point is not None:
            self._previous = [point.z, *self._previous[:1]]
        return point

    def find_range(self, pushing: bool) -> AttainablePoint | None:
        """Return the point of largest range."""
        rng = np.random.default_rng(SEED)
        return find_largest_range(
            self.force, pushing, [rng.random(len(self.force.inputs)) for _ in range(RANGE_STARTS)]
        )

    def describe(self, point: AttainablePoint) -> Front:
        """Return a point as results give it, with its inputs."""
        rows = self.force.inputs.table(point.z)
        return {
            "range_N": point.range,
            "variance_N2": point.variance,
            "least_push_N": point.push,
            "flank": self.law,
            "inputs": {row["name"]: row["value"] for row in rows},
        }


def _drop_dominated(points: Sequence[Front]) -> Iterator[Front]:
    """Yield the points in order of range, without those that have no more variance than a previous
    one.
    """
    largest = -1.0
    for point in sorted(points, key=lambda p: p["range_N"]):
        if point["variance_N2"] > largest:
            largest = point["variance_N2"]
            yield point


def _largest_variance_within(points: Sequence[Front], cap: float) -> float | None:
    return max((p["variance_N2"] for p in points if p["cap_N"] <= cap), default=None)


def _with_flank(machine: PlantingMachine, law: str) -> PlantingMachine:
    table = machine.table()
    return PlantingMachine.read({**table, "cam": {**table["cam"], "flank": law}}, machine.source)


def _renew_front(paper: str) -> None:
    """Search for the front of a paper's machine and save it."""
    machine, points = load(paper), attainable.load_paper_points(paper)
    front = search_front(machine, points, lambda progress: print(progress, file=sys.stderr))
    text = json.dumps({"key": compute_key(machine, points), **front}, indent=1)
    file = Path(attainable.__file__).parents[1] / attainable.FRONT_FILE
    file.write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    _renew_front("wang2017")
