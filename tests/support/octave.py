"""Octave in tests: statements run in a folder of function files."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

EXECUTABLE = shutil.which("octave-cli") or shutil.which("octave")
needed = pytest.mark.skipif(
    EXECUTABLE is None, reason="no Octave here: what is written for MATLAB was not run"
)


def literal(values: object) -> str:
    """A number or a list of numbers, to all digits."""
    return f"[{'; '.join(repr(float(v)) for v in np.ravel(np.asarray(values, dtype=float)))}]"


def run(folder: Path, inputs: Mapping[str, object], statements: str) -> np.ndarray:
    """What the variable `found` holds after the statements, column by column; ``given`` are numbers
    and vectors.
    """
    assert EXECUTABLE is not None
    definitions = "\n".join(f"{name} = {literal(values)};" for name, values in inputs.items())
    script = f"{definitions}\n{statements}\nprintf('%.17g\\n', found);"
    command = [EXECUTABLE, "--no-init-file", "--quiet", "--eval", script]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr
    return np.array(done.stdout.split(), dtype=float)
