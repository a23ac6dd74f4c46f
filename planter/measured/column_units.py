"""Units that columns of a measurement may have, by the unit of the measured quantity."""

from __future__ import annotations

import re

from planter.files import units
from planter.files.units import parse_unit

ALIKE = (
    ("N", "kN", "daN", "mN"),
    ("N m", "kN m", "N mm", "N cm"),
    ("mm", "m", "cm", "um"),
    ("deg", "rad", "rev"),
    ("s", "ms", "us", "min", "h"),
    ("rad/s", "r/min", "deg/s"),
    ("rad/s2", "deg/s2"),
    ("m/s", "mm/s"),
    ("m/s2", "mm/s2"),
    ("W", "kW", "mW"),
    ("J", "kJ", "mJ"),
    ("1", "%"),
)
"""Units that a column may have, by their kinds."""

_NAME_AND_UNIT = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\)|/\s*(?P<c>[^/]+)|\sin\s(?P<d>\S+)|_(?P<e>[A-Za-z°]+))\s*"
)
_UNIT_SPELLINGS = {
    "u/min": "r/min",
    "1/min": "r/min",
    "rpm": "r/min",
    "min^-1": "r/min",
    "min-1": "r/min",
    "degree": "deg",
    "degrees": "deg",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "µm": "um",
    "μm": "um",
    "newton": "N",
    "newtons": "N",
    "radian": "rad",
    "radians": "rad",
    "turns": "rev",
    "°": "deg",
}


def list_units(unit: str) -> dict[str, float]:
    """Return the units that a column of a quantity may have, each in parts of the quantity's
    display unit.

    >>> list_units("mm")["m"], list_units("N")["daN"]
    (1000.0, 10.0)
    """
    alike = next((names for names in ALIKE if (unit or "1") in names), (unit,))
    return {name: parse_unit(name).factor / parse_unit(unit).factor for name in alike}


def find_factor(allowed: dict[str, float], unit: str) -> float | None:
    """Return the factor of a unit in any spelling, None if it is not allowed.

    >>> find_factor(list_units("N m"), "kN·m"), find_factor(list_units("s"), "sec")
    (1000.0, 1.0)
    >>> find_factor(list_units("s"), "N")
    """
    by_spelling = {normalise_unit(name): factor for name, factor in allowed.items()}
    return by_spelling.get(normalise_unit(unit))


def split_unit(name: str) -> tuple[str, str | None]:
    """Return a header's name and unit, None without a unit; an ending after `_` counts if it is
    one.

    >>> split_unit("Kraft [N]"), split_unit("F / kN"), split_unit("phi_rad"), split_unit("support_force")
    (('Kraft', 'N'), ('F', 'kN'), ('phi', 'rad'), ('support_force', None))
    """
    if suffix := units.unit_suffix(name):
        return name.removesuffix(suffix), units.display_unit(name)
    match = _NAME_AND_UNIT.fullmatch(name)
    if match is None or not match["name"]:
        return name, None
    unit = next(match[key] for key in "abcde" if match[key] is not None).strip()
    if (match["d"] or match["e"]) and normalise_unit(unit) not in KNOWN:
        return name, None
    return match["name"], unit or None


def normalise_unit(unit: str) -> str:
    """Return a unit without signs of multiplication and with one spelling.

    >>> normalise_unit("N·m"), normalise_unit("U/min"), normalise_unit("µm")
    ('Nm', 'r/min', 'um')
    """
    text = re.sub(r"[\s·⋅*_]", "", unit)
    return _UNIT_SPELLINGS.get(text.lower(), text)


KNOWN = frozenset(normalise_unit(name) for names in ALIKE for name in names) - {"1", "h"}
"""Spellings that count as units without brackets."""
