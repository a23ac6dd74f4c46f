"""What a fit to measured data finds, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class FittedInput(Record):
    """An input that was fitted: `value` with the bounds that it had, and the band that the data leave it.

    `low95` and `high95` are where the profile of the likelihood passes 95 %; a band that ends on a bound is open there.
    """

    name: str
    value: float
    unit: str
    lower: float
    upper: float
    start: float
    low95: float
    high95: float
    open: bool
    origin: str


@dataclass(frozen=True)
class ModelMeasured(Record):
    """The fit of one model: what is left, what the data determine, and how many starts came to it.

    `rank` counts the combinations of inputs that the data determine; `correlation` is that of the inputs in their
    order, null where the data do not determine all of them; `rms_of_noise` is what is left over the noise of the data.
    """

    rms_N: float
    rms_of_noise: float
    largest_residual_N: float
    largest_residual_deg: float
    fitted: list[FittedInput]
    rank: int
    correlation: list[list[float]] | None
    starts: int
    agreeing_starts: int


@dataclass(frozen=True)
class Spread(Record):
    """Root mean square over points: of the data about their mean, or of what a fit leaves."""

    rms_N: float
    points: int


@dataclass(frozen=True)
class Prediction(Record):
    """A second measurement at another speed, with the inputs of the fit: what is left in each model, nothing fitted."""

    speed_rpm: float
    points: int
    rms_N: dict[str, float]


@dataclass(frozen=True)
class MeasuredFound(Record):
    """`planter calibrate --data`: inputs fitted to measured data in both models; `model` is the one that is told first.

    `treatment` says how the data were read, what was left out and why; `noise_N` is the scatter between neighbours.
    """

    machine: str
    model: str
    quantity: str
    statement: str
    treatment: list[str]
    left_out: int
    noise_N: float
    target: Spread
    reached: Spread
    fitted: list[FittedInput]
    rank: int
    models: dict[str, ModelMeasured]
    other_model: Spread
    prediction: Prediction | None = None
