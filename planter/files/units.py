"""Units of keys, whose names end in the unit of their value, and units as papers print them; all
else is SI and rad.

>>> unit_factor("R3_mm"), display_unit("R3_mm")
(0.001, 'mm')
>>> unit_factor("m31"), display_unit("m31")
(1.0, '')
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache

from planter.errors import InputError

Dimension = tuple[float, float, float, float]
"""Exponents of kg, m, s, rad."""
_BASE: dict[str, tuple[float, Dimension]] = {
    "": (1.0, (0, 0, 0, 0)),
    "1": (1.0, (0, 0, 0, 0)),
    "%": (1e-2, (0, 0, 0, 0)),
    "g": (1e-3, (1, 0, 0, 0)),
    "t": (1e3, (1, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0)),
    "s": (1.0, (0, 0, 1, 0)),
    "min": (60.0, (0, 0, 1, 0)),
    "h": (3600.0, (0, 0, 1, 0)),
    "rad": (1.0, (0, 0, 0, 1)),
    "deg": (math.pi / 180, (0, 0, 0, 1)),
    "r": (2 * math.pi, (0, 0, 0, 1)),
    "N": (1.0, (1, 1, -2, 0)),
    "daN": (10.0, (1, 1, -2, 0)),
    "J": (1.0, (1, 2, -2, 0)),
    "W": (1.0, (1, 2, -3, 0)),
    "Pa": (1.0, (1, -1, -2, 0)),
    "Hz": (1.0, (0, 0, -1, 0)),
}
_ALSO = {"rpm": "r/min", "rev": "r"}
_PREFIXES = {
    "n": 1e-9,
    "u": 1e-6,
    "µ": 1e-6,
    "m": 1e-3,
    "c": 1e-2,
    "d": 1e-1,
    "k": 1e3,
    "M": 1e6,
    "G": 1e9,
}
_PREFIXED = ("g", "m", "s", "rad", "N", "J", "W", "Pa")
_FACTOR = re.compile(r"([^\W\d]+|%|°|1)\^?(-?\d+(?:\.\d+)?)?")


@dataclass(frozen=True)
class Unit:
    """A unit: its text, its factor to SI, and its dimension."""

    text: str
    factor: float
    dimension: Dimension

    def same_kind(self, other: Unit) -> bool:
        """Return whether both have the same dimension; an angle differs from a pure number."""
        return self.dimension == other.dimension

    def squared(self) -> Unit:
        """Return the square of the unit."""
        kg, m, s, rad = (2 * power for power in self.dimension)
        text = f"{self.text}2" if self.text.isalpha() else f"({self.text})2"
        return Unit(text if self.text else "", self.factor**2, (kg, m, s, rad))


@cache
def parse_unit(text: str) -> Unit:
    """Parse a unit such as ``N m``, ``kg m2``, ``mm/s2`` or ``r/min``; an empty text is a pure
    number.

    Units after a stroke divide. Raises ValueError, which names the part, if the text is not a unit.
    """
    factor, total = 1.0, [0.0, 0.0, 0.0, 0.0]
    above, _, below = _ALSO.get(text.strip(), text).partition("/")
    for sign, part in ((1, above), (-1, below)):
        for name in part.replace("*", " ").replace("·", " ").split():
            scale, dimension, power = _parse_factor(name)
            factor = factor * scale**power if sign > 0 else factor / scale**power
            total = [t + sign * power * d for t, d in zip(total, dimension, strict=True)]
    kg, m, s, rad = total
    return Unit(text, factor, (kg, m, s, rad))


def _parse_factor(text: str) -> tuple[float, Dimension, float]:
    match = _FACTOR.fullmatch(text)
    if match is None:
        raise ValueError(f"{text} is not a unit")
    name, power = "deg" if match[1] == "°" else match[1], float(match[2] or 1)
    if name in _BASE:
        return (*_BASE[name], power)
    prefix, base = name[:1], name[1:]
    if prefix in _PREFIXES and base in _PREFIXED:
        factor, dimension = _BASE[base]
        return _PREFIXES[prefix] * factor, dimension, power
    raise ValueError(f"{name} is not a unit")


_UNITS = {
    "um": "um",
    "mm": "mm",
    "cm": "cm",
    "m": "m",
    "per_mm": "1/mm",
    "mm_s": "mm/s",
    "m_s": "m/s",
    "km_h": "km/h",
    "m_s2": "m/s2",
    "deg": "deg",
    "deg_per_s": "deg/s",
    "rad": "rad",
    "rad_s": "rad/s",
    "rad_s2": "rad/s2",
    "rpm": "r/min",
    "s": "s",
    "per_s": "1/s",
    "per_s2": "1/s2",
    "Hz": "Hz",
    "kg": "kg",
    "kg_m": "kg m",
    "kg_m2": "kg m2",
    "kg_m3": "kg/m3",
    "kg_m_s": "kg m/s",
    "kg_m2_s": "kg m2/s",
    "m2": "m2",
    "m3": "m3",
    "m2_s": "m2/s",
    "m3_s": "m3/s",
    "N": "N",
    "N_s": "N s",
    "Ns": "N s",
    "N_s_m": "N s/m",
    "Ns_m": "N s/m",
    "N_m_s": "N m s",
    "N_m_s_rad": "N m s/rad",
    "N_m_rad": "N m/rad",
    "Pa": "Pa",
    "N2": "N2",
    "N_m": "N/m",
    "kN": "kN",
    "kN_m": "kN/m",
    "N_m2": "N/m2",
    "N_m15": "N/m^1.5",
    "MPa": "MPa",
    "GPa": "GPa",
    "s_m": "s/m",
    "Nm": "N m",
    "J": "J",
    "W": "W",
    "kW": "kW",
}
"""Display units by the endings of keys."""
_SI = {unit: suffix for suffix, unit in _UNITS.items() if parse_unit(unit).factor == 1.0}
"""Endings of keys by the units that are SI."""
SUFFIXES = tuple(f"_{suffix}" for suffix in _UNITS)
"""Endings of keys that name a unit."""
_SHOWN_IN = {"m": "mm", "rad": "deg", "1": "", "1/m": "per_mm"}
_LONGEST_FIRST = "|".join(sorted(_UNITS, key=len, reverse=True))
_SUFFIX = re.compile(rf"_({_LONGEST_FIRST})(?:\[\d+\])*$")


def unit_factor(key: str) -> float:
    """Return the factor of the display unit of a key to SI, 1 for a key without a unit.

    The longest matching ending counts: `J7_about_B1_kg_m2` is in kg m2. The key may carry an index,
    as in `hinge_A_mm[0]`, and the path before it.
    """
    return parse_unit(display_unit(key)).factor


def display_unit(key: str) -> str:
    """Return the display unit of a key, empty for a number without a unit."""
    match = _SUFFIX.search(key)
    return _UNITS[match[1]] if match else ""


_SIGNS = {"deg": "\N{DEGREE SIGN}", "um": "\N{MICRO SIGN}m", "1": ""}
_EXPONENTS = {
    "2": "\N{SUPERSCRIPT TWO}",
    "3": "\N{SUPERSCRIPT THREE}",
    "4": "\N{SUPERSCRIPT FOUR}",
    "5": "\N{SUPERSCRIPT FIVE}",
    "6": "\N{SUPERSCRIPT SIX}",
}


def typeset_unit(unit: str) -> str:
    """Return a unit as pages and figures show it: exponents as superscripts, and nothing for the
    unit 1.

    >>> typeset_unit("rad/s2"), typeset_unit("deg"), typeset_unit("1"), typeset_unit("km/h")
    ('rad/s²', '°', '', 'km/h')
    """
    raised = re.sub(r"(?<=[A-Za-z])[2-6]\b", lambda exponent: _EXPONENTS[exponent[0]], unit)
    return _SIGNS.get(unit, raised)


def typeset_label(label: str) -> str:
    """Return a label with the unit behind the last stroke of each line typeset, and without one for
    the unit 1.

    >>> typeset_label("variance / N2"), typeset_label("ratio / 1"), typeset_label("angle / deg\\nof the carrier")
    ('variance / N²', 'ratio', 'angle / °\\nof the carrier')
    """
    lines = []
    for line in label.split("\n"):
        name, stroke, unit = line.rpartition(" / ")
        sign = typeset_unit(unit) if stroke else unit
        lines.append(f"{name}{stroke}{sign}" if sign else name)
    return "\n".join(lines)


_DEGREES = re.compile(r'(`[^`]*`|"[^"]*")|(?<=\d) deg\b(?![/\\]|\.\w)|(?<= / )deg$')
"""Angles of a sentence, and the unit that ends a label; code and quotations stand in a group, which
stays.
"""


def typeset_degrees(text: str) -> str:
    """Return a sentence or a label whose angles have the sign of degrees, except in code and
    quotations.

    >>> typeset_degrees("at 12.5 deg of 360 deg, 5 deg/s, from 5 deg.csv, as `--at '5 deg'`")
    "at 12.5° of 360°, 5 deg/s, from 5 deg.csv, as `--at '5 deg'`"
    >>> typeset_degrees("angle / deg")
    'angle / °'
    """
    return _DEGREES.sub(lambda match: match[1] or _SIGNS["deg"], text)


def unit_suffix(key: str) -> str:
    """Return the ending of a key that names its unit, empty for a number without a unit.

    >>> unit_suffix("omega_rad_s"), unit_suffix("hinge_A_mm[0]"), unit_suffix("m31")
    ('_rad_s', '_mm', '')
    """
    match = _SUFFIX.search(key)
    return f"_{match[1]}" if match else ""


def display_key(name: str, si_unit: str) -> str:
    """Return the key of a quantity in its display unit: lengths in mm, angles in deg, others in SI.

    Raises InputError if no key names the unit.

    >>> display_key("phi52", "rad"), display_key("M_Q", "N m"), display_key("ratio", "1")
    ('phi52_deg', 'M_Q_Nm', 'ratio')
    """
    suffix = _SHOWN_IN.get(si_unit, _SI.get(si_unit))
    if suffix is None:
        raise InputError(
            f"{name}: unit = {si_unit}: results can be in {', '.join(_SI)}, or without unit"
        )
    return f"{name}_{suffix}" if suffix else name


def display_keys(entries: Iterable[Mapping[str, str]]) -> dict[str, str]:
    """Return the keys of quantities, each with a name and a unit, by their names."""
    return {entry["name"]: display_key(entry["name"], entry["unit"]) for entry in entries}


def has_key(si_unit: str) -> bool:
    """Return whether quantities of an SI unit have a display unit."""
    return si_unit in _SHOWN_IN or si_unit in _SI
