"""What is measured of the quantities of a turn, under names that end in their units: `support_range_N`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.optimise.spread import Variance, Weighed, Weights

FOUND = ("max", "min", "mean", "variance")
"""What is found of each quantity, in the order of the compiled record."""
MEANT = {
    "max": "largest value over a turn",
    "min": "least value over a turn",
    "range": "largest less least value over a turn",
    "mean": "mean over a turn",
    "rms": "root mean square over a turn",
    "std": "standard deviation over a turn",
}
SUPPORT = "support_N"
"""The key of the force that the objective is made of."""


@dataclass(frozen=True)
class Measure:
    """An output: a measure of the quantity of a key; `kind` may also be `variance`, and `objective` of the support."""

    key: str
    kind: str
    meaning: str

    def of(self, found: Mapping[str, Array], weights: Weights) -> Array:
        """Its values (m,) in the shown unit, from `FOUND` of its quantity, (m,) each in that unit."""
        match self.kind:
            case "range":
                return found["max"] - found["min"]
            case "rms":
                return np.sqrt(found["mean"] ** 2 + found["variance"])
            case "std":
                return np.sqrt(found["variance"])
            case "objective":
                spread = weights.weighted(found["variance"], np.sqrt)
                return weights.weight_range * (found["max"] - found["min"]) + spread
        return found[self.kind]

    def value(self, values: Array, weights: Weights) -> float:
        """Its value for the samples (n,) of the quantity in its shown unit."""
        found = (values.max(), values.min(), values.mean(), values.var())
        return float(self.of(dict(zip(FOUND, map(np.array, found), strict=True)), weights))

    def slope(self, values: Array, weights: Weights) -> Array:
        """Its derivative (n,) in each of the samples (n,) of the quantity; extremes stay at their samples."""
        variance, count = Variance(values), len(values)
        high, low = np.eye(count)[[values.argmax(), values.argmin()]]
        match self.kind:
            case "max":
                return high
            case "min":
                return low
            case "range":
                return high - low
            case "mean":
                return np.full(count, 1 / count)
            case "rms":
                return values / (count * max(np.sqrt(np.mean(values**2)), np.finfo(float).tiny))
            case "std":
                return variance.slope / (2 * max(np.sqrt(variance.value), np.finfo(float).tiny))
            case "objective":
                return Weighed(weights, values).slope
        return variance.slope


def known(entries: Sequence[Mapping[str, str]]) -> dict[str, Measure]:
    """Every measure of the quantities that a sidecar lists, by its name."""
    return dict(_known({key_of(entry): entry["meaning"] for entry in entries}))


def _known(meanings: Mapping[str, str]) -> Iterator[tuple[str, Measure]]:
    if SUPPORT in meanings:
        of = f"{meanings[SUPPORT]}"
        yield "objective", Measure(SUPPORT, "objective", "objective of the machine's file, samples of a turn")
        yield "support_variance_N2", Measure(SUPPORT, "variance", f"{of}: population variance over a turn")
    for key, meaning in meanings.items():
        suffix = units.suffix(key)
        for kind, told in MEANT.items():
            yield f"{key.removesuffix(suffix)}_{kind}{suffix}", Measure(key, kind, f"{meaning}: {told}")


def key_of(entry: Mapping[str, str]) -> str:
    """The key that a quantity is shown with."""
    return entry.get("shown") or units.key(entry["name"], entry["unit"])
