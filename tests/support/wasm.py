"""WebAssembly modules of programs in a runtime that stands alone, where it is installed with the
bundled compiler.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from planter.kernels import Array
from planter.kernels.programs import Program

needs_wasm = pytest.mark.skipif(
    find_spec("ziglang") is None or find_spec("wasmtime") is None,
    reason="needs ziglang and wasmtime",
)


class Running:
    """A module that runs."""

    def __init__(self, module: bytes) -> None:
        import wasmtime

        self.store = wasmtime.Store()
        self.module = wasmtime.Module(self.store.engine, module)
        exports: Any = wasmtime.Instance(self.store, self.module, []).exports(self.store)
        self.exports = exports
        exports["_initialize"](self.store)

    def run(self, name: str, size: int, inputs: Mapping[int, float]) -> Array | None:
        """All numbers of a program from its own, some of them set; None where one is not finite."""
        start = self.exports[f"{name}_numbers"](self.store)
        memory = self.exports["memory"]
        for place, value in inputs.items():
            memory.write(self.store, np.float64(value).tobytes(), start + 8 * place)
        if self.exports[name](self.store):
            return None
        return np.frombuffer(bytes(memory.read(self.store, start, start + 8 * size)))

    def vectors(self, program: Program, **changed: Array) -> dict[str, Array] | None:
        """All vectors of a program by name, from what is given, some of it changed."""
        inputs = {
            program.offsets[key] + k: v
            for key, values in changed.items()
            for k, v in enumerate(values)
        }
        memory = self.run(program.name, program.size, inputs)
        if memory is None:
            return None
        return {
            key: memory[start : start + program.sizes[key]]
            for key, start in program.offsets.items()
        }


def difference(actual: Mapping[str, Array], expected: Mapping[str, Array]) -> float:
    """The largest difference of vectors, each in parts of its own largest number."""
    return max(
        float(np.abs(actual[key] - expected[key]).max() / (np.abs(expected[key]).max() or 1.0))
        for key in expected
    )
