"""Units at the boundary: a key's name ends in the unit of its value; inside, everything is SI and radians.

>>> factor("R3_mm"), unit("R3_mm")
(0.001, 'mm')
>>> factor("m31"), unit("m31")
(1.0, '')
"""

import math
import re
from typing import NamedTuple


class _Unit(NamedTuple):
    display: str
    si: float


_UNITS: dict[str, _Unit] = {
    "um": _Unit("um", 1e-6),
    "mm": _Unit("mm", 1e-3),
    "m": _Unit("m", 1.0),
    "per_mm": _Unit("1/mm", 1e3),
    "mm_s": _Unit("mm/s", 1e-3),
    "m_s": _Unit("m/s", 1.0),
    "m_s2": _Unit("m/s2", 1.0),
    "deg": _Unit("deg", math.pi / 180),
    "deg_per_s": _Unit("deg/s", math.pi / 180),
    "rad": _Unit("rad", 1.0),
    "rad_s": _Unit("rad/s", 1.0),
    "rad_s2": _Unit("rad/s2", 1.0),
    "rpm": _Unit("r/min", math.pi / 30),
    "s": _Unit("s", 1.0),
    "kg": _Unit("kg", 1.0),
    "kg_m2": _Unit("kg m2", 1.0),
    "kg_m3": _Unit("kg/m3", 1.0),
    "N": _Unit("N", 1.0),
    "N2": _Unit("N2", 1.0),
    "N_m": _Unit("N/m", 1.0),
    "N_m15": _Unit("N/m^1.5", 1.0),
    "GPa": _Unit("GPa", 1e9),
    "s_m": _Unit("s/m", 1.0),
    "Nm": _Unit("N m", 1.0),
    "J": _Unit("J", 1.0),
    "W": _Unit("W", 1.0),
}
SUFFIXES = tuple(f"_{suffix}" for suffix in _UNITS)
"""Endings of keys that name a unit."""
_SHOWN_IN = {"m": "mm", "rad": "deg", "1": "", "1/m": "per_mm"}
_NONE = _Unit("", 1.0)
_LONGEST_FIRST = "|".join(sorted(_UNITS, key=len, reverse=True))
_SUFFIX = re.compile(rf"_({_LONGEST_FIRST})(?:\[\d+\])*$")


def factor(key: str) -> float:
    """Return the factor of the display unit of a key to SI, 1 for a key without a unit.

    The longest matching ending counts: `J7_about_B1_kg_m2` is in kg m2. The key may carry an index,
    as in `hinge_A_mm[0]`, and the path before it.
    """
    return _unit(key).si


def unit(key: str) -> str:
    """Return the display unit of a key, empty for a number without a unit."""
    return _unit(key).display


def suffix(key: str) -> str:
    """Return the ending of a key that names its unit, empty for a number without a unit.

    >>> suffix("omega_rad_s"), suffix("hinge_A_mm[0]"), suffix("m31")
    ('_rad_s', '_mm', '')
    """
    match = _SUFFIX.search(key)
    return f"_{match[1]}" if match else ""


def key(name: str, si_unit: str) -> str:
    """Return the key of a quantity in its display unit: lengths in mm, angles in deg, others in SI.

    >>> key("phi52", "rad"), key("M_Q", "N m"), key("ratio", "1")
    ('phi52_deg', 'M_Q_Nm', 'ratio')
    """
    suffix = _SHOWN_IN.get(si_unit)
    if suffix is None:
        suffix = next(s for s, unit in _UNITS.items() if unit.display == si_unit and unit.si == 1.0)
    return f"{name}_{suffix}" if suffix else name


def has_key(si_unit: str) -> bool:
    """Return whether quantities of an SI unit have a display unit."""
    return si_unit in _SHOWN_IN or any(unit.display == si_unit and unit.si == 1.0 for unit in _UNITS.values())


def _unit(key: str) -> _Unit:
    match = _SUFFIX.search(key)
    return _UNITS[match[1]] if match else _NONE
