"""What `planter calibrate` returns where a reported force is the target, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class Fitted(Record):
    """An input that a calibration found, with the bounds that it searched."""

    name: str
    value: float
    unit: str
    lower: float
    upper: float
    origin: str


@dataclass(frozen=True)
class OtherModel(Record):
    """The support force of the other model with the same inputs."""

    range_N: float
    variance_N2: float
    mean_N: float


@dataclass(frozen=True)
class Distance(Record):
    """How far fitted inputs are from the machine's own, and from what is usual.

    `rms_share` is in widths of the bounds; `at_bounds` are inputs on a bound; `unusual` says what no such machine has.
    """

    rms_share: float
    at_bounds: list[str]
    unusual: list[str]


@dataclass(frozen=True)
class Compromise(Record):
    """One of the best misses: no figure comes nearer without another one being missed by more."""

    choices: dict[str, str]
    reached: dict[str, float]
    range_N: float
    miss_percent: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class ModelFitted(Record):
    """What a calibration found for one model; `front` holds the best misses where the target is not met.

    `least_push_N` is the least force of the cam on the roller over the turn: below zero it would have to pull.
    """

    met: bool
    statement: str
    choices: dict[str, str]
    fitted: list[Fitted]
    reached: dict[str, float]
    miss_percent: dict[str, float]
    cam_pushes: bool
    least_push_N: float
    distance: Distance
    rank: int
    front: list[Compromise] | None = None


@dataclass(frozen=True)
class LargestRange(Record):
    """The largest range that inputs within the bounds were found to give in the exact model, by the cam's contact."""

    cam_pushing: float | None
    free_sign: float | None


@dataclass(frozen=True, kw_only=True)
class CalibrationFound(ModelFitted):
    """`planter calibrate`: fitted inputs, how near they come to the target, and how little that settles.

    Its own figures are those of the `model` that was asked for; `models` holds what was found for each.
    """

    machine: str
    model: str
    target: dict[str, float]
    events: dict[str, float]
    other_model: OtherModel
    models: dict[str, ModelFitted]
    largest_range_N: LargestRange
