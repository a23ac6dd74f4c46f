"""CUDA's text with its words replaced by those of ordinary threads, as a library."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from planter.engine.machine import Machine
from planter.exports import cuda

HOST = Path(__file__).with_name("cuda_on_host.h")
needs_threads = pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler: g++")


def build_on_threads(machine: Machine, folder: Path, *changes: tuple[str, str]) -> Path:
    """Return the library of a machine's text with some changes."""
    ((file, text),) = cuda.build_source_files(machine).items()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    source, library = folder / f"{file}.cc", folder / "on_threads.so"
    source.write_text(f'#include "{HOST}"\n' + re.sub(r"(\w+)<<<(.*?), (\w+)>>>\(", r"launch(\1, \2, \3, ", text))
    command = ["g++", "-std=c++20", "-O0", "-pthread", "-shared", "-fPIC", str(source), "-o", str(library)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return library
