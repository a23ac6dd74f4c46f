"""What a command says: one JSON object or tables to standard output, progress and errors to
standard error.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Literal, NoReturn

from planter import safe_text
from planter.errors import ComputationError, InputError, Interrupted, PlanterError
from planter.files import units
from planter.files.record import Record
from planter.progress import Progress
from planter.report import process

Rows = Iterable[Sequence[object]]
DEGREE = units.typeset_unit("deg")


@dataclass(frozen=True)
class Console:
    """Output of one command."""

    as_json: bool

    def result(self, content: Record | dict[str, Any], tables: Callable[[], None]) -> None:
        """Print a result: as JSON, or by `tables`.

        From here on signals do not count: the work is done.
        """
        if process.exit_code() is not None:
            raise Interrupted
        table = content.table() if isinstance(content, Record) else content
        if self.as_json and (infinite := next(_find_infinite(table), "")):
            raise ComputationError(
                f"the result has no finite value of {infinite}, so that it is not shown"
            )
        text = json.dumps(table, indent=2, allow_nan=False) if self.as_json else ""
        process.ignore_signals()
        with process.flush_output():
            if self.as_json:
                print(text)
            else:
                tables()

    def table(self, title: str, header: Sequence[str], rows: Rows) -> None:
        """Print a table; numbers are aligned to the right."""
        from rich.console import Console as Rich
        from rich.table import Table
        from rich.text import Text

        table = Table(header_style="dim", box=None, pad_edge=False)
        listed = [list(row) for row in rows]
        for row in listed:
            row[:] = [
                DEGREE if name == "unit" and cell == "deg" else cell
                for name, cell in zip(header, row, strict=True)
            ]
        for index, name in enumerate(header):
            numeric = any(
                isinstance(row[index], int | float) and not isinstance(row[index], bool)
                for row in listed
            )
            justify: Literal["left", "right"] = "right" if numeric else "left"
            table.add_column(_typeset(name), justify=justify, overflow="fold")
        for row in listed:
            table.add_row(*(_typeset(cell_text(cell)) for cell in row))
        rich = Rich(highlight=False, markup=False, emoji=False)
        if title:  # not the table's own, which rich breaks where a narrow table ends
            rich.print(Text(_typeset(title), style="bold"))
        rich.print(table)
        rich.print()

    def say(self, text: str) -> None:
        """Print a note on standard error."""
        process.print_line(_typeset(text))

    def progress(self, at: Progress) -> None:
        """Tell how far a work is: one line that is written over on a terminal, else ten lines in
        all.
        """
        if sys.stderr.isatty():
            line = safe_text.sanitise_line(str(at))[: shutil.get_terminal_size().columns - 1]
            print(
                f"\r\x1b[2K{line}",
                end="\n" if at.done == at.total else "",
                file=sys.stderr,
                flush=True,
            )
        elif at.done * 10 // at.total > (at.done - 1) * 10 // at.total:
            self.say(str(at))

    @contextmanager
    def outcome(self) -> Iterator[None]:
        """Turn errors into messages and exit codes."""
        try:
            yield
        except Interrupted as stop:
            self.fail(stop)
        except (KeyboardInterrupt, Exception) as error:
            if isinstance(error, KeyboardInterrupt) or process.exit_code() is not None:
                # A solver that swallows the interrupt fails with an error of its own, which has
                # what was found.
                self.fail(Interrupted(getattr(error, "partial", None)))
            if isinstance(error, MemoryError):
                self.fail(ComputationError("there is not enough memory for this"))
            if not isinstance(error, PlanterError):
                raise
            self.fail(error)

    def fail(self, error: PlanterError) -> NoReturn:
        """End with an error's sentence and exit code, with JSON also its object; each signal has a
        different code.
        """
        process.ignore_signals()
        process.print_line(f"planter: {units.typeset_degrees(error.message)}")
        if self.as_json and error.exit_code != InputError.exit_code:
            with suppress(PlanterError), process.flush_output():
                print(json.dumps(error.table(), indent=2, allow_nan=False))
        code = process.exit_code() if isinstance(error, Interrupted) else None
        raise SystemExit(code or error.exit_code)


def _find_infinite(entry: object, place: str = "") -> Iterator[str]:
    """Yield the places of numbers that JSON does not have."""
    if isinstance(entry, float) and not math.isfinite(entry):
        yield place
    elif isinstance(entry, dict):
        for key, value in entry.items():
            yield from _find_infinite(value, f"{place}.{key}" if place else str(key))
    elif isinstance(entry, list | tuple):
        for index, value in enumerate(entry):
            yield from _find_infinite(value, f"{place}[{index}]")


def _typeset(text: str) -> str:
    return units.typeset_degrees(safe_text.sanitise_line(text))


def cell_text(cell: object) -> str:
    """Return a cell as text, numbers with at most six digits.

    >>> cell_text(211.3237944), cell_text(-0.0), cell_text(None), cell_text(True)
    ('211.324', '0', '-', 'yes')
    """
    if cell is None:
        return "-"
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, float):
        return f"{cell + 0.0:.6g}"  # the sum of a negative zero and zero has no sign
    return safe_text.sanitise_line(str(cell))
