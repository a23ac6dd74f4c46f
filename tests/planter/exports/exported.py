"""Mechanisms of one's own in tests of exports: files with other values and a sum to minimise, their
C as a library.
"""

from __future__ import annotations

import ctypes
import re
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from planter.engine.machine import Machine, load_machine
from planter.kernels import Array
from tests.support import own
from tests.support.cli import answer
from tests.support.lanes import STRICT, path_of

SUMS = {
    "slider_crank": "0.1 range F_Ox + 0.9 rms M_in + 2 max abs F_Ay",
    "transplanting_arm": "std x_tip + 3 work M_in + 0.5 y_tip at 90",
    "cam_follower": "variance N_cam + mean s - 0.5 min N_cam",
    "planetary_train": "range y_tip + 2 rms F_NP",
}
"""A sum of measures for each mechanism: all kinds, forces with friction, closed loops, a place at
an angle.
"""
VALUES = {
    "slider_crank": ("m_r_kg = 0.8", "m_r_kg = 0.93"),
    "transplanting_arm": ("m_b_kg = 0.82", "m_b_kg = 0.7"),
}
"""Numbers that differ from the example's."""
SAMPLES = 45


@cache
def machine_file(name: str, objective: bool = True) -> Path:
    """The file of an example with other values and its sum, in a folder of its own."""
    folder = own.generated(name)
    text = (folder / f"{name}.toml").read_text(encoding="utf-8")
    if name in VALUES:
        assert VALUES[name][0] in text
        text = text.replace(*VALUES[name])
    text = text.replace("[values]", f'folder = "{folder}"\n\n[values]', 1)
    if objective:
        text += f'\n[objective]\nleast = "{SUMS[name]}"\nsamples = {SAMPLES}\n'
    path = Path(mkdtemp()) / f"my_{name}.toml"
    path.write_text(text.replace(f'name = "{name}"', f'name = "My {name}, 2"'), encoding="utf-8")
    return path


@cache
def machine(name: str) -> Machine:
    return load_machine(str(machine_file(name)))


@cache
def c_files(name: str) -> tuple[Path, ...]:
    """What `planter export c` writes."""
    return tuple(
        map(Path, answer("export", "c", str(machine_file(name)), "--out", mkdtemp())["files"])
    )


class Library:
    """The C of a mechanism, compiled without passes and called."""

    def __init__(self, files: Sequence[Path], *changes: tuple[str, str]) -> None:
        self.name = files[0].stem
        header, source = (path.read_text(encoding="utf-8") for path in files[:2])
        for old, new in changes:
            assert old in source
            source = source.replace(old, new, 1)
        folder = Path(mkdtemp())
        for file, text in ((f"{self.name}.h", header), (f"{self.name}.c", source)):
            (folder / file).write_text(text, encoding="utf-8")
        library = folder / "library.so"
        flags = [flag for flag in STRICT if flag != "-O2"]
        command = [
            path_of("gcc"),
            *flags,
            "-O0",
            "-shared",
            "-fPIC",
            str(folder / f"{self.name}.c"),
            "-lm",
        ]
        subprocess.run([*command, "-o", str(library)], check=True, capture_output=True, text=True)
        self.raw = ctypes.CDLL(str(library))
        self.sizes = {
            key: int(value)
            for key, value in re.findall(rf"{self.name.upper()}_(\w+) = (\d+)", header)
        }
        fields = re.search(r"double (objective.*);\n\} \w+_found", header)
        self.fields = fields[1].split(", ") if fields else []
        self.memory = ctypes.create_string_buffer(1 << 23)
        self.raw[f"{self.name}_prepare"](self.memory)
        self.x = self.vector("design", "PARAMETERS")
        self.data = self.vector("machine", "MACHINE")

    def vector(self, name: str, size: str) -> Array:
        """A vector of the file's own numbers."""
        return np.array(
            (ctypes.c_double * self.sizes[size]).in_dll(self.raw, f"{self.name}_{name}")
        )

    @property
    def count(self) -> int:
        """How many quantities there are: of equal sides, each has its own."""
        totals = self.sizes.get("TOTALS", 0)
        return self.sizes["SIDE"] * (2 if totals else 1) + totals

    @property
    def names(self) -> list[str]:
        """Names of the quantities."""
        count = self.count
        texts = (ctypes.c_char_p * count).in_dll(self.raw, f"{self.name}_quantity")
        return [text.decode() for text in texts]

    def quantities(self, phi: Array, x: Array | None = None) -> tuple[int, Array]:
        """The status, and quantities (m, n) at angles (n,)."""
        q = np.empty((self.count, len(phi)))
        vectors = [np.ascontiguousarray(v) for v in (self.x if x is None else x, self.data, phi)]
        x_, data, angles = (ctypes.c_void_p(v.ctypes.data) for v in vectors)
        run = self.raw[f"{self.name}_quantities"]
        status = run(
            self.memory, x_, data, ctypes.c_long(len(phi)), angles, ctypes.c_void_p(q.ctypes.data)
        )
        return status, q

    def gradient(self, x: Array) -> tuple[int, dict[str, float], Array]:
        """The status, what is found of a turn by name, and the gradient (p,)."""
        values, gradient = np.empty(len(self.fields)), np.empty(len(x))
        pointers = (ctypes.c_void_p(v.ctypes.data) for v in (x, self.data, values, gradient))
        status = self.raw[f"{self.name}_gradient"](self.memory, *pointers)
        return status, dict(zip(self.fields, values.tolist(), strict=True)), gradient


@cache
def library(name: str) -> Library:
    return Library(c_files(name))
