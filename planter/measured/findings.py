"""Results of a fit to measured data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planter.files.record import Record
from planter.measured.curve import Side
from planter.measured.noise import LackOfFit
from planter.measured.reading import DataColumn, DataReading

Outcome = Literal["explained", "not explained", "not settled"]


@dataclass(frozen=True)
class FittedInput(Record):
    """Fitted input: `value` with its bounds and its confidence interval.

    `interval` has the ends of the 95 % interval of the profile likelihood, for the noise of the
    result; an interval that ends at a bound is open. A phase lies
    between 0 and its period, with bounds and interval moved by whole periods: measured(phi) =
    computed(phi + phase). A shift is that of the time: measured(t) = computed(t + shift).
    """

    name: str
    value: float
    unit: str
    lower: float
    upper: float
    start: float
    interval: list[float]
    open: bool
    origin: str


@dataclass(frozen=True)
class MeasurementResult(Record):
    """Statistics of the curve that a machine file's sensor sees: extremes, range, mean, population
    variance of samples.

    `seen` describes, in the order in which they act, what stands between the rigid machine and the
    signal. The numbers are in `unit`, the `variance` in its square.
    """

    quantity: str
    unit: str
    max: float
    min: float
    range: float
    mean: float
    variance: float
    seen: list[str]


@dataclass(frozen=True)
class Noise(Record):
    """Noise that the intervals assume: `white`, or `ar1`, with the correlation `rho` of
    neighbouring points.

    `std` is the standard deviation of the residuals of the first quantity, for the number of inputs
    fitted.
    """

    model: Literal["white", "ar1"]
    std: float
    rho: float
    unit: str


@dataclass(frozen=True)
class FitBound(Record):
    """Bound of the input `name` on which a fit rests: no fit inside is as good, so a better one may
    lie beyond.
    """

    name: str
    side: Side


@dataclass(frozen=True)
class ChannelFit(Record):
    """Residuals of one measured quantity: their RMS over points in use, and their noise."""

    quantity: str
    unit: str
    points: int
    rms: float
    noise: Noise


@dataclass(frozen=True)
class ModelMeasured(Record):
    """Fit of one model: residuals, what the data determine, and the number of starts that agree.

    `outcome`: "explained" if what is left passes as noise (`lack_of_fit`), but "not settled" if the
    fit rests on `active_bounds`; else "not explained", or "not settled" if starts disagree. `rank`
    is the number of combinations of inputs that the data determine; `correlation` is the matrix of
    the inputs in their order, null if the data do not determine all; `rms_of_noise` is the RMS
    residual over the noise of the data, null for the points of a path, which do not tell it. The
    largest residual has its angle, or, of what moves
    freely, its time in the record.
    """

    outcome: Outcome
    rms: float
    rms_of_noise: float | None
    largest_residual: float
    largest_residual_deg: float | None
    fitted: list[FittedInput]
    rank: int
    correlation: list[list[float]] | None
    starts: int
    agreeing_starts: int
    lack_of_fit: LackOfFit
    noise: Noise
    channels: list[ChannelFit]
    active_bounds: list[FitBound]
    rms_N: float | None = None
    largest_residual_s: float | None = None


@dataclass(frozen=True)
class NoiseSpread(Record):
    """Root mean square over points, in the unit of the result: of the data about their mean, or of
    residuals.

    `rms_N` is the same value if the unit is N, else null.
    """

    rms: float
    points: int
    rms_N: float | None = None


@dataclass(frozen=True)
class Prediction(Record):
    """Prediction of a second measurement at another speed with the inputs of the fit: residuals of
    each model.
    """

    speed_rpm: float
    points: int
    rms: dict[str, float]
    rms_N: dict[str, float] | None = None


@dataclass(frozen=True)
class MeasuredFound(Record):
    """Result of `planter calibrate --data`: inputs fitted to measured data in all models; `model`
    is the first of them.

    `outcome`, `fitted`, `rank`, `starts` and `agreeing_starts` are those of `model`; `unit` is that
    of the quantity. `reading` and, in sentences, `treatment` describe how the data were read and
    what was left out; `warnings` are limits of the result.
    """

    machine: str
    model: str
    quantity: str
    unit: str
    outcome: Outcome
    statement: str
    treatment: list[str]
    warnings: list[str]
    noise: Noise
    target: NoiseSpread
    reached: NoiseSpread
    fitted: list[FittedInput]
    rank: int
    starts: int
    agreeing_starts: int
    models: dict[str, ModelMeasured]
    other_model: NoiseSpread | None
    reading: DataReading
    prediction: Prediction | None = None


@dataclass(frozen=True)
class LargestDistance(Record):
    """The point that is farthest from the path: its signed distance, its line among the points in
    use, counted from 1, and its place in the frame of the machine.

    `phi_deg` is the angle of the nearest point of the path, `arc_mm` the length of the path from the
    angle 0 to there.
    """

    distance_mm: float
    point: int
    x_mm: float
    y_mm: float
    phi_deg: float
    arc_mm: float


@dataclass(frozen=True)
class FramePlacement(Record):
    """Pose of the measured frame in that of the machine: rotation and origin.

    `fitted` names those of them that were fitted; the others are zero.
    """

    rotation_deg: float
    x_mm: float
    y_mm: float
    fitted: list[str]


@dataclass(frozen=True)
class PathFound(Record):
    """Result of `planter calibrate --data` for the points of a path: their distances from the path
    of the point whose coordinates `quantity` names.

    A distance is that to the true nearest point of the path, positive on its left, seen in the
    direction in which the drive angle grows. `rms_mm`, `mean_mm` and `largest` are those of all
    `points`; `length_mm` is the length of the path over a cycle. `fit` is null, `fitted` empty and
    `outcome` null if nothing was fitted.
    """

    machine: str
    model: str
    quantity: list[str]
    unit: str
    statement: str
    points: int
    rms_mm: float
    mean_mm: float
    largest: LargestDistance
    length_mm: float
    placement: FramePlacement
    outcome: Outcome | None
    fitted: list[FittedInput]
    fit: ModelMeasured | None
    treatment: list[str]
    warnings: list[str]
    reading: DataReading


@dataclass(frozen=True)
class MeasuredPreview(Record):
    """Result of `planter calibrate --data --preview`: what was understood of the file; nothing is
    fitted.

    `reading` is null if no column is named.
    """

    machine: str
    quantity: list[str]
    columns: list[DataColumn]
    reading: DataReading | None
    treatment: list[str]


@dataclass(frozen=True)
class EffectParameter(Record):
    """Parameter of an effect: its value, the ends of its prior, and the 95 % interval.

    The prior is uniform in the value, its logarithm or its reciprocal (`prior`). Ends are null
    where they are infinite; the interval is null for explanations that the data rule out.
    """

    name: str
    value: float | None
    unit: str
    lower: float | None
    upper: float | None
    prior: Literal["linear", "log", "reciprocal"]
    interval: list[float | None] | None


@dataclass(frozen=True)
class Explanation(Record):
    """The rigid machine with effects between it and the sensor, fitted to a curve.

    `outcome` is that of what is left; `F` and `probability` compare with the rigid machine, for the
    correlation of the noise that is most favourable to it, and `probability_of_any` is that of such
    an F for any of the explanations that were compared, by Bonferroni's bound; `log10_bayes` is the
    logarithm of the ratio of the evidences of this explanation and of the rigid machine. If the
    machine file has a [measurement] of the quantity, the machine behind that, "stated", takes the
    place of the rigid one. `correlation` is the matrix of inputs and parameters in their order,
    null if the data do not determine all. An explanation that rests on `active_bounds` is "not
    settled": its F and evidence hold within them alone.
    """

    name: str
    meaning: str
    outcome: Outcome
    rms: float
    noise: Noise
    lack_of_fit: LackOfFit
    F: float | None
    probability: float | None
    probability_of_any: float | None
    log10_bayes: float
    parameters: list[EffectParameter]
    inputs: dict[str, float]
    correlation: list[list[float]] | None
    starts: int
    agreeing_starts: int
    active_bounds: list[FitBound]


@dataclass(frozen=True)
class ExplanationFound(Record):
    """Result of `planter calibrate --data --explain`: what gives a measured curve, from the rigid
    machine upwards.

    `preferred` is the most probable explanation among those that are better than the rigid machine
    beyond chance; `undecided` are all that the data cannot tell from it. `compared` is the number
    of effects compared, on which the level of the test depends. `outcome` is that of `preferred`,
    and `fitted` are its inputs.
    """

    machine: str
    model: str
    quantity: str
    unit: str
    outcome: Outcome
    statement: str
    preferred: str
    undecided: list[str]
    compared: int
    explanations: list[Explanation]
    fitted: list[FittedInput]
    treatment: list[str]
    reading: DataReading
