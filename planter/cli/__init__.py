"""The command line: arguments in, results out. Heavy parts are loaded by the command that needs them."""

from __future__ import annotations

from planter.cli import (
    audit,
    bench,
    clutch,
    clutch_engage,
    clutch_field,
    clutch_shape,
    compare,
    examples,
    kernels,
    mapping,
    pickup,
    planting,
)
from planter.cli.app import app
from planter.errors import InputError

__all__ = [
    "app",
    "audit",
    "bench",
    "clutch",
    "clutch_engage",
    "clutch_field",
    "clutch_shape",
    "compare",
    "examples",
    "kernels",
    "main",
    "mapping",
    "pickup",
    "planting",
]


def main() -> None:
    """Entry point: a call that cannot be understood ends in one sentence and exit code 2."""
    import sys

    try:
        code = app(standalone_mode=False)
    except Exception as error:
        if not hasattr(error, "format_message"):  # what the command-line library raises for bad arguments has one
            raise
        print(f"planter: {error.format_message()}", file=sys.stderr)
        code = InputError.exit_code
    sys.exit(code)
