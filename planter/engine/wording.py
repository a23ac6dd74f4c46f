"""Quantities of machines, measures of them and sums of these, in words."""

from __future__ import annotations

from collections.abc import Sequence

from planter.engine.goal import find_display_unit
from planter.engine.machine import Machine, Quantity
from planter.engine.measures import EventTime, Measure, SettlingBand
from planter.files import units

MINUS, DEGREE = "\N{MINUS SIGN}", "\N{DEGREE SIGN}"
KIND_WORDS = {
    "max": "largest",
    "min": "least",
    "rms": "root mean square of",
    "std": "standard deviation of",
    "jump": "largest jump of",
    "all": "",
    "at": "",
}
"""Words of kinds of measures before a quantity; the others are said as they are written, with
"of".
"""


def name_angle(machine: Machine) -> str:
    """Return the name of the angle of a machine's drive, with its symbol."""
    return f"angle of the drive {machine.angle}"


def label_place(machine: Machine) -> str:
    """Return the label of an axis along a machine's cycle, or its free motion."""
    return "time / s" if machine.motion is not None else f"{name_angle(machine)} / deg"


def name_quantity(quantity: Quantity) -> str:
    """Return the name of a quantity on a page: its meaning, and its symbol."""
    return f"{quantity.meaning} ({quantity.name})" if quantity.meaning else quantity.name


def describe_measure(machine: Machine, measure: Measure, unit: str = "") -> str:
    """Return a measure in words, the quantity by its name and key, with a `unit` in brackets if
    there is one.

    Extremes and conditions follow as a file has them.
    """
    is_time = isinstance(measure.where, EventTime | SettlingBand)
    words = (
        KIND_WORDS.get(measure.kind, f"{measure.kind} of"),
        "size of" if measure.size else "",
        str(measure.where) if is_time else name_quantity(machine.find_quantity(measure.name)),
        f"[{units.typeset_unit(unit)}]" if units.typeset_unit(unit) else "",
        ""
        if measure.angle is None
        else f"at {measure.angle:g}{' s' if measure.in_time else DEGREE}",
        "" if measure.where is None or is_time else f"where {measure.where}",
        "" if measure.span is None else f"over {'..'.join(f'{t:g}' for t in measure.span)} s",
        f"while {' and '.join(map(str, measure.during))}" if measure.during else "",
    )
    return " ".join(filter(None, words))


def describe_sum(machine: Machine, terms: Sequence[Measure]) -> str:
    """Return a sum of measures in words, each with its unit."""
    parts = []
    for term in terms:
        factor = "" if abs(term.weight) == 1 else f"{abs(term.weight):g} \N{MULTIPLICATION SIGN} "
        words = describe_measure(machine, term, find_display_unit(machine, term).text)
        parts.append(f"{'+' if term.weight > 0 else MINUS} {factor}{words}")
    return " ".join(parts).removeprefix("+ ")
