"""The command line called from a test: what it prints, the one object of `--json`, the one sentence of a refusal."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from planter.cli.app import application


@cache
def _application() -> typer.Typer:
    return application()


def run(*arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error."""
    result = CliRunner().invoke(_application(), list(arguments))
    return result.exit_code, result.stdout, result.stderr


def answer(*arguments: str) -> Any:
    """The object that a call prints with `--json`, alone on standard output; it holds no NaN."""
    code, out, err = run(*arguments, "--json")
    assert code == 0, err
    return json.loads(out, parse_constant=pytest.fail)


def refusal(*arguments: str) -> str:
    """The one sentence of a refused call: exit code 2, nothing on standard output, no traceback, `--json` or not."""
    for extra in ((), ("--json",)):
        code, out, err = run(*arguments, *extra)
        assert (code, out) == (2, ""), (out, err)
        assert err.count("\n") == 1
        assert "Traceback" not in err
    return err.strip()


def below(*words: str) -> tuple[Callable[..., tuple[int, str, str]], Callable[..., Any], Callable[..., str]]:
    """`run`, `answer` and `refusal` of a command below others."""
    return partial(run, *words), partial(answer, *words), partial(refusal, *words)
