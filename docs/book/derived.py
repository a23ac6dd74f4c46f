"""Machine files of the examples, each derived once in a build."""

from __future__ import annotations

import io
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from derive.__main__ import main as derive

EXAMPLES = Path(__file__).parents[1] / "examples"


@cache
def _scratch() -> TemporaryDirectory[str]:
    return TemporaryDirectory()


@cache
def derive_example(name: str) -> str:
    """Return the machine file of an example, or the name itself if it is a built-in machine. Raises RuntimeError if the
    example cannot be derived.
    """
    example = EXAMPLES / f"{name}.py"
    if not example.is_file():
        return name
    folder = _scratch().name
    with redirect_stdout(io.StringIO()):
        code = derive([str(example), "--out", folder])
    if code:
        raise RuntimeError(f"{example.name}: it was not derived")
    return str(Path(folder, f"{name}.toml"))
