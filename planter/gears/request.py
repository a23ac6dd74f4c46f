"""Requests for gears: options in SI units, pitch curves from files, and the machines whose gears
can be cut.

A machine's package brings a module `toothed` with the functions of `GearMachineAdapter`. A file of
a pitch curve has the columns `polar_deg` and `radius_mm`, optionally with a prefix, `FILE:PREFIX`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np

from planter import text_files
from planter.errors import InputError
from planter.files import csv_rows, examples
from planter.files.examples import load_part
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.pitch_curves import (
    POLAR,
    CurvePair,
    PitchCurve,
    build_sampled_pair,
    find_centre_distance,
    find_repeat,
)
from planter.gears.options import CuttingProcessOption, Keep
from planter.gears.parts import PartSettings
from planter.gears.results import GearsFound
from planter.gears.workshop.drawing import Bore, Keyway, find_standard_keyway
from planter.kernels import Array
from planter.numerics.arrays import MAX_GAP_RATIO, TURN, find_gap
from planter.progress import Listener


@dataclass(frozen=True)
class Teeth:
    """The options of teeth in the units of the command line: mm, deg, modules."""

    pressure_angle: float = 20.0
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    tip_radius: float = 1.0
    backlash_mm: float = 0.0
    centre_error_mm: float = 0.0
    process: CuttingProcessOption = CuttingProcessOption.hob
    allow_undercut: bool = False

    def order(self, teeth: int | None, module_mm: float | None, keep: Keep | None) -> ToothOrder:
        """Return the order for a pair in SI units."""
        options: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        play = options.pop("backlash_mm") * 1e-3
        options.pop("centre_error_mm")
        options["pressure_angle"] = float(np.radians(self.pressure_angle))
        options["process"] = self.process.value
        module = None if module_mm is None else module_mm * 1e-3
        return ToothOrder(
            teeth=teeth, module=module, keep=keep.value if keep else None, play=play, **options
        )


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
    """Options of the command for a machine's gears, in the units of the command line.

    `explicit` names the options of `teeth` that the user set; a machine's file may set the others.
    `modules_mm` and `counts` belong to stages 1 and 2, `changes` are new values of the machine's
    file by name. An adapter refuses options that do not apply to its machines.
    """

    teeth: Teeth
    part_settings: PartSettings
    explicit: frozenset[str] = frozenset()
    modules_mm: tuple[float | None, float | None] = (None, None)
    counts: tuple[int, ...] = ()
    keep: Keep | None = None
    changes: Mapping[str, float] = field(default_factory=dict)
    speed_rpm: float | None = None


class GearMachineAdapter(Protocol):
    """Protocol of the module `toothed` of a kind of machine."""

    def make(
        self,
        source: str,
        options: GearOptions,
        out: Path | None = None,
        progress: Listener | None = None,
    ) -> GearsFound:
        """Return the gears of a machine, and write their files if a folder is given.

        Raises InputError for an invalid file or option, GeometryError for gears that cannot be cut.
        """


def find_adapter(source: str) -> GearMachineAdapter:
    """Return the module of a machine file or built-in name.

    Raises InputError if its kind has none.
    """
    module = load_part(source, "toothed")
    if module is not None:
        return cast(GearMachineAdapter, module)
    text_files.parse_toml(examples.read_source(source), source)
    names = [name for name in examples.list_examples(suffix=".toml") if load_part(name, "toothed")]
    raise InputError(
        f"{source}: `planter gears` does not cut gears of this machine; use one like "
        f"{', '.join(names)}"
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
    if turns.gear > 1 and not turns.is_stated and mate is None:
        _check_turns(sense * polar, radius, source, turns.gear)
    pair = build_sampled_pair(sense * polar, radius, source, turns.gear, sense, turns.mate)
    if mate is not None:
        _check_mate(
            *((pair.mate, -pair.sense) if turns.mate == 1 else (pair.gear, pair.sense)), mate
        )
    return pair


def _check_turns(polar: Array, radius: Array, source: str, turns: int) -> None:
    """Raise InputError if the mate of a curve could turn once in several turns, or several times in
    one.
    """
    worst, later = find_repeat(polar, radius, turns)
    if abs(later - radius[worst]) <= NEARLY_REPEATS * radius[worst]:
        nearer, farther = (
            find_centre_distance(polar, radius, ratio, source)
            for ratio in (1 / turns, float(turns))
        )
        raise InputError(
            f"--turns {turns}: {source} repeats {turns} times in a turn, so its mate may turn "
            f"once in {turns} turns "
            f"(axes {farther * 1e3:.6g} mm apart) or {turns} times in one ({nearer * 1e3:.6g} "
            f"mm): give --turns "
            f"{turns}:1 or --turns 1:{turns}"
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
