"""Requests for gears: options, and pitch curves from files.

A file of a pitch curve has the columns `polar_deg` and `radius_mm`, optionally with a prefix,
`FILE:PREFIX`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from planter import text_files
from planter.errors import InputError
from planter.files import csv_rows
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.pitch_curves import (
    POLAR,
    CurvePair,
    PitchCurve,
    SampledRadius,
)
from planter.gears.parts import PartSettings
from planter.gears.workshop.drawing import Bore, Keyway, find_standard_keyway
from planter.kernels import Array
from planter.numerics.arrays import MAX_GAP_RATIO, TURN, find_gap


def parse_tooth_counts(argument: str | None, limit: int = 2) -> tuple[int, ...]:
    """Return the tooth counts of `--teeth`. Raises InputError if the text is not Z or Z1,Z2."""
    if argument is None:
        return ()
    counts = [part.strip() for part in argument.split(",")]
    if len(counts) > limit or not all(count.isdecimal() for count in counts):
        raise InputError(
            f"--teeth {argument}: give {' or '.join(('Z', 'Z1,Z2')[:limit])} with integers"
        )
    return tuple(map(int, counts))


def parse_modules(
    both: float | None, first: float | None, second: float | None
) -> tuple[float | None, float | None]:
    """Return the modules [mm] of both stages.

    Raises InputError for `--module` together with one of a stage.
    """
    if both is not None and (first is not None or second is not None):
        raise InputError("--module sets both stages: leave out --module1 and --module2")
    return (both, both) if both is not None else (first, second)


def parse_part_settings(
    tolerance_um: float,
    bore_mm: float | None,
    keyway_mm: str | None,
    width_mm: float,
    step: bool,
    stl: bool,
) -> PartSettings:
    """Return the settings of the files. Raises InputError for an invalid keyway."""
    bore = None
    if bore_mm is not None:
        bore = Bore(bore_mm * 1e-3, _parse_keyway(bore_mm, keyway_mm))
    elif keyway_mm is not None:
        raise InputError(f"--keyway-mm {keyway_mm} needs --bore-mm")
    return PartSettings(tolerance_um * 1e-6, bore, width_mm * 1e-3, step, stl)


def _parse_keyway(bore_mm: float, argument: str | None) -> Keyway | None:
    if argument == "none":
        return None
    if argument is None:
        return Keyway(*find_standard_keyway(bore_mm * 1e-3))
    values = [csv_rows.parse_number(part) for part in argument.split(",")]
    if len(values) != 2 or not all(value is not None and 0 < value < bore_mm for value in values):
        raise InputError(
            f"--keyway-mm {argument}: give WIDTH,DEPTH, both above 0 and below the bore, or none"
        )
    width, depth = (value * 1e-3 for value in values if value is not None)
    return Keyway(width, depth)


@dataclass(frozen=True)
class GearOptions:
    """Options of the command for the gears of a machine or of a curve.

    `explicit` names the values of `order` that the user set; a machine's file may set the others.
    `modules_mm` and `counts` belong to the pairs in their order, `changes` are new values of the
    machine's file by name. A kind of machine refuses options that do not apply to it.
    """

    order: ToothOrder
    explicit: frozenset[str] = frozenset()
    modules_mm: tuple[float | None, float | None] = (None, None)
    counts: tuple[int, ...] = ()
    keep: str | None = None
    changes: Mapping[str, float] = field(default_factory=dict)
    speed_rpm: float | None = None

    def order_pair(self, number: int) -> ToothOrder:
        """Return the order for a pair by its number, from 0."""
        module_mm = self.modules_mm[min(number, 1)]
        return replace(
            self.order,
            teeth=self.counts[number] if self.counts else None,
            module=None if module_mm is None else module_mm * 1e-3,
            keep=self.keep,
        )


MIN_POINTS = 8
"""Smallest number of points of a curve."""
MAX_POINTS = 4000
"""Largest number of points: each is a panel of the curve, and costs a millisecond or two."""
RADIUS_MIN_MM, RADIUS_MAX_MM, ANGLE_MAX_DEG = 1e-2, 1e4, 1e6
CLOSURE_TOLERANCE = 1e-6
"""Deviation from a full turn up to which the last point repeats the first [deg]."""
RADIUS_TOLERANCE = 1e-4
"""Share of the radius by which the row that repeats the first may differ from it."""
CLOSING_STEP = 1.5
"""Largest step from the last row to the first, in largest steps of the table."""
MIN_SPACING = 0.05
"""Share of the mean step below which points are merged."""
MATE_TOLERANCE = 5e-5
"""Largest deviation of a given mate from the conjugate [m]."""


NEARLY_REPEATS = 1e-2
"""Share of the radius within which a curve repeats so that its mate could also be the faster
gear.
"""


@dataclass(frozen=True)
class GearTurns:
    """Turns of a gear and of its mate in the same time, one of which is 1; `is_stated` if both were
    given.
    """

    gear: int = 1
    mate: int = 1
    is_stated: bool = False

    @classmethod
    def parse(cls, argument: str) -> GearTurns:
        """Return the turns of `--turns`, N or GEAR:MATE. Raises InputError for other texts."""
        parts = argument.split(":")
        numbers = [
            int(part) for part in parts if part.isascii() and part.isdecimal() and len(part) <= 2
        ]
        if not (
            len(numbers) == len(parts) <= 2 and all(1 <= number <= MAX_TURNS for number in numbers)
        ):
            raise InputError(
                f"--turns {argument}: give N, N:1 or 1:N with an integer from 1 to {MAX_TURNS}"
            )
        gear, mate = (*numbers, 1)[:2]
        if min(gear, mate) != 1:
            raise InputError(
                f"--turns {argument}: one of both gears must turn once: give N:1 or 1:N"
            )
        return cls(gear, mate, len(parts) == 2)


MAX_TURNS = 20


def load_pair(source: str, mate: str | None, turns: GearTurns = GearTurns()) -> CurvePair:
    """Return the pair of a pitch curve in a file and its conjugate, the faster gear first.

    A mate in a separate file, whose first point meets the first of the gear, is compared with the
    conjugate. Raises InputError, naming file and row, for a curve that cannot be read or is not
    closed, a mate that deviates, or turns that are not clear as the mate could be the slower or the
    faster gear.
    """
    polar, radius = _read_curve(source)
    sense = 1 if polar[1] > polar[0] else -1
    samples = SampledRadius(sense * polar, radius, source, sense)
    if turns.gear > 1 and not turns.is_stated and mate is None:
        _check_turns(samples, turns.gear)
    pair = samples.build_pair(turns.gear, turns.mate)
    if mate is not None:
        number = 1 if turns.mate == 1 else 0
        _check_mate(pair.curves[number], pair.senses[number], mate)
    return pair


def _check_turns(samples: SampledRadius, turns: int) -> None:
    """Raise InputError if the mate of a curve could turn once in several turns, or several times in
    one.
    """
    worst, later = samples.find_repeat(turns)
    radius = samples.radius[worst]
    if abs(later - radius) <= NEARLY_REPEATS * radius:
        nearer = samples.find_centre_distance(1 / turns)
        farther = samples.find_centre_distance(float(turns))
        raise InputError(
            f"--turns {turns}: {samples.name} repeats {turns} times in a turn, so its mate may "
            f"turn once in {turns} turns (axes {farther * 1e3:.6g} mm apart) or {turns} times in "
            f"one ({nearer * 1e3:.6g} mm): give --turns {turns}:1 or --turns 1:{turns}"
        )


def _read_curve(source: str) -> tuple[Array, Array]:
    """Return polar angles [rad] and radii [m] (n,) over one closed turn, without the row that
    repeats the first.

    Raises InputError for a table that cannot be read or is not one closed turn.
    """
    path, prefix = _split_prefix(source)
    table = csv_rows.read_table(text_files.read_text(path), str(path))
    names = [
        f"{prefix}_polar_deg" if prefix else "polar_deg",
        f"{prefix}_radius_mm" if prefix else "radius_mm",
    ]
    missing = [name for name in names if name not in table.header]
    if missing:
        hint = "" if prefix else " (of several curves in a file, name one: FILE:PREFIX)"
        raise InputError(
            f"{path}: the header has no column {missing[0]}, but {' and '.join(names)} are "
            f"needed{hint}"
        )
    polar, radius = (
        np.array(table.numbers(n, limit))
        for n, limit in zip(names, (ANGLE_MAX_DEG, RADIUS_MAX_MM), strict=True)
    )
    if not MIN_POINTS <= len(polar) <= MAX_POINTS:
        raise InputError(f"{path}: {len(polar)} points; a curve needs {MIN_POINTS} to {MAX_POINTS}")
    steps = np.diff(polar)
    if not ((steps > 0).all() or (steps < 0).all()):
        row = int(np.argmax(steps * np.sign(steps.sum()) <= 0)) + 1
        raise InputError(
            f"{table.place(row, names[0])}: {polar[row]:g}: angles must go one way round"
        )
    if (radius < RADIUS_MIN_MM).any():
        row = int(np.argmax(radius < RADIUS_MIN_MM))
        allowed = f"it must be at least {RADIUS_MIN_MM:g} mm"
        raise InputError(f"{table.place(row, names[1])}: {radius[row]:g}: {allowed}")
    turn = abs(polar[-1] - polar[0])
    if turn > 360 + CLOSURE_TOLERANCE:
        raise InputError(
            f"{path}: {names[0]} goes over {turn:g} deg, but it must be one closed turn"
        )
    if abs(turn - 360) < CLOSURE_TOLERANCE:
        if abs(radius[-1] - radius[0]) > RADIUS_TOLERANCE * radius[0]:
            allowed = f"it must be {radius[0]:g}, the radius a turn before, where the curve closes"
            raise InputError(f"{table.place(len(radius) - 1, names[1])}: {radius[-1]:g}: {allowed}")
        polar, radius = polar[:-1], radius[:-1]
    # crowded rows are dropped before the curve is judged: their rounding would bend it
    distinct = _select_distinct(np.abs(polar - polar[0]), 360 * MIN_SPACING / len(polar))
    polar, radius = polar[distinct], radius[distinct]
    _check_turn(str(path), names[0], polar)
    return np.radians(polar), radius * 1e-3


def _check_turn(path: str, name: str, polar: Array) -> None:
    """Raise InputError if distinct polar angles (n,) [deg] do not cover one closed turn."""
    steps = np.abs(np.diff(polar))
    span, widest = float(steps.sum()), float(steps.max())
    if 360 - span > CLOSING_STEP * widest:
        hint = " (are these radians?)" if abs(span + widest - TURN) < widest else ""
        raise InputError(
            f"{path}: {name} covers {span:.6g} deg instead of a closed turn; the step from the "
            f"last row to the "
            f"first must be at most {CLOSING_STEP:g} times the largest step, {widest:.4g} deg{hint}"
        )
    gap = find_gap(np.append(steps, 360 - span))
    if gap is not None:
        ends = f"{polar[gap]:g} to {polar[(gap + 1) % len(polar)]:g}"
        raise InputError(
            f"{path}: {name} has no row from {ends} deg; no step may exceed {MAX_GAP_RATIO:g} "
            f"times the median step "
            f"of one closed turn"
        )


def _select_distinct(angles: Array, min_step: float) -> list[int]:
    """Return indices of angles (n,) [deg] at least `min_step` after the last selected one.

    Rounding would bend the curve through a crowd of points.
    """
    distinct = [0]
    for number in range(1, len(angles)):
        if angles[number] - angles[distinct[-1]] >= min_step:
            distinct.append(number)
    return distinct


def find_curve_path(source: str) -> Path:
    """Return the file that contains a curve."""
    return _split_prefix(source)[0]


def _split_prefix(source: str) -> tuple[Path, str]:
    """Return the path and the prefix of the columns, empty without one."""
    if Path(source).exists():
        return Path(source), ""
    path, colon, prefix = source.rpartition(":")
    return (Path(path), prefix) if colon and Path(path).exists() else (Path(source), "")


def _check_mate(curve: PitchCurve, sense: int, source: str) -> None:
    """Raise InputError if a mate in a file is not the conjugate of its gear, a curve that it passes
    in a sense.
    """
    polar, radius = _read_curve(source)
    # dense enough to interpolate between by a straight line
    share = np.linspace(0, 1, 4001)
    rows = curve.at(share * curve.length)
    conjugate = np.interp(
        np.mod(sense * np.abs(polar - polar[0]), TURN), rows[POLAR], np.hypot(*rows[:2])
    )
    missed = np.abs(conjugate - radius)
    worst = int(np.argmax(missed))
    if missed[worst] > MATE_TOLERANCE:
        raise InputError(
            f"{source}: at {np.degrees(polar[worst]):.6g} deg the radius is "
            f"{radius[worst] * 1e3:.6g} mm, but the "
            f"conjugate of the gear has {conjugate[worst] * 1e3:.6g} mm there: it must be within "
            f"{MATE_TOLERANCE * 1e3:g} mm"
        )
