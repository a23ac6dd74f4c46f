"""LabVIEW measurement files (.lvm): a header of keys, then segments with a header, names of columns
and rows each.

The format has three layouts of times: a column for all channels (X_Columns One), one before each
channel (Multi), or none (No), where rows begin with an empty cell and times are X0 + i Delta_X of
the segment. Segments whose times begin anew are moved by their Date and Time. Reference: National
Instruments, Specification for the LabVIEW Measurement File, versions 1 and 2.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from planter.errors import InputError
from planter.files.csv_rows import LONGEST, shorten_text

TITLE = "labview measurement"
END = "***End_of_Header***"
X_VALUE, COMMENT = "X_Value", "Comment"
X_COLUMNS = ("No", "One", "Multi")
SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
SECONDS = "s"
_SHARED = ("Samples", "X_Dimension", "X_Unit_Label", "X0", "Delta_X", "Date", "Time")
"""Keys of a segment's header of which one cell may stand for all channels."""
_SPECIAL = ("***Start_Special***", "***End_Special***")
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_CLOCK = re.compile(r"(\d\d?):(\d\d?):(\d\d?(?:[.,]\d+)?)")


class _Channel(NamedTuple):
    """A channel: its name, its unit, that of its times, and X0 and Delta_X where there is no column
    of times.
    """

    name: str
    unit: str | None
    time_unit: str | None
    step: tuple[float, float] | None


class _Segment(NamedTuple):
    """A segment: its header by key, the line of its names, these, and rows with their lines."""

    header: dict[str, list[str]]
    line: int
    names: list[str]
    rows: list[tuple[int, list[str]]]


@dataclass(frozen=True)
class LabviewTable:
    """Columns with their units, and rows of cells with their lines.

    Times of channels without a column are written.
    """

    separator: str
    decimal: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    header_line: int
    segments: int
    lines: tuple[int, ...]
    rows: tuple[tuple[str, ...], ...]


def is_labview(lines: Sequence[str]) -> bool:
    """Return whether a file says that it is a LabVIEW measurement file."""
    first = next((line for line in lines if line.strip()), "")
    return first.strip(" \t,;").lower() == TITLE


def read_labview(lines: Sequence[str], source: str) -> LabviewTable:
    """Read the lines of a file.

    Raises InputError, which names the line, for what the format does not allow.
    """
    return _LabviewReader(lines, source).read()


class _LabviewReader:
    """The lines of a file with their separator, decimal mark and layout, all from its header."""

    def __init__(self, lines: Sequence[str], source: str) -> None:
        """Read the header of the file."""
        self.lines, self.source = lines, source
        named = next(
            (
                line
                for line in lines
                if line.startswith("Separator") and len(line) > len("Separator")
            ),
            "",
        )
        self.separator = named[len("Separator") :][:1] or "\t"
        end, self.header = self._read_header(0)
        separator = self._choose("Separator", tuple(SEPARATORS), "Tab")
        if SEPARATORS[separator.lower()] != self.separator:
            raise self._refuse(
                "Separator",
                separator,
                f"{self.separator!r} stands behind it; correct the one or other",
            )
        # version 1 has no key for it, and writes that of the system
        cells = (cell for line in lines for cell in self._split(line))
        has_commas = self.separator != "," and any(map(_DECIMAL_COMMA.fullmatch, cells))
        usual = "," if has_commas else "."
        self.decimal = self._choose("Decimal_Separator", (".", ","), usual)
        if self.decimal == self.separator:
            raise self._refuse(
                "Decimal_Separator", self.decimal, "it separates cells too; save the file with tabs"
            )
        self.layout = self._choose("X_Columns", X_COLUMNS, "One")
        self.start = end

    def _refuse(self, key: str, value: str, reason: str) -> InputError:
        return InputError(f"{self.source}: {key} = {shorten_text(value)}: {reason}")

    def _choose(self, key: str, allowed: Sequence[str], default: str) -> str:
        value = (self.header.get(key) or [default])[0]
        match = next((each for each in allowed if each.lower() == value.lower()), None)
        if match is None:
            raise self._refuse(key, value, f"it must be one of {', '.join(allowed)}")
        return match

    def _split(self, line: str) -> list[str]:
        return [cell.strip() for cell in line.split(self.separator)]

    def _read_header(self, begin: int) -> tuple[int, dict[str, list[str]]]:
        """Return the line after the end of a header, and the cells behind each of its keys."""
        header: dict[str, list[str]] = {}
        for index in range(begin, len(self.lines)):
            key, *cells = self._split(self.lines[index])
            if key == END:
                return index + 1, header
            if key:
                header[key] = cells
        raise InputError(
            f"{self.source}: line {begin + 1}: {END} is missing after this header; export the "
            f"file again"
        )

    def read(self) -> LabviewTable:
        """Return the table of all segments."""
        segments = [segment for segment in self._read_segments() if segment.rows]
        if not segments:
            raise InputError(
                f"{self.source}: no row of numbers follows the header; export the measurement again"
            )
        channels = [self._list_channels(segment) for segment in segments]
        columns = self._list_columns(channels[0])
        for segment, each in zip(segments, channels, strict=True):
            if self._list_columns(each) != columns:
                text = ", ".join(map(repr, segment.names))
                raise InputError(
                    f"{self.source}: line {segment.line}: columns {text} and their units are not "
                    f"those of the first "
                    "segment; save segments with other channels as files of their own"
                )
        names, units = zip(*columns, strict=True)
        times = [i for i, name in enumerate(names) if name == X_VALUE]
        parts = [
            self._build_rows(segment, each)
            for segment, each in zip(segments, channels, strict=True)
        ]
        for part, shift in zip(parts, self._find_shifts(segments, parts, times), strict=True):
            for row in part if shift else ():
                for column in times:
                    row[column] = self._move(row[column], shift)
        lines = [line for segment in segments for line, _ in segment.rows]
        rows = [tuple(row) for part in parts for row in part]
        return LabviewTable(
            self.separator,
            self.decimal,
            names,
            units,
            segments[0].line,
            len(segments),
            tuple(lines),
            tuple(rows),
        )

    def _read_segments(self) -> Iterator[_Segment]:
        """Yield the segments.

        A line of names without a header of its own goes on under that of the file.
        """
        index, header, line = self.start, self.header, 0
        names: list[str] | None = None
        rows: list[tuple[int, list[str]]] = []
        is_special = False
        while index < len(self.lines):
            text = self.lines[index]
            cells = self._split(text)
            is_special = (is_special or cells[0] == _SPECIAL[0]) and cells[0] != _SPECIAL[1]
            if is_special or not any(cells) or cells[0] in _SPECIAL:
                index += 1
            elif self._begins_header(cells):
                if names is not None:
                    yield _Segment(header, line, names, rows)
                index, header = self._read_header(index)
                names, rows = None, []
            elif names is None or cells[0] == X_VALUE:
                if names is not None:
                    yield _Segment(header, line, names, rows)
                if cells[0] != X_VALUE:
                    raise InputError(
                        f"{self.source}: line {index + 1} is {shorten_text(text.strip())}; it "
                        f"must name the columns "
                        f"from {X_VALUE} on: export the file with its headers"
                    )
                names, line, rows = self._strip_names(cells), index + 1, []
                index += 1
            else:
                rows.append((index + 1, cells))
                index += 1
        if names is not None:
            yield _Segment(header, line, names, rows)

    def _begins_header(self, cells: Sequence[str]) -> bool:
        return (
            cells[0][:1].isalpha()
            and cells[0] != X_VALUE
            and self._number(cells[0], finite=False) is None
        )

    def _strip_names(self, cells: list[str]) -> list[str]:
        while cells and cells[-1] in ("", COMMENT):
            cells = cells[:-1]
        return cells

    def _list_channels(self, segment: _Segment) -> list[_Channel]:
        """Return the channels of a segment, which its names, its header and the layout must agree
        on.
        """
        names = [name for name in segment.names if name != X_VALUE]
        count, times = len(names), len(segment.names) - len(names)
        stated = (segment.header.get("Channels") or [str(count)])[0]
        if not count or stated != str(count) or times != (count if self.layout == "Multi" else 1):
            raise InputError(
                f"{self.source}: line {segment.line} names {', '.join(map(repr, segment.names))}, "
                f"but Channels is "
                f"{shorten_text(stated)} and X_Columns {self.layout}; correct one of them"
            )
        entries = {
            key: self._spread_entries(segment.header.get(key, []), count, key in _SHARED)
            for key in ("Y_Unit_Label", *_SHARED)
        }
        channels = []
        for i, name in enumerate(names):
            entry = {key: cells[i] for key, cells in entries.items()}
            is_time = entry["X_Dimension"].lower() in ("", "time")
            time_unit = entry["X_Unit_Label"] or (SECONDS if is_time else None)
            step = (
                self._read_step(segment, entry)
                if self.layout == "No" and entry["Samples"] != "0"
                else None
            )
            channels.append(_Channel(name, entry["Y_Unit_Label"] or None, time_unit, step))
        return channels

    def _spread_entries(self, cells: Sequence[str], count: int, is_shared: bool) -> list[str]:
        """Return the cells of a header's key, one for each channel; an only one may stand for
        all.
        """
        filled = [cell for cell in cells if cell]
        if len(filled) == count:
            return filled
        if len(filled) == 1 and is_shared:
            return filled * count
        # with a time of its own a channel has two cells, of which the second is empty
        stride = 2 if self.layout == "Multi" else 1
        return [*cells[::stride], *[""] * count][:count]

    def _read_step(self, segment: _Segment, entry: dict[str, str]) -> tuple[float, float] | None:
        """Return X0 and Delta_X of a channel, None without the latter."""
        if not entry["Delta_X"]:
            return None
        first, step = self._number(entry["X0"] or "0"), self._number(entry["Delta_X"])
        if first is None or step is None or step <= 0:
            raise InputError(
                f"{self.source}: segment above line {segment.line}: X0 = "
                f"{shorten_text(entry['X0'])}, Delta_X = "
                f"{shorten_text(entry['Delta_X'])}: they must be numbers, the second above 0"
            )
        return first, step

    def _list_columns(self, channels: Sequence[_Channel]) -> list[tuple[str, str | None]]:
        """Return names and units of the columns: times where they are stated, and channels."""
        values = [(channel.name, channel.unit) for channel in channels]
        if self._has_own_times(channels):
            times = [(X_VALUE, channel.time_unit) for channel in channels]
            return [column for pair in zip(times, values, strict=True) for column in pair]
        if self.layout == "One" or any(channel.step for channel in channels):
            return [(X_VALUE, channels[0].time_unit), *values]
        return values

    def _has_own_times(self, channels: Sequence[_Channel]) -> bool:
        steps = {channel.step for channel in channels if channel.step}
        return self.layout == "Multi" or len(steps) > 1

    def _number(self, cell: str, finite: bool = True) -> float | None:
        text = cell.replace(",", ".") if self.decimal == "," and "." not in cell else cell
        try:
            number = float(text)
        except ValueError:
            return None
        return number if math.isfinite(number) or not finite else None

    def _write(self, number: float) -> str:
        return repr(number).replace(".", self.decimal)

    def _move(self, cell: str, shift: float) -> str:
        number = self._number(cell)
        return cell if number is None else self._write(number + shift)

    def _build_rows(self, segment: _Segment, channels: Sequence[_Channel]) -> list[list[str]]:
        """Return the rows of a segment, as wide as the columns, with the times that follow from its
        header.
        """
        is_indented = self.layout == "No" and all(not cells[0] for _, cells in segment.rows)
        width = len(channels) if self.layout == "No" else len(segment.names)
        stated = next((channel.step for channel in channels if channel.step), None)
        rows = []
        for i, (line, cells) in enumerate(segment.rows):
            if max(map(len, cells)) > LONGEST:
                raise InputError(
                    f"{self.source}: line {line} has a cell of more than {LONGEST} characters"
                )
            # behind the columns stands the comment, which is no value
            row = [*cells[is_indented:], *[""] * width][:width]
            if stated and self._has_own_times(channels):
                times = [self._write_time(channel.step or stated, i) for channel in channels]
                row = [cell for pair in zip(times, row, strict=True) for cell in pair]
            elif stated:
                row.insert(0, self._write_time(stated, i))
            rows.append(row)
        return rows

    def _write_time(self, step: tuple[float, float], index: int) -> str:
        return self._write(step[0] + index * step[1])

    def _find_shifts(
        self, segments: Sequence[_Segment], parts: Sequence[list[list[str]]], times: Sequence[int]
    ) -> list[float]:
        """Return what is added to the times [s] of each segment, by their clocks if times begin
        anew.
        """
        spans = [[self._number(row[column]) for row in part for column in times] for part in parts]
        finite = [[number for number in span if number is not None] for span in spans]
        if all(max(a) < min(b) for a, b in pairwise([span for span in finite if span])):
            return [0.0] * len(segments)
        clocks = [self._read_clock(segment) for segment in segments]
        if None in clocks:
            index = clocks.index(None)
            raise InputError(
                f"{self.source}: segment above line {segments[index].line}: its times begin anew, "
                f"and it has no Date "
                "and Time that say when; save each segment as a file of its own, or give "
                "--interval-s"
            )
        # days and seconds apart, since seconds over centuries have no microseconds left
        pairs = [clock for clock in clocks if clock is not None]
        shifts = [86_400.0 * (day - pairs[0][0]) + (second - pairs[0][1]) for day, second in pairs]
        moved = [
            [number + shift for number in span] for span, shift in zip(finite, shifts, strict=True)
        ]
        for index, (a, b) in enumerate(pairwise(moved), 1):
            if a and b and not max(a) < min(b):
                raise InputError(
                    f"{self.source}: line {segments[index].line}: by its Date and Time this "
                    f"segment begins before the "
                    "one above ends; save each segment as a file of its own"
                )
        return shifts

    def _read_clock(self, segment: _Segment) -> tuple[int, float] | None:
        """Return the day and the second of it at which a segment begins, None if it does not
        tell.
        """
        date = (segment.header.get("Date") or [""])[0]
        time = _CLOCK.fullmatch((segment.header.get("Time") or [""])[0])
        try:
            day = datetime.date(*map(int, date.split("/"))).toordinal()
        except (ValueError, TypeError):
            return None
        if time is None:
            return None
        seconds = float(time[3].replace(",", "."))
        return day, 3600 * int(time[1]) + 60 * int(time[2]) + seconds
