"""What a fit to measured data finds, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planter.records import Record

Outcome = Literal["explained", "not explained", "not settled"]


@dataclass(frozen=True)
class FittedInput(Record):
    """An input that was fitted: `value` with the bounds that it had, and the band that the data leave it.

    `low95` and `high95`, together `interval`, are where the profile of the likelihood passes 95 %, for the noise that
    the result names; a band that ends on a bound is open there. A phase lies between 0 and its period, with its bounds
    and its band moved by whole periods: measured(phi) = computed(phi + phase).
    """

    name: str
    value: float
    unit: str
    lower: float
    upper: float
    start: float
    low95: float
    high95: float
    interval: list[float]
    open: bool
    origin: str


@dataclass(frozen=True)
class ModelMeasured(Record):
    """The fit of one model: what is left, what the data determine, and how many starts came to it.

    `outcome`: "explained", "not explained", or "not settled" if starts disagree or the residuals look like correlated
    noise. `rank` counts the combinations of inputs that the data determine; `correlation` is that of the inputs in
    their order, null where the data do not determine all of them; `rms_of_noise` is what is left over the noise of the
    data; `autocorrelation` is that of neighbouring residuals, `white` whether a test sees none.
    """

    outcome: Outcome
    rms: float
    rms_of_noise: float
    largest_residual: float
    largest_residual_deg: float
    autocorrelation: float
    white: bool
    fitted: list[FittedInput]
    rank: int
    correlation: list[list[float]] | None
    starts: int
    agreeing_starts: int
    rms_N: float | None = None
    largest_residual_N: float | None = None


@dataclass(frozen=True)
class Spread(Record):
    """Root mean square over points, in the unit of the result: of the data about their mean, or of what a fit leaves.

    `rms_N` is the same, given if the unit is N.
    """

    rms: float
    points: int
    rms_N: float | None = None


@dataclass(frozen=True)
class Noise(Record):
    """The noise that the bands assume: `white`, equal and independent at all points, with `std` from the scatter
    between neighbouring points; or `ar1`, with the correlation `rho` of neighbours.
    """

    model: Literal["white", "ar1"]
    std: float
    rho: float
    unit: str


@dataclass(frozen=True)
class Prediction(Record):
    """A second measurement at another speed, with the inputs of the fit: what is left in each model, nothing fitted."""

    speed_rpm: float
    points: int
    rms: dict[str, float]
    rms_N: dict[str, float] | None = None


@dataclass(frozen=True)
class MeasuredFound(Record):
    """`planter calibrate --data`: inputs fitted to measured data in all models; `model` is the one that is told first.

    `outcome`, `fitted`, `rank`, `starts` and `agreeing_starts` are those of `model`; `unit` is that of the quantity.
    `treatment` says how the data were read, what was left out and why; `warnings` what limits the answer; `noise_N` is
    `noise.std` if the unit is N.
    """

    machine: str
    model: str
    quantity: str
    unit: str
    outcome: Outcome
    statement: str
    treatment: list[str]
    warnings: list[str]
    left_out: int
    noise: Noise
    target: Spread
    reached: Spread
    fitted: list[FittedInput]
    rank: int
    starts: int
    agreeing_starts: int
    models: dict[str, ModelMeasured]
    other_model: Spread | None
    prediction: Prediction | None = None
    noise_N: float | None = None
