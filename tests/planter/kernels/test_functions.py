"""Sine, cosine and floor as they are printed, by library, by fused multiply-adds and by plain ones,
against NumPy.
"""

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planter.kernels import lane_source
from tests.support.lanes import compiled, needs_compiler, path_of

pytestmark = needs_compiler

RNG = np.random.default_rng(8)
QUARTERS = np.arange(-9, 10) * np.pi / 2
ANGLES = np.concatenate(
    [QUARTERS, np.nextafter(QUARTERS, 99), RNG.uniform(-30, 30, 300), RNG.normal(size=100) * 1e6]
)
EDGES = np.concatenate(
    [np.arange(-4.0, 5.0), np.nextafter(np.arange(-4.0, 5.0), -9), RNG.normal(size=50) * 1e8]
)
OUTSIDE = "\n".join(
    f"double {name}_outside(double x) {{ return {name}(x); }}"
    for name in ("turned_sin", "turned_cos", "whole_floor")
)


def loaded(text: str, folder: Path) -> Callable[[str, np.ndarray], np.ndarray]:
    """Values of the functions of a C text, compiled so that sums stay as they are written."""
    built = compiled(
        f"#include <math.h>\n{text}{OUTSIDE}\n", folder / "functions.o", "-O1", "-ffp-contract=off"
    )
    library = built.with_suffix(".so")
    subprocess.run([path_of("gcc"), "-shared", str(built), "-o", str(library), "-lm"], check=True)
    outside = ctypes.CDLL(str(library))

    def values(name: str, at: np.ndarray) -> np.ndarray:
        function = getattr(outside, f"{name}_outside")
        function.argtypes, function.restype = [ctypes.c_double], ctypes.c_double
        return np.array([function(x) for x in at])

    return values


TEXTS = {
    "library": lane_source.print_functions("test"),
    "WebAssembly": lane_source.print_functions("test", wasm=True),
    "fused": lane_source.print_functions("test").replace(
        "#if defined(FP_FAST_FMA) || defined(__FMA__)", "#if 1"
    ),
}


@pytest.mark.parametrize("name", TEXTS)
def test_they_are_right_to_the_last_digit(name: str, tmp_path: Path) -> None:
    values = loaded(TEXTS[name], tmp_path)
    assert np.abs(values("turned_sin", ANGLES) - np.sin(ANGLES)).max() < 4e-16
    assert np.abs(values("turned_cos", ANGLES) - np.cos(ANGLES)).max() < 4e-16
    assert (values("whole_floor", EDGES) == np.floor(EDGES)).all()


def test_another_part_of_pi_is_noticed(tmp_path: Path) -> None:
    first, second = lane_source.SHORT_PI
    for number, (old, new) in enumerate(
        [(repr(first), repr(first + 1e-9)), (repr(second), repr(-second))]
    ):
        text = TEXTS["WebAssembly"].replace(old, new)
        assert text != TEXTS["WebAssembly"]
        folder = tmp_path / str(number)
        folder.mkdir()
        assert np.abs(loaded(text, folder)("turned_sin", ANGLES) - np.sin(ANGLES)).max() > 1e-10
