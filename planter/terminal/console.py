"""What a command says: one JSON object or tables to standard output, progress and errors to standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from planter.errors import InputError, Interrupted, PlanterError

Rows = Iterable[Sequence[object]]


@dataclass(frozen=True)
class Console:
    """Output of one command."""

    as_json: bool

    def result(self, content: dict[str, Any], tables: Callable[[], None]) -> None:
        """Print a result: as JSON, or by `tables`."""
        if self.as_json:
            print(json.dumps(content, indent=2, allow_nan=False))
        else:
            tables()

    def table(self, title: str, header: Sequence[str], rows: Rows) -> None:
        """Print a table; numbers are aligned to the right."""
        from rich.console import Console as Rich
        from rich.table import Table

        table = Table(
            title=title, title_justify="left", title_style="bold", header_style="dim", box=None, pad_edge=False
        )
        listed = [list(row) for row in rows]
        for index, name in enumerate(header):
            numeric = any(isinstance(row[index], int | float) for row in listed)
            table.add_column(name, justify="right" if numeric else "left")
        for row in listed:
            table.add_row(*(shown(cell) for cell in row))
        rich = Rich(highlight=False)
        rich.print(table)
        rich.print()

    def say(self, text: str) -> None:
        """Tell something beside the result, on standard error."""
        print(text, file=sys.stderr)

    def progress(self, text: str, done: int, total: int) -> None:
        """Tell how far a search is: one line that is written over on a terminal, else ten lines in all."""
        if sys.stderr.isatty():
            print(f"\r\x1b[2K{text}", end="\n" if done == total else "", file=sys.stderr, flush=True)
        elif done * 10 // total > (done - 1) * 10 // total:
            self.say(text)

    @contextmanager
    def outcome(self) -> Iterator[None]:
        """Turn errors into messages and exit codes."""
        try:
            yield
        except KeyboardInterrupt:
            self._fail(Interrupted())
        except PlanterError as error:
            self._fail(error)

    def _fail(self, error: PlanterError) -> None:
        self.say(f"planter: {error.message}")
        if self.as_json and error.exit_code != InputError.exit_code:
            described = {"name": error.name, "message": error.message}
            partial = getattr(error, "partial", None)
            print(json.dumps({"error": described, "partial": partial}, indent=2, allow_nan=False))
        raise SystemExit(error.exit_code)


def shown(cell: object) -> str:
    """A cell as text: numbers to six digits.

    >>> shown(211.3237944), shown(12), shown(None)
    ('211.324', '12', '-')
    """
    if cell is None:
        return "-"
    if isinstance(cell, float):
        return f"{cell:.6g}"
    return str(cell)
