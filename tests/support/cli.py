"""The command line called from a test: what it prints, the one object of `--json`, the one sentence
of a refusal.
"""

from __future__ import annotations

import io
import json
import re
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from functools import cache, partial
from typing import Any

import pytest
import typer

from planter import cli
from planter.cli import app
from planter.cli.app import build_application
from planter.report import process
from planter.report.console import Console


@cache
def _commands() -> Callable[..., Any]:
    """All commands, put together once instead of for every call."""
    return typer.main.get_command(build_application())


def split_words(call: str) -> list[str]:
    """Return the words of a command line; those in single quotes may have spaces."""
    return [word.strip("'") for word in re.findall(r"'[^']*'|\S+", call)] if " " in call else [call]


def run(*arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of what a process does, done in this one.

    The first argument may be several words, each further one is a single word.
    """
    words = [word for call in arguments[:1] for word in split_words(call)]
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8", newline="") for _ in range(2))
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["planter", *words, *arguments[1:]])
        patch.setattr(app, "build_application", _commands)
        patch.setattr(process, "listen_signals", lambda: None)
        with pytest.raises(SystemExit) as end:
            cli.main()
    return int(end.value.code or 0), _text(out), _text(err)


def _text(stream: io.TextIOWrapper) -> str:
    stream.flush()
    stream.seek(0)
    return stream.read()


def answer(*arguments: str) -> Any:
    """The object that a call prints with `--json`, alone on standard output; it holds no NaN.

    Its tables for people are put together beside it, and say something.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Console, "result", _both_ways(Console.result))
        code, out, err = run(*arguments, "--json")
    assert code == 0, err
    return json.loads(out, parse_constant=pytest.fail)


def _both_ways(result: Callable[..., None]) -> Callable[..., None]:
    def record_result(console: Console, content: Any, tables: Callable[[], None]) -> None:
        with redirect_stdout(io.StringIO()) as output:
            tables()
        assert output.getvalue().strip(), "nothing is said to people"
        result(console, content, tables)

    return record_result


def refusal(*arguments: str) -> str:
    """The one sentence of a refused call: exit code 2, nothing on standard output, no traceback,
    `--json` or not.
    """
    for extra in ((), ("--json",)):
        code, out, err = run(*arguments, *extra)
        assert (code, out) == (2, ""), (out, err)
        assert err.count("\n") == 1
        assert "Traceback" not in err
    return err.strip()


def below(
    *words: str,
) -> tuple[Callable[..., tuple[int, str, str]], Callable[..., Any], Callable[..., str]]:
    """`run`, `answer` and `refusal` of a command below others."""
    return partial(run, *words), partial(answer, *words), partial(refusal, *words)
