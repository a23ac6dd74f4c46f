"""The command line: arguments in, results out. Heavy parts are loaded by the command that needs them."""

from __future__ import annotations

import sys

from planter.errors import InputError


def main() -> None:
    """Entry point: a call that cannot be understood ends in one sentence and exit code 2."""
    from planter.cli.app import application

    try:
        code = application()(standalone_mode=False)
    except Exception as error:
        if not hasattr(error, "format_message"):  # what the command-line library raises for bad arguments has one
            raise
        print(f"planter: {error.format_message()}", file=sys.stderr)
        code = InputError.exit_code
    sys.exit(code)
