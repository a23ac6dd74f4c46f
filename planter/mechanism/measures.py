"""What is asked of a turn: measures of quantities, and limits on them, as a person writes them.

>>> for term in least("range F_Ox + 0.5 rms M_in"): print(term)
range F_Ox
0.5 rms M_in
>>> print(hold("abs F_Ax <= 300"), hold("s at 90 >= 150"), sep="; ")
abs F_Ax <= 300; s at 90 >= 150
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from planter.errors import InputError

Kind = Literal["max", "min", "range", "mean", "rms", "variance", "at", "all"]
KINDS: tuple[Kind, ...] = ("max", "min", "range", "mean", "rms", "variance")
AVERAGES = ("mean", "rms", "variance")
"""Measures that only a turn has that ends in the state in which it began."""
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_TERM = re.compile(
    rf"(?:(?P<weight>{_NUMBER})\s*\*?\s+)?(?:(?P<kind>{'|'.join(KINDS)})\s+)?(?P<size>abs\s+)?(?P<name>[A-Za-z_]\w*)"
    rf"(?:\s+at\s+(?P<angle>{_NUMBER})(?:\s*(?P<in>deg|s))?)?"
)
_HOLD = re.compile(rf"(?P<term>.*?)\s*(?P<sign><=|>=)\s*(?P<limit>{_NUMBER})")
SAID = (
    "it must be a sum of [WEIGHT] MEASURE [abs] NAME, MEASURE one of " + ", ".join(KINDS) + ", or NAME at DEG, such as "
    '"range F_Ox + 0.5 rms M_in"'
)
HELD = 'it must be [MEASURE] [abs] NAME [at DEG] <= NUMBER (or >=), such as "abs F_Ax <= 300" or "s at 90 >= 150"'

ASKED = (
    f"it must be MEASURE [abs] NAME, MEASURE one of {', '.join(KINDS)}, or NAME at ANGLE, or NAME at SECONDS s, such "
    'as "max F_Ax" or "M_in at 90"'
)


@dataclass(frozen=True)
class Measure:
    """A measure of a quantity over a turn: `all` is its value everywhere, `at` that at an angle [deg].

    Of one over a motion `angle` is a time [s], and `in_time` is set.
    """

    kind: Kind
    name: str
    size: bool = False
    weight: float = 1.0
    angle: float | None = None
    in_time: bool = False

    def __str__(self) -> str:
        weight = "" if self.weight == 1 else f"{self.weight:g} "
        kind = "" if self.kind in ("all", "at") else f"{self.kind} "
        at = "" if self.angle is None else f" at {self.angle:g}{' s' if self.in_time else ''}"
        return f"{weight}{kind}{'abs ' if self.size else ''}{self.name}{at}"


@dataclass(frozen=True)
class Hold:
    """A measure with its limit, in the quantity's shown unit: at most it (`sign` +1), or at least."""

    measure: Measure
    sign: int
    limit: float

    def __str__(self) -> str:
        return f"{self.measure} {'<=' if self.sign > 0 else '>='} {self.limit:g}"


def least(text: str) -> tuple[Measure, ...]:
    """The measures of a sum that is to be made small. Raises InputError for what is none."""
    found = tuple(_of_turn(part, f"--least {text!r} is not allowed: {SAID}") for part in text.split("+"))
    for term in found:
        if term.kind == "all":
            raise InputError(f"--least {text!r} is not allowed: {term.name} needs a measure; {SAID}")
        if term.size and term.kind in ("mean", "variance", "at"):
            raise InputError(f"--least {text!r} is not allowed: {term.kind} takes no abs, which has corners; {SAID}")
        if term.weight < 0:
            raise InputError(f"--least {text!r} is not allowed: the weight {term.weight:g} is negative")
    return found


def hold(text: str) -> Hold:
    """A limit on a measure. Raises InputError for what is none."""
    complaint = f"--hold {text!r} is not allowed: {HELD}"
    match = _HOLD.fullmatch(text.strip())
    if match is None:
        raise InputError(complaint)
    measure, sign = _of_turn(match["term"], complaint), 1 if match["sign"] == "<=" else -1
    if (
        measure.weight != 1
        or (measure.size and sign < 0)
        or (measure.size and measure.kind in ("mean", "variance", "at"))
    ):
        raise InputError(complaint)
    if (measure.kind, sign) in (("max", -1), ("min", 1), ("range", -1)):
        raise InputError(f"--hold {text!r} is not allowed: only max <=, min >= and range <= are limits")
    return Hold(measure, sign, float(match["limit"]))


def one(text: str, label: str) -> Measure:
    """A single measure, or a quantity at an angle or a time. Raises InputError, which begins with `label`."""
    complaint = f"{label}.quantity = {text!r} is not allowed: {ASKED}"
    measure = _measure(text, complaint)
    if measure.kind == "all":
        raise InputError(complaint)
    if measure.weight != 1:
        raise InputError(f"{complaint}, without a weight")
    return measure


def _of_turn(text: str, complaint: str) -> Measure:
    measure = _measure(text, complaint)
    if measure.in_time:
        raise InputError(complaint)
    return measure


def _measure(text: str, complaint: str) -> Measure:
    match = _TERM.fullmatch(text.strip())
    if match is None or (match["kind"] and match["angle"]):
        raise InputError(complaint)
    kind: Kind = "at" if match["angle"] else next((k for k in KINDS if k == match["kind"]), "all")
    angle = float(match["angle"]) if match["angle"] else None
    weight = float(match["weight"] or 1)
    return Measure(kind, match["name"], bool(match["size"]), weight, angle, match["in"] == "s")
