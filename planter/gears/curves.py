"""Pitch curves from CSV files: columns `polar_deg` and `radius_mm`, or such with a prefix, `FILE:PREFIX`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import csv_rows, text
from planter.gearing.teeth.curve import POLAR
from planter.gearing.teeth.pair import Pair
from planter.gearing.teeth.sampled import of_samples
from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.numerics.spacing import WIDEST, find_gap

LEAST = 8
"""Points that a curve must have."""
MOST = 4000
"""Largest number of points: each is a panel of the curve, and costs a millisecond or two."""
SMALLEST_MM, LARGEST_MM, LARGEST_DEG = 1e-2, 1e4, 1e6
CLOSED = 1e-6
"""How far from a turn the last point may be to be the first again [deg]."""
CLOSED_RADIUS = 1e-4
"""Share of the radius by which the row that repeats the first may differ from it."""
OPEN = 1.5
"""Largest step from the last row to the first, in largest steps of the table."""
CROWDED = 0.05
"""Points that are nearer than this share of their mean distance are one."""
MISSED = 5e-5
"""How far a mate that is given may be from the conjugate [m]."""


def load_pair(source: str, mate: str | None, turns: int) -> Pair:
    """The pair of a pitch curve in a file, with its conjugate: `turns` of the gear for one of the mate.

    A mate in a file of its own, whose first point meets the first of the gear, is what the conjugate is held against.
    Raises InputError, naming file and place, for a curve that cannot be read, is no closed turn, or is no mate.
    """
    polar, radius = _curve(source)
    sense = 1 if polar[1] > polar[0] else -1
    found = of_samples(sense * polar, radius, source, turns, sense)
    if mate is not None:
        _check_mate(found, mate)
    return found


def _curve(source: str) -> tuple[Array, Array]:
    """Return polar angles [rad] and radii [m] (n,) over one closed turn, without the row that repeats the first.

    Raises InputError for a table that cannot be read or is not one closed turn.
    """
    path, prefix = _parted(source)
    table = csv_rows.read(text.read_text(path), str(path))
    names = [f"{prefix}_polar_deg" if prefix else "polar_deg", f"{prefix}_radius_mm" if prefix else "radius_mm"]
    missing = [name for name in names if name not in table.header]
    if missing:
        hint = "" if prefix else " (of several curves in a file, name one: FILE:PREFIX)"
        raise InputError(f"{path}: the header has no column {missing[0]}, but {' and '.join(names)} are needed{hint}")
    polar, radius = (np.array(table.numbers(n, most)) for n, most in zip(names, (LARGEST_DEG, LARGEST_MM), strict=True))
    if not LEAST <= len(polar) <= MOST:
        raise InputError(f"{path}: {len(polar)} points are not allowed: there must be {LEAST} to {MOST}")
    steps = np.diff(polar)
    if not ((steps > 0).all() or (steps < 0).all()):
        row = int(np.argmax(steps * np.sign(steps.sum()) <= 0)) + 1
        raise InputError(f"{table.place(row, names[0])}: {polar[row]:g} is not allowed: angles must go one way round")
    if (radius < SMALLEST_MM).any():
        row = int(np.argmax(radius < SMALLEST_MM))
        allowed = f"it must be at least {SMALLEST_MM:g} mm"
        raise InputError(f"{table.place(row, names[1])}: {radius[row]:g} is not allowed: {allowed}")
    turn = abs(polar[-1] - polar[0])
    if turn > 360 + CLOSED:
        raise InputError(f"{path}: {names[0]} goes over {turn:g} deg, but it must be one closed turn")
    if abs(turn - 360) < CLOSED:
        if abs(radius[-1] - radius[0]) > CLOSED_RADIUS * radius[0]:
            allowed = f"it must be {radius[0]:g}, the radius a turn before, where the curve closes"
            raise InputError(f"{table.place(len(radius) - 1, names[1])}: {radius[-1]:g} is not allowed: {allowed}")
        polar, radius = polar[:-1], radius[:-1]
    distinct = _apart(np.abs(polar - polar[0]), 360 * CROWDED / len(polar))
    polar, radius = polar[distinct], radius[distinct]
    _check_turn(str(path), names[0], polar)
    return np.radians(polar), radius * 1e-3


def _check_turn(path: str, name: str, polar: Array) -> None:
    """Raise InputError where distinct polar angles (n,) [deg] do not cover one closed turn."""
    steps = np.abs(np.diff(polar))
    span, widest = float(steps.sum()), float(steps.max())
    if 360 - span > OPEN * widest:
        hint = " (are these radians?)" if abs(span + widest - TURN) < widest else ""
        raise InputError(
            f"{path}: {name} covers {span:.6g} deg, which is not allowed: it must be one closed turn, so that the last "
            f"row is followed by the first within {OPEN:g} of the largest step, {widest:.4g} deg{hint}"
        )
    gap = find_gap(np.append(steps, 360 - span))
    if gap is not None:
        ends = f"{polar[gap]:g} to {polar[(gap + 1) % len(polar)]:g}"
        raise InputError(
            f"{path}: {name} has no row from {ends} deg, which is not allowed: no step may be above {WIDEST:g} times "
            f"the median step of one closed turn"
        )


def _apart(places: Array, least: float) -> list[int]:
    """Numbers of places (n,) that are at least so far from the last that is kept: rounding bends a crowd of points."""
    kept = [0]
    for number in range(1, len(places)):
        if places[number] - places[kept[-1]] >= least:
            kept.append(number)
    return kept


def path_of(source: str) -> Path:
    """The file that a curve is in."""
    return _parted(source)[0]


def _parted(source: str) -> tuple[Path, str]:
    """A path and the prefix of the columns behind it, if there is one."""
    if Path(source).exists():
        return Path(source), ""
    path, colon, prefix = source.rpartition(":")
    return (Path(path), prefix) if colon and Path(path).exists() else (Path(source), "")


def _check_mate(pair: Pair, source: str) -> None:
    """Raise InputError where a mate is not the conjugate of its gear."""
    polar, radius = _curve(source)
    share = np.linspace(0, 1, 4001)
    curve = pair.mate
    rows = curve.at(share * curve.length)
    conjugate = np.interp(np.mod(-pair.sense * np.abs(polar - polar[0]), TURN), rows[POLAR], np.hypot(*rows[:2]))
    missed = np.abs(conjugate - radius)
    worst = int(np.argmax(missed))
    if missed[worst] > MISSED:
        raise InputError(
            f"{source}: at {np.degrees(polar[worst]):.6g} deg the radius is {radius[worst] * 1e3:.6g} mm, but the "
            f"conjugate of the gear has {conjugate[worst] * 1e3:.6g} mm there: it must be within {MISSED * 1e3:g} mm"
        )
