"""The command line: arguments in, results out.

Heavy parts are loaded by the command that needs them.
"""

from __future__ import annotations

import os
import sys
from typing import Any

from planter.report import process


def main() -> None:
    """Entry point: a call that cannot be understood ends in one sentence and exit code 2, a signal
    in one line.
    """
    process.listen_signals()
    code = _ended()
    if process.exit_code() is not None:
        os._exit(
            code
        )  # an interrupt that passed a text being executed would make Python end by signal 2
    sys.exit(code)


def _ended() -> int:
    from planter import menu
    from planter.report import process
    from planter.report.console import Console
    from planter.text_files import check_arguments

    process.take_any_text()
    try:
        with Console("--json" in sys.argv).outcome():
            check_arguments(sys.argv)
            process.record_command(menu.current_words(sys.argv[1:]))
            with process.flush_output():
                code = _called()
                process.ignore_signals()
            if code == 0 and (note := menu.describe_renaming(sys.argv[1:])):
                process.print_line(f"planter: {note}")  # beside no error, which stands alone
            return code
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    finally:
        process.record_command([])


def _called() -> int:
    from planter.cli.app import build_application
    from planter.errors import InputError

    try:
        code = build_application()(standalone_mode=False) or 0
    except Exception as error:
        if not hasattr(
            error, "format_message"
        ):  # what the command-line library raises for bad arguments has one
            raise
        raise InputError(_describe_usage(error) + _hint()) from None
    if (
        code and process.exit_code() is not None
    ):  # the library ends silently where a signal comes between its own lines
        raise KeyboardInterrupt
    return code


def _describe_usage(error: Any) -> str:
    """Return what is wrong with a call, with the value that is refused or the help to read."""
    from pydantic import ValidationError

    from planter.errors import InputError

    message = str(error.format_message())
    if isinstance(error.__cause__, ValidationError):  # whose messages do not name the value
        cause = error.__cause__.errors()[0]
        reason = cause["msg"].removeprefix("Value error, ").partition(", unable")[0].rstrip(".")
        value = cause["input"]
        reason = reason.replace("Input should", "it must").replace(
            f"{value!r} is not", "it must be"
        )
        name = message.split("'")[1]  # Invalid value for '--samples': ...
        return InputError.for_value(name, value, reason).message
    is_open = message.startswith(("Missing", "Got unexpected", "No such command"))
    if is_open and error.ctx is not None and not message.endswith("?"):
        command = error.ctx.command_path.removeprefix(error.ctx.find_root().info_name)
        return f"{message.rstrip('.')}: see `planter{command} --help`"
    return message


def _hint() -> str:
    """Return the probable meaning of an option's number with a decimal comma."""
    from planter import safe_text

    pointed = (
        safe_text.replace_decimal_comma(argument.rpartition("=")[2]) for argument in sys.argv[1:]
    )
    number = next(filter(None, pointed), None)
    return f" (with a decimal point: {number})" if number else ""
