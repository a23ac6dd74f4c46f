"""Measured curves: columns of a logger's file as quantities over the angle of the drive, and what
was left out.

The angle is a column (counted on, or starting anew every revolution), follows from the time at the
machine's speed, or from a trigger that pulses once a revolution. Of what moves freely there is the
time alone, counted from the first row: its record is a turn. Points of a path need neither. Rows
stay in the order of the file, which is that of the noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from planter.errors import InputError
from planter.files.record import Record
from planter.kernels import Array, Flags, Integers
from planter.measured.logger_table import (
    DroppedRows,
    LoggerTable,
    find_factor,
    list_units,
    read_logger_table,
    split_unit,
)
from planter.numerics.arrays import TURN

FEWEST = 12
"""Minimum number of points of a fit."""
FEWEST_POINTS, PATH_UNIT = 3, "mm"
"""Minimum number of points of a path, and the unit in which they are."""
REACH, OUTSIDE = 2, 6.0
"""Number of neighbours on each side of a point, and robust deviations beyond which it is an
outlier.
"""
GAP, TINY = 12.0, 1e-6
"""Maximum span of four neighbours and minimum distance of two points, in median steps."""
JUMP, STEEPER, JUMP_STEP = 8.0, 4.0, math.radians(3)
"""Least height of a jump in robust deviations of differences, and in differences beside it; largest
step [rad].
"""
TO_SIGMA = 1.4826
"""Ratio of the standard deviation of a normal distribution to its median absolute deviation."""
COARSE = 0.1
"""Share of rows with the stamp of the row before from which on stamps are ticks of a coarse
clock.
"""
UNORDERED = 0.2
"""Share of steps against the direction of rotation from which on rows are no record over time."""
HARMONICS, POINTS_PER_HARMONIC = 40, 6
"""Largest number of harmonics of the mean curve of several revolutions, and least points of a
revolution for each.
"""
TWO_REVOLUTIONS = 1.95
"""Revolutions from which on the scatter about a mean curve is judged; the last may lack a few
points.
"""
PULSE_RATIO = (0.5, 1.6)
"""Intervals between pulses, in medians: below, the second is a bounce; above, one is missing."""
HYSTERESIS = 0.25
"""Share of the height of pulses on each side of their middle that a signal must cross."""
LARGEST_ANGLE = 1e9
"""Angle [rad] above which the digits of a double leave less than 1e-7 rad within a revolution."""
CLOCK_BACK_S = -43_200.0
"""Step of a clock [s] below which midnight has passed."""


@dataclass(frozen=True)
class Columns:
    """Columns of a file, and units that its header lacks.

    One or several columns of values, each with its unit or None; the angle from one of `angle`,
    `time` and `trigger`. With an angle or a trigger, a time says how the speed varies. `interval_s`
    is the time [s] from one row to the next of a file without a column of times.
    """

    value: str | Sequence[str]
    angle: str | None = None
    time: str | None = None
    value_unit: str | Sequence[str | None] | None = None
    place_unit: str | None = None
    trigger: str | None = None
    interval_s: float | None = None

    def check_places(self) -> None:
        """Raise InputError for options of angle and time that exclude each other, or that concern
        neither.
        """
        if self.angle is not None and self.trigger is not None:
            raise InputError(
                "--angle and --trigger both give the angle of the drive: leave one of them out"
            )
        if self.time is not None and self.interval_s is not None:
            raise InputError(
                "--time and --interval-s both give the times of the rows: leave one of them out"
            )
        if self.place_unit is not None and self.angle is None and self.time is None:
            raise InputError(
                "--place-unit is the unit of --angle, else of --time: add one of them or leave it "
                "out"
            )

    @property
    def has_positions(self) -> bool:
        """Whether an angle, a trigger or times of the rows are given."""
        return any(
            each is not None for each in (self.angle, self.time, self.trigger, self.interval_s)
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns of values."""
        return (self.value,) if isinstance(self.value, str) else tuple(self.value)

    @property
    def units(self) -> tuple[str | None, ...]:
        """Units of the columns of values, None for that of the header."""
        if self.value_unit is None or isinstance(self.value_unit, str):
            return (self.value_unit,) * len(self.names)
        units = tuple(self.value_unit)
        if len(units) != len(self.names):
            raise InputError(
                f"--unit is given {len(units)} times, but --column {len(self.names)} times: once "
                f"for each"
            )
        return units


@dataclass(frozen=True)
class Channel:
    """A measured quantity: values (n,) in its display unit `unit`, NaN at gaps, and the points in
    use.

    `noise` is the scatter of neighbours, or, from several revolutions, that about their mean curve,
    whose neighbours are correlated by `rho`; None where one revolution does not tell.
    """

    name: str
    unit: str
    values: Array
    used: Flags
    noise: float
    rho: float | None = None


@dataclass(frozen=True)
class ChannelReading(Record):
    """How a column was read: its unit, points in use, gaps, outliers, and its noise.

    `noise_std` and `noise_rho`, in `unit`, are of the scatter about the mean curve of several
    revolutions; with one revolution `noise_rho` is null and `noise_std` that of neighbours, which
    holds for white noise alone.
    """

    column: str
    unit: str
    used: int
    gaps: int
    outliers: int
    outlier_lines: list[int]
    noise_std: float
    noise_rho: float | None


@dataclass(frozen=True)
class DataColumn(Record):
    """A column of a file: its number from 1, name and unit, and how many of its cells are numbers,
    with their ends.

    `min` and `max` are null without numbers; `text` is the first cell that is neither a number nor
    a gap.
    """

    number: int
    name: str
    unit: str | None
    numbers: int
    min: float | None
    max: float | None
    text: str | None


@dataclass(frozen=True)
class DataReading(Record):
    """The form of a file, its angle and its columns, as understood before anything was fitted, and
    what was dropped.

    `rows` are those of the file, `used` those with an angle and a value; `speed_rpm` are the least,
    mean and greatest speed of a revolution, null unless the file has times. Of what moves freely
    there are `duration_s` and `step_s` instead of revolutions and degrees, of the points of a path
    neither, and no `channels`.
    """

    file: str
    encoding: str
    layout: str
    angle: str
    rows: int
    used: int
    revolutions: float | None
    step_deg: float | None
    speed_rpm: list[float] | None
    dropped: list[DroppedRows]
    channels: list[ChannelReading]
    duration_s: float | None = None
    step_s: float | None = None


@dataclass(frozen=True)
class Measurement:
    """Measured quantities at drive angles (n,) [rad] as counted by the data, in the order of the
    record.

    `speed` (n,) [rad/s] is that of the drive, None if the file does not tell. `treatment` describes
    in sentences how the file was read, `reading` as a record. Of what moves freely a turn is the
    record's `duration` [s], which is None otherwise. Points of a path have the numbers of their rows
    in place of angles.
    """

    phi: Array
    channels: tuple[Channel, ...]
    treatment: tuple[str, ...] = ()
    speed: Array | None = None
    reading: DataReading | None = None
    duration: float | None = None
    is_path: bool = False

    @property
    def values(self) -> Array:
        """Values (n,) of the first quantity."""
        return self.channels[0].values

    @property
    def used(self) -> Flags:
        """Points (n,) of the first quantity that are in use."""
        return self.channels[0].used

    @property
    def noise(self) -> float:
        """Noise of the first quantity."""
        return self.channels[0].noise


@dataclass(frozen=True)
class _Positions:
    """Angles (n,) [rad], NaN if unknown, `order` of the rows, a sentence, speeds (n,) or None,
    dropped rows, and the duration [s] of a record of what moves freely.
    """

    phi: Array
    order: Integers
    note: str
    speed: Array | None = None
    dropped: tuple[DroppedRows, ...] = ()
    duration: float | None = None


def describe_columns(table: LoggerTable) -> list[DataColumn]:
    """Return a description of each column of a file."""
    columns = []
    for index, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        values, text = table.survey_column(index)
        low, high = (float(values.min()), float(values.max())) if len(values) else (None, None)
        columns.append(
            DataColumn(index + 1, split_unit(name)[0], unit, len(values), low, high, text)
        )
    return columns


def read(
    path: str | Path, columns: Columns, speed: float | None, unit: str | Sequence[str] = "N"
) -> Measurement:
    """Read curves from a file; `speed` [rad/s] of the drive converts times to angles, None of what
    moves freely; `unit` is that of each quantity.

    Raises InputError, which names file, line and column, if the file cannot be read, a column or
    unit does not exist, there are too few points, or a cell is not a number.
    """
    return read_curves(read_logger_table(path), columns, speed, unit)


def read_curves(
    table: LoggerTable, columns: Columns, speed: float | None, unit: str | Sequence[str] = "N"
) -> Measurement:
    """Read curves from a table as `read` does."""
    path = table.source
    units = (unit,) * len(columns.names) if isinstance(unit, str) else tuple(unit)
    indices = [table.find_column(name, "--column") for name in columns.names]
    positions = _find_positions(table, columns, speed)
    dropped = [*table.dropped, *positions.dropped]
    retained = positions.order[np.isfinite(positions.phi[positions.order])]
    lines = np.array(table.lines)
    lost = np.sort(positions.order[~np.isfinite(positions.phi[positions.order])])
    if len(lost) > sum(entry.count for entry in positions.dropped):
        dropped.append(DroppedRows.at_lines("rows without an angle", lines[lost].tolist()))
    if len(retained) < FEWEST:
        raise InputError(f"{path}: {len(retained)} points are too few; a fit needs {FEWEST}")
    phi = positions.phi[retained]
    channels, readings, notes = [], [], []
    for column, display, unit_option in zip(indices, units, columns.units, strict=True):
        factor, name = _factor(table, column, list_units(display), unit_option, "--unit")
        numbers, overflows = table.read_numbers(column)
        if overflows:
            dropped.append(
                DroppedRows.at_lines(
                    f"overflow of the logger in {table.names[column]}", lines[overflows].tolist()
                )
            )
        values = numbers[retained] * factor
        name_of_column = split_unit(table.names[column])[0]
        _check_count(path, name_of_column, int(np.isfinite(values).sum()))
        channel, beside_jumps = _build_channel(name_of_column, display, values, phi)
        finite = np.isfinite(channel.values)
        if beside_jumps.any():
            reason = f"values of {channel.name} beside a jump, where a step of the angle decides"
            dropped.append(
                DroppedRows.at_lines(reason, np.sort(lines[retained][beside_jumps]).tolist())
            )
        outliers = np.flatnonzero(finite & ~channel.used & ~beside_jumps)
        _check_count(path, channel.name, int(channel.used.sum()))
        channels.append(channel)
        outlier_lines = np.sort(lines[retained][outliers])
        readings.append(
            ChannelReading(
                channel.name,
                display,
                int(channel.used.sum()),
                int((~finite).sum()),
                len(outliers),
                outlier_lines[:100].tolist(),
                channel.noise,
                channel.rho,
            )
        )
        notes.append(f"{channel.name} in {name}: not smoothed; {_describe_outliers(readings[-1])}")
    revolutions = float(np.ptp(phi) / TURN)
    step, duration = float(np.median(np.abs(np.diff(phi)))), positions.duration
    reading = DataReading(
        file=path,
        encoding=table.encoding,
        layout=table.describe(),
        angle=positions.note,
        rows=len(table.rows),
        used=int(np.any([channel.used for channel in channels], axis=0).sum())
        if channels
        else len(retained),
        revolutions=revolutions if duration is None else None,
        step_deg=float(np.degrees(step)) if duration is None else None,
        speed_rpm=None if positions.speed is None else _summarise_speed(positions.speed[retained]),
        dropped=dropped,
        channels=readings,
        duration_s=duration,
        step_s=None if duration is None else step / TURN * duration,
    )
    treatment = (table.describe(), positions.note, *notes, *map(describe_dropped, dropped))
    return Measurement(
        phi,
        tuple(channels),
        treatment,
        None if positions.speed is None else positions.speed[retained],
        reading,
        duration,
    )


def read_path(table: LoggerTable, columns: Columns) -> Measurement:
    """Read the points of a path from a table, whose two columns of values are x and y.

    A row without one of them is left out, and no point counts as an outlier. Raises InputError as
    `read`.
    """
    columns.check_places()
    names, units_of_columns, coordinates = [], [], []
    for name, unit_option in zip(columns.names, columns.units, strict=True):
        column = table.find_column(name, "--column")
        factor, unit = _factor(table, column, list_units(PATH_UNIT), unit_option, "--unit")
        names.append(split_unit(table.names[column])[0])
        units_of_columns.append(unit)
        coordinates.append(table.read_numbers(column)[0] * factor)
    has_both = np.isfinite(coordinates).all(axis=0)
    rows, dropped = np.flatnonzero(has_both), list(table.dropped)
    if not has_both.all():
        lines = np.array(table.lines)[~has_both].tolist()
        dropped.append(DroppedRows.at_lines("rows without both coordinates", lines))
    if len(rows) < FEWEST_POINTS:
        raise InputError(
            f"{table.source}: {len(rows)} points are too few; a path needs {FEWEST_POINTS}"
        )
    described = ", ".join(
        f"{name} in {unit}" for name, unit in zip(names, units_of_columns, strict=True)
    )
    note = f"points of a path, to which no angle belongs: {described}; none removed as outliers"
    used = np.ones(len(rows), dtype=bool)
    channels = [
        Channel(name, PATH_UNIT, values[rows], used, 0.0)
        for name, values in zip(names, coordinates, strict=True)
    ]
    reading = DataReading(
        file=table.source,
        encoding=table.encoding,
        layout=table.describe(),
        angle=note,
        rows=len(table.rows),
        used=len(rows),
        revolutions=None,
        step_deg=None,
        speed_rpm=None,
        dropped=dropped,
        channels=[],
    )
    treatment = (table.describe(), note, *map(describe_dropped, dropped))
    return Measurement(
        rows.astype(float), tuple(channels), treatment, reading=reading, is_path=True
    )


def _check_count(path: str, column: str, count: int) -> None:
    if count < FEWEST:
        raise InputError(
            f"{path}: column {column}: {count} points are too few; a fit needs {FEWEST}"
        )


def describe_dropped(entry: DroppedRows) -> str:
    """Return a sentence on rows that were left out.

    >>> describe_dropped(DroppedRows("rows without an angle", 2, [7, 9]))
    '2 rows left out: rows without an angle (lines 7, 9)'
    """
    more = ", ..." if entry.count > len(entry.lines) else ""
    rows, lines = (
        "row" if entry.count == 1 else "rows",
        "line" if len(entry.lines) == 1 else "lines",
    )
    return (
        f"{entry.count} {rows} left out: {entry.reason} ({lines} "
        f"{', '.join(map(str, entry.lines))}{more})"
    )


def _describe_outliers(reading: ChannelReading) -> str:
    total = reading.used + reading.outliers
    outliers = (
        f"{reading.outliers} of {total} points removed as outliers"
        if reading.outliers
        else "no outliers removed"
    )
    gaps = f"{reading.gaps} {'gap' if reading.gaps == 1 else 'gaps'}; " if reading.gaps else ""
    return f"{gaps}{outliers} (test: {OUTSIDE:g} robust sigma from a local cubic)"


def _summarise_speed(speed: Array) -> list[float]:
    rpm = speed * 30 / np.pi
    return [float(rpm.min()), float(rpm.mean()), float(rpm.max())]


def _factor(
    table: LoggerTable, column: int, units: dict[str, float], unit_option: str | None, option: str
) -> tuple[float, str]:
    """Return the factor and the unit of a column, by its option, else by its header."""
    header_unit, name = table.units[column], table.names[column]
    unit = unit_option if unit_option is not None else header_unit
    if unit is None and "1" in units:
        return units["1"], "parts of one"
    factor = None if unit is None else find_factor(units, unit)
    if unit is None or factor is None:
        if unit_option is not None:
            problem = f"{option} = {unit_option} does not fit"
        else:
            problem = (
                "has no unit" if header_unit is None else f"the unit {header_unit} does not fit"
            )
        raise InputError(
            f"{table.source}: column {name}: {problem}: {option} must be one of {', '.join(units)}"
        )
    return factor, unit


def _find_positions(table: LoggerTable, columns: Columns, speed: float | None) -> _Positions:
    """Return the angles of all rows. Raises InputError if no column gives them."""
    columns.check_places()
    time = _read_times(table, columns)
    if speed is None:
        return _count_time(table, columns, time)
    if columns.angle is None and columns.trigger is None and time is None:
        raise InputError(
            f"{table.source}: add --angle, --time or --trigger with the column of the angle, the "
            f"time, or a pulse "
            "once a revolution, or --interval-s with the time from row to row; the columns are "
            f"{', '.join(map(repr, table.names))}"
        )
    if columns.trigger is not None:
        return _follow_trigger(table, columns.trigger, time)
    if columns.angle is not None:
        return _follow_angle(table, columns, time)
    assert time is not None
    seconds, note, dropped = time
    _check_angles(
        table,
        None if columns.time is None else table.find_column(columns.time, "--time"),
        seconds * speed,
    )
    note = f"angle by the time {note} at {speed * 30 / np.pi:g} r/min"
    return _Positions(seconds * speed, np.arange(len(seconds)), note, None, dropped)


def _count_time(
    table: LoggerTable, columns: Columns, time: tuple[Array, str, tuple[DroppedRows, ...]] | None
) -> _Positions:
    """Return the times of all rows as angles of a turn, which is the record."""
    if columns.angle is not None or columns.trigger is not None:
        option = "--trigger" if columns.angle is None else "--angle"
        raise InputError(
            f"{table.source}: {option} does not apply to what moves freely, which no angle drives; "
            f"name the column of the time by --time"
        )
    if time is None:
        raise InputError(
            f"{table.source}: add --time with the column of the time, or --interval-s with the "
            f"time from row to row; the columns are {', '.join(map(repr, table.names))}"
        )
    seconds, note, dropped = time
    duration = float(np.nanmax(seconds, initial=0.0))
    if not duration > 0:
        raise InputError(f"{table.source}: the times of all rows are equal; name another column")
    note = f"time {note}, counted from the first row"
    phi = seconds * (TURN / duration)
    return _Positions(phi, np.arange(len(seconds)), note, None, dropped, duration)


def _read_times(
    table: LoggerTable, columns: Columns
) -> tuple[Array, str, tuple[DroppedRows, ...]] | None:
    """Return times (n,) [s] from the first on, NaN where there is none, their column and what was
    dropped.

    Returns None if neither a column nor an interval gives them.
    """
    if columns.interval_s is not None:
        seconds = columns.interval_s * np.arange(len(table.rows), dtype=float)
        return seconds, f"of rows {columns.interval_s:g} s apart", ()
    if columns.time is None:
        return None
    column = table.find_column(columns.time, "--time")
    is_clock = any(":" in row[column] for row in table.rows[:1])
    # with an angle, --place-unit is that of the angle
    unit = columns.place_unit if columns.angle is None else None
    factor, name = (
        (1.0, "clock times")
        if is_clock
        else _factor(table, column, list_units("s"), unit, "--place-unit")
    )
    seconds = table.read_numbers(column)[0] * factor
    finite = np.flatnonzero(np.isfinite(seconds))
    steps = np.diff(seconds[finite])
    if is_clock and (steps < CLOCK_BACK_S).any():
        seconds[finite[1:]] += 86_400.0 * np.cumsum(steps < CLOCK_BACK_S)
        steps = np.diff(seconds[finite])
    if (steps < 0).any():
        row = int(finite[1 + int(np.argmax(steps < 0))])
        place = f"{table.source}: line {table.lines[row]}, column {table.names[column]}"
        raise InputError(
            f"{place}: the time {table.rows[row][column]} is before that of the row above; cut "
            f"the file here"
        )
    seconds, note, dropped = _separate_stamps(table, seconds)
    return (
        seconds - np.nanmin(seconds),
        f"in {split_unit(table.names[column])[0]} in {name}{note}",
        dropped,
    )


def _separate_stamps(
    table: LoggerTable, stamps: Array
) -> tuple[Array, str, tuple[DroppedRows, ...]]:
    """Return stamps of which none equals that of the row before, NaN for dropped rows.

    Ticks of a coarse clock are spread evenly; of a few repeated stamps the first stays.
    """
    rows = np.flatnonzero(np.isfinite(stamps))
    repeated = np.concatenate([[False], np.diff(stamps[rows]) == 0])
    if not repeated.any():
        return stamps, "", ()
    if repeated.mean() >= COARSE:
        ticks = np.flatnonzero(~repeated)
        if len(ticks) < 2:
            raise InputError(f"{table.source}: all rows have the same stamp; name another column")
        spread = stamps.copy()
        # behind the last tick rows go on with the mean step
        mean_step = (stamps[rows[ticks[-1]]] - stamps[rows[ticks[0]]]) / (ticks[-1] - ticks[0])
        inside = np.interp(np.arange(len(rows)), ticks, stamps[rows[ticks]])
        beyond = np.maximum(np.arange(len(rows)) - ticks[-1], 0) * mean_step
        spread[rows] = inside + beyond
        share = (
            f"{100 * repeated.mean():.0f} % of the rows repeat the stamp above and are spread "
            f"between its ticks"
        )
        return spread, f", coarse: {share}", ()
    single = stamps.copy()
    single[rows[repeated]] = np.nan
    lines = [table.lines[row] for row in rows[repeated]]
    return single, "", (DroppedRows.at_lines("rows with the stamp of the row above", lines),)


def _follow_angle(
    table: LoggerTable, columns: Columns, time: tuple[Array, str, tuple[DroppedRows, ...]] | None
) -> _Positions:
    assert columns.angle is not None
    column = table.find_column(columns.angle, "--angle")
    factor, unit = _factor(table, column, list_units("rad"), columns.place_unit, "--place-unit")
    angles = table.read_numbers(column)[0] * factor
    _check_angles(table, column, angles)
    name, finite = split_unit(table.names[column])[0], np.flatnonzero(np.isfinite(angles))
    steps = np.diff(angles[finite])
    wraps = np.abs(steps) > TURN / 2
    counted = angles.copy()
    if wraps.any() and np.ptp(angles[finite]) <= TURN * (1 + TINY):
        counted[finite] = np.unwrap(angles[finite])
        steps = np.diff(counted[finite])
    moving = steps[steps != 0]
    backwards = float(min((moving > 0).mean(), (moving < 0).mean())) if len(moving) else 0.0
    if backwards > UNORDERED:
        order = finite[np.argsort(angles[finite], kind="stable")]
        note = f"angle in {name}, in {unit}: rows in no order, sorted by their angle"
        return _Positions(angles, order, note)
    separated, coarse, dropped = _separate_stamps(table, counted)
    begins_anew = (
        " and begins anew each revolution"
        if counted is not angles and (counted != angles).any()
        else ""
    )
    falls = ", falls" if len(moving) and np.median(moving) < 0 else ""
    note = f"angle in {name}, in {unit}{falls}{begins_anew}{coarse}"
    return _Positions(
        separated,
        np.arange(len(angles)),
        note,
        None if time is None else _compute_speed(separated, time[0]),
        dropped,
    )


def _check_angles(table: LoggerTable, column: int | None, angles: Array) -> None:
    """Raise InputError for angles [rad] of a column, or of an interval, without digits within a
    revolution.
    """
    farthest = float(np.nanmax(np.abs(angles), initial=0.0))
    if farthest > LARGEST_ANGLE:
        place = "--interval-s" if column is None else f"column {table.names[column]}"
        raise InputError(
            f"{table.source}: {place}: the angle of the drive reaches {farthest:.3g} rad; it must "
            f"stay below "
            f"{LARGEST_ANGLE:g} rad: correct the numbers or their unit"
        )


def _compute_speed(phi: Array, seconds: Array) -> Array:
    """Return the speed (n,) [rad/s] from the times of whole revolutions, smooth between them."""
    good = np.isfinite(phi) & np.isfinite(seconds)
    if not good.any():
        raise InputError("no row has both an angle and a time; leave out --time")
    angles, times = np.abs(phi[good] - phi[good][0]), seconds[good]
    ordered = np.maximum.accumulate(angles)
    full = np.arange(0, np.floor(ordered[-1] / TURN) + 1) * TURN
    increasing = np.concatenate([[True], np.diff(ordered) > 0])
    if len(full) < 2:
        span = times[-1] - times[0]
        if not span > 0:
            raise InputError("the times of all rows are equal; leave out --time")
        return np.full(len(phi), ordered[-1] / span)
    at = np.interp(full, ordered[increasing], times[increasing])
    mean = TURN / np.diff(at)
    middle = (at[1:] + at[:-1]) / 2
    filled = np.interp(np.arange(len(seconds)), np.flatnonzero(good), times)
    return np.interp(filled, middle, mean)


def _follow_trigger(
    table: LoggerTable, trigger: str, time: tuple[Array, str, tuple[DroppedRows, ...]] | None
) -> _Positions:
    """Return angles between pulses, each of which ends a revolution."""
    column = table.find_column(trigger, "--trigger")
    signal = table.read_numbers(column)[0]
    count, name = len(signal), table.names[column]
    clock = np.arange(count, dtype=float) if time is None else time[0]
    good = np.flatnonzero(np.isfinite(signal) & np.isfinite(clock))
    pulses, lines = _find_pulses(signal[good], clock[good]), np.array(table.lines)
    if len(pulses) < 3:
        raise InputError(
            f"{table.source}: column {name}: {len(pulses)} pulses; a trigger must rise at least "
            f"three times, once a "
            "revolution: name another column, or use --angle or --time"
        )
    intervals = np.diff(pulses)
    bounces = np.concatenate([[False], intervals < PULSE_RATIO[0] * np.median(intervals)])
    pulses = pulses[~bounces]
    intervals = np.diff(pulses)
    is_single = intervals <= PULSE_RATIO[1] * np.median(intervals)
    counts = np.concatenate(
        [[0], np.cumsum(np.where(is_single, 1, np.round(intervals / np.median(intervals))))]
    )
    follow = scipy.interpolate.PchipInterpolator(pulses, counts * TURN)
    phi = np.full(count, np.nan)
    inside = good[(clock[good] >= pulses[0]) & (clock[good] <= pulses[-1])]
    phi[inside] = follow(clock[inside])
    dropped = list(time[2] if time else ())
    outside = np.setdiff1d(good, inside)
    if len(outside):
        dropped.append(
            DroppedRows.at_lines(
                "rows before the first or after the last pulse of the trigger",
                lines[outside].tolist(),
            )
        )
    speed = None
    if time is not None:
        speed = np.full(count, np.nan)
        speed[inside] = follow(clock[inside], 1)
    for begin in np.flatnonzero(~is_single):
        lost = inside[(clock[inside] > pulses[begin]) & (clock[inside] < pulses[begin + 1])]
        phi[lost] = np.nan
        dropped.append(
            DroppedRows.at_lines(
                "rows between pulses of which one is missing", lines[lost].tolist()
            )
        )
    over = f"time {time[1]}" if time else "rows at equal intervals of time"
    bounced = f", {int(bounces.sum())} bounces ignored" if bounces.any() else ""
    note = (
        f"angle by {len(pulses)} pulses of the trigger {name}, once a revolution{bounced}; "
        f"between them {over}"
    )
    return _Positions(phi, np.arange(count), note, speed, tuple(dropped))


def _find_pulses(signal: Array, clock: Array) -> Array:
    """Return the times at which a signal rises through its middle, by interpolation."""
    low, high = (float(signal.min()), float(signal.max())) if len(signal) else (0.0, 0.0)
    if high == low:
        return np.empty(0)
    middle, margin = (low + high) / 2, HYSTERESIS * (high - low)
    times, armed = [], False
    for i in range(1, len(signal)):
        armed = armed or signal[i - 1] < middle - margin
        if armed and signal[i] > middle + margin:
            j = i
            while j > 0 and signal[j - 1] > middle:
                j -= 1
            share = (middle - signal[j - 1]) / (signal[j] - signal[j - 1])
            times.append(clock[j - 1] + share * (clock[j] - clock[j - 1]))
            armed = False
    return np.array(times)


def _build_channel(name: str, unit: str, values: Array, phi: Array) -> tuple[Channel, Flags]:
    """Return a channel without outliers and points beside jumps, with its noise, and the mask (n,)
    of the latter.
    """
    finite = np.flatnonzero(np.isfinite(values))
    beside_jumps, used = np.zeros((2, len(values)), dtype=bool)
    piece, beside_jumps[finite] = _split_at_jumps(phi[finite], values[finite])
    piece_angles = phi[finite] + TURN * piece  # no cubic of the test passes a jump
    used[finite], noise = _inliers(piece_angles, values[finite])
    used &= ~beside_jumps
    repeats = estimate_repeat_noise(phi[used], values[used])
    return Channel(name, unit, values, used, *(repeats or (noise, None))), beside_jumps


def _split_at_jumps(phi: Array, values: Array) -> tuple[Integers, Flags]:
    """Return the number of the piece between jumps of each point (n,), and the points within a step
    of a jump.

    A jump passes within two steps of a fine record, and is far higher than the differences beside
    it: a friction that turns, a load that ends. A spike is none.
    """
    count, steps = len(values), np.diff(values)
    piece, near_jump = np.zeros(count, dtype=int), np.zeros(count, dtype=bool)
    if count < FEWEST or np.median(np.abs(np.diff(phi))) > JUMP_STEP:
        return piece, near_jump
    scatter = TO_SIGMA * float(np.median(np.abs(steps - np.median(steps))))
    sizes = np.abs(steps)
    for width in (1, 2):
        heights = np.abs(values[width:] - values[:-width])
        inner = np.arange(2, len(heights) - 2)
        sides = np.array([sizes[inner + shift] for shift in (-2, -1, width, width + 1)]).max(axis=0)
        jumps = inner[
            (heights[inner] > JUMP * scatter) & (heights[inner] > STEEPER * sides) & (scatter > 0)
        ]
        for first in jumps:
            near_jump[first - 1 : first + width + 2] = True
    piece[1:] = np.cumsum(np.diff(near_jump.astype(int)) == 1)
    return piece, near_jump


def find_repeat_residuals(phi: Array, values: Array) -> Array | None:
    """Return the scatter of values (n,) about their mean curve over revolutions.

    That is a Fourier series by least squares, and where the record is fine also the mean of what
    this leaves at each angle, which is much at a jump. Returns None for less than two revolutions,
    and for too few points.
    """
    if not len(phi) or np.ptp(phi) / TURN < TWO_REVOLUTIONS:
        return None
    basis = fourier_basis(phi, count_mean_harmonics(phi))
    if len(phi) < 2 * basis.shape[1]:
        return None
    residuals: Array = values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    step = float(np.median(np.abs(np.diff(phi))))
    if not step > 0:  # most points repeat their angle, and no bins have a width
        return residuals * np.sqrt(len(phi) / (len(phi) - basis.shape[1]))
    bins = np.floor(np.mod(phi, TURN) / step).astype(int)
    counts = np.bincount(bins)[bins]
    if np.median(counts) < 2:
        return residuals * np.sqrt(len(phi) / (len(phi) - basis.shape[1]))
    means = np.bincount(bins, residuals)[bins] / counts
    return (residuals - means) * np.sqrt(counts / np.maximum(counts - 1, 1))


def estimate_repeat_noise(phi: Array, values: Array) -> tuple[float, float] | None:
    """Return the scatter of values (n,) about their mean curve over revolutions, and the
    correlation of neighbours.

    Returns None for less than two revolutions.
    """
    residuals = find_repeat_residuals(phi, values)
    if residuals is None:
        return None
    total = float(residuals @ residuals)
    rho = float(residuals[1:] @ residuals[:-1] / total) if total else 0.0
    return float(np.sqrt(total / len(phi))), rho


def count_mean_harmonics(phi: Array) -> int:
    """Return the number of harmonics of the mean curve of points at angles (n,) [rad] over several
    revolutions.
    """
    return int(min(HARMONICS, len(phi) * TURN / np.ptp(phi) / POINTS_PER_HARMONIC))


def fourier_basis(phi: Array, count: int, first: int = 1) -> Array:
    """Return a constant, cosines and sines of harmonics from the `first` on as columns (n, 1 + 2
    count).
    """
    orders = np.outer(phi, np.arange(first, first + count))
    return np.column_stack([np.ones(len(phi)), np.cos(orders), np.sin(orders)])


def _inliers(phi: Array, values: Array) -> tuple[Flags, float]:
    """Return the mask (n,) of points near the cubic through their neighbours, and the scatter about
    such cubics.

    An outlier bends the cubics of its neighbours too, so that only the worst of close points is
    left out. Points at the ends, next to a gap or measured twice are not tested.
    """
    deviations, tested = _deviations(phi, values)
    noise = TO_SIGMA * float(np.median(np.abs(deviations[tested]))) if tested.any() else 0.0
    size = np.where(tested, np.abs(deviations), 0.0)
    largest = np.lib.stride_tricks.sliding_window_view(np.pad(size, REACH), 2 * REACH + 1).max(
        axis=1
    )
    return ~((size > OUTSIDE * noise) & (size == largest) & (noise > 0)), noise


def _deviations(phi: Array, values: Array) -> tuple[Array, Flags]:
    """Return the scaled distance of each point from the cubic through two neighbours on each
    side.
    """
    count = len(phi)
    inner = np.arange(REACH, count - REACH)
    neighbours = inner + np.array([-2, -1, 1, 2])[:, None]
    x, steps = phi[neighbours] - phi[inner], np.abs(np.diff(phi))
    span, median_step = np.abs(x[-1] - x[0]), float(np.median(steps))
    good = (
        (span < GAP * median_step)
        & (np.abs(np.diff(phi[neighbours], axis=0)) > TINY * median_step).all(axis=0)
        & (x != 0).all(axis=0)
    )
    weights = np.ones_like(x)
    for j, k in ((j, k) for j in range(4) for k in range(4) if j != k):
        weights[j, good] *= -x[k, good] / (x[j, good] - x[k, good])
    deviations, tested = np.zeros(count), np.zeros(count, dtype=bool)
    deviations[inner] = (values[inner] - (weights * values[neighbours]).sum(axis=0)) / np.sqrt(
        1 + (weights**2).sum(axis=0)
    )
    tested[inner] = good
    return deviations, tested
