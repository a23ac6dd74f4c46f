"""What several of the device's commands return: designs, warnings, requirements, figures of a force."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record

Design = dict[str, float]
"""Values by the names of a machine's own design vector, each in the unit that its name ends in."""
Direction = list[dict[str, float]]
"""Weights of design parameters, in parts of their box widths."""


@dataclass(frozen=True, kw_only=True)
class Warned(Record):
    """Something that a user should know, with the carrier angle where it begins or is worst, if it has one."""

    name: str
    phi_deg: float | None = None
    message: str


@dataclass(frozen=True)
class Requirement(Record):
    """A requirement at a design: null limits and places where it has none; `of` says which gear or pair is meant."""

    name: str
    value: float
    unit: str
    lower: float | None
    upper: float | None
    margin: float
    phi_deg: float | None
    wanted_margin: float
    verdict: str
    meaning: str
    of: str | None
    origin: str


@dataclass(frozen=True)
class Violation(Record):
    """A requirement that has to give way: by `amount` in `unit`, its limit of `key` to `relaxed`."""

    name: str
    amount: float
    unit: str
    phi_deg: float | None
    value: float
    key: str
    limit: float
    relaxed: float

    def __str__(self) -> str:
        place = f" at phi = {self.phi_deg:.6g} deg" if self.phi_deg is not None else ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return (
            f"{self.name} = {self.value:.6g}{unit}{place} misses {self.key} with its margin by {self.amount:.6g}{unit}"
        )


@dataclass(frozen=True)
class Statistics(Record):
    """Samples of a force: extremes, range, mean and population variance."""

    max_N: float
    min_N: float
    range_N: float
    mean_N: float
    variance_N2: float
