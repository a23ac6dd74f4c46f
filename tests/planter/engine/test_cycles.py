"""Cycles in C are those of array code: `cycles.c` on given quantities and slopes; tampered texts
differ.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from planter import evaluate_many, load_machine
from planter.engine.cycles import CALL, FUNCTIONS, KINDS, SIZES, _Cycle, _Term
from planter.engine.machine import Machine
from planter.engine.outputs import COMPILED
from planter.kernels import Array, toolchain
from planter.numerics import statistics
from tests.support import own
from tests.support.lanes import needs_compiler

pytestmark = [pytest.mark.usefixtures("kernel_cache"), needs_compiler]

LANES, SIDES, STRIDE, PARAMETERS = 24, 2, 2, 3
SHARED = (1, 0)
"""Of two quantities the first is added up over the sides; of the second every other lane is a
sample.
"""
GUARDS, LEAST = 2, 0.5
"""A pivot, which must not be below a limit, and states, none of which may be zero."""
TERMS = [
    (0, 0, "range", 2.0),
    (0, 0, "variance", 0.5),
    (0, 1, "rms", 3.0),
    (1, 1, "std", 1.0),
    (2, 0, "max", 1.5),
    (2, 1, "min", -1.0),
    (3, 1, "mean", 1.0),
    (4, 0, "rms", 1.0),
]
"""Output, quantity, measure and weight; slopes are those of the first `SLOPED` outputs."""
OUTPUTS, SLOPED = 5, 4
ROWS = (len(SHARED) + GUARDS) * LANES
GIVEN = f"""
int fix(const double **arg, double **res, casadi_int *iw, double *w, int mem) {{ res[0][0] = arg[0][0]; return 0; }}
void slope(long lanes, const double *phi, const double *d, const double *h, const double *q, const double *dh,
           double *rows, double *slopes)
{{ memcpy(rows, d + 1, {ROWS} * sizeof *d); memcpy(slopes, d + 1 + {ROWS}, {len(SHARED)} * 3 * lanes * sizeof *d); }}
"""
"""Kernels whose lanes are the values of a row: quantities and guards, then slopes of the
quantities.
"""
TAMPERED = {
    "no mean": ("rate * (x[i] - origin)", "rate * x[i]"),
    "no lowest sample": ("kind == MIN ? scale : -scale", "kind == MIN ? scale : 0.0"),
    "half the rate": ("2.0 * scale / n", "scale / n"),
    "a size that is none": ("scale / size", "scale * size"),
    "first sample never the highest": ("long i = 0;\n  while", "long i = 1;\n  while"),
    "one side": ("side < sides", "side < 1"),
    "a side that is not added up": ("side < c->sides", "side < 1"),
    "samples side by side": ("row[i] = row[i * c->stride]", "row[i] = row[i]"),
    "slopes side by side": ("slope[i * stride]", "slope[i]"),
    "variance of a sample": ("s.variance = squares / n", "s.variance = squares / (n - 1)"),
    "square about the mean": ("s.variance + s.mean * s.mean", "s.variance"),
    "weights of another output": ("memset(c->weights, 0,", "memset(c->weights, 0, 0 *"),
    "outputs that are not added up": ("outputs[t->output] += ", "outputs[t->output] = "),
}


def read_text() -> str:
    return resources.files("planter.engine").joinpath("cycles.c").read_text(encoding="utf-8")


def build(text: str) -> Path:
    return toolchain.build_library(
        "cycles", text + GIVEN, toolchain.loop_flags(toolchain.OPTIMISED)
    )


def draw_row() -> tuple[Array, Array, Array]:
    """Return quantities (2, lanes), the first largest at the first sample, guards and slopes (2, p,
    lanes).
    """
    rng = np.random.default_rng(2)
    rows, guards = rng.normal(size=(len(SHARED), LANES)), np.ones((GUARDS, LANES))
    rows[0, 0] += 9.0
    return rows, guards, rng.normal(size=(len(SHARED), PARAMETERS, LANES))


def run(path: Path, *parts: Array) -> tuple[Array, Array, Array]:
    """Return outputs (k,), gradients (s, p) and the failure (1,) that a library finds for a row."""
    call, *functions = toolchain.load_functions(path, "cycles", "fix", "slope")
    row = np.concatenate([[1.0], *(part.ravel() for part in parts)])
    arrays = {
        name: np.zeros(8 * ROWS)
        for name in ("phi", "statistics", "q", "h", "dh", "rows", "slopes", "weights", "arg")
    }
    arrays |= {name: np.zeros(8) for name in ("res", "iw", "w")}
    arrays |= {
        "shared": np.array(SHARED, dtype=ctypes.c_long),
        "states": np.array([0, 1], dtype=ctypes.c_long),
        "term": np.array(
            [(k, place, KINDS.index(kind), scale) for k, place, kind, scale in TERMS], dtype=_Term
        ),
    }
    sizes = (
        len(row),
        1,
        0,
        LANES,
        SIDES,
        STRIDE,
        len(SHARED),
        GUARDS,
        len(TERMS),
        OUTPUTS,
        SLOPED,
        PARAMETERS,
    )
    pointers = {
        name: ctypes.cast(f, ctypes.c_void_p)
        for name, f in zip(FUNCTIONS[::2], functions, strict=True)
    }
    cycle = _Cycle(
        least_pivot=LEAST,
        **dict(zip(SIZES, sizes, strict=True)),
        **pointers,
        **{name: array.ctypes.data for name, array in arrays.items()},
    )
    results = (
        np.full(OUTPUTS, np.nan),
        np.full((SLOPED, PARAMETERS), np.nan),
        np.zeros(1, dtype=np.uint8),
    )
    index = np.zeros(1, dtype=ctypes.c_long)
    addresses = (ctypes.c_void_p(array.ctypes.data) for array in (row, row, *results))
    call.restype, call.argtypes = ctypes.c_long, CALL
    assert call(ctypes.byref(cycle), 1, index.ctypes.data, 1, *addresses) == (results[2][0] > 0)
    return results


def expect(rows: Array, slopes: Array) -> tuple[Array, Array]:
    """Return outputs (k,) and gradients (s, p) by array code."""
    sides = [
        array.reshape(*array.shape[:-1], SIDES, -1).sum(axis=-2) for array in (rows[0], slopes[0])
    ]
    samples, tangents = (sides[0], rows[1, ::STRIDE]), (sides[1], slopes[1, :, ::STRIDE])
    outputs, gradients = np.zeros(OUTPUTS), np.zeros((OUTPUTS, PARAMETERS))
    for k, place, kind, scale in TERMS:
        outputs[k] += scale * statistics.reduce_samples(kind, samples[place])
        gradients[k] += (
            scale * tangents[place] @ statistics.differentiate_statistic(kind, samples[place])
        )
    return outputs, gradients[:SLOPED]


def compare(path: Path) -> float:
    """Return the largest difference of a library from array code, relative to the largest entry."""
    rows, guards, slopes = draw_row()
    outputs, gradients, failure = run(path, rows, guards, slopes)
    assert failure[0] == 0
    pairs = zip((outputs, gradients), expect(rows, slopes), strict=True)
    return float(max(np.abs(a - b).max() / np.abs(b).max() for a, b in pairs))


def test_python_struct_equals_c_struct() -> None:
    path = build(read_text() + "long measure_record(void) { return sizeof(cycle); }")
    (measure_record,) = toolchain.load_functions(path, "measure_record")
    assert measure_record() == ctypes.sizeof(_Cycle)


def test_outputs_and_gradients_are_those_of_array_code() -> None:
    assert {kind for _, _, kind, _ in TERMS} == set(KINDS)
    assert compare(build(read_text())) <= 1e-12


@pytest.mark.parametrize("change", TAMPERED)
def test_tampered_text_differs(change: str) -> None:
    old, new = TAMPERED[change]
    text = read_text()
    assert text.count(old) == 1
    assert compare(build(text.replace(old, new))) > 1e-4


def test_rows_without_a_cycle_fail() -> None:
    path = build(read_text())
    rows, guards, slopes = draw_row()
    cases = [
        (rows, (1, 4), np.inf, 1),
        (rows, (0, 3), np.nan, 1),
        (slopes, (0, 1, 2), np.nan, 2),
        (guards, (0, 2), LEAST / 2, 1),
        (guards, (0, 2), LEAST, 0),
        (guards, (0, 5), np.nan, 1),
        (guards, (1, 7), 0.0, 1),
        (guards, (1, 7), -1.0, 0),
    ]
    for array, index, value, failure in cases:
        before, array[index] = array[index], value
        assert run(path, rows, guards, slopes)[2][0] == failure
        array[index] = before


def load_slider_crank() -> Machine:
    machine = load_machine(str(own.generated("slider_crank") / "slider_crank.toml"))
    return machine.with_moved(
        {"values.r_mm": (20, 60), "values.l_mm": (50, 300), "values.mu": (0, 0.2)}
    )


MACHINES: dict[str, tuple[Callable[[], Machine], list[str], int]] = {
    "loop with friction": (load_slider_crank, ["M_in_rms_Nm", "F_Ox_range_N", "M_in_mean_Nm"], 36),
    "sides and quantities of one": (
        lambda: load_machine("compact"),
        ["objective", "phi52_rms_deg"],
        37,
    ),
}


@pytest.mark.parametrize("case", MACHINES)
def test_compiled_cycles_agree_with_array_code(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of rows on both sides of dead points; threads change no digit."""
    load, outputs, samples = MACHINES[case]
    machine = load()
    rng = np.random.default_rng(3)
    designs = machine.lower + rng.random((COMPILED, len(machine.moved))) * (
        machine.upper - machine.lower
    )
    compiled, threaded = (
        evaluate_many(machine, designs, samples, threads=threads, gradients=True, outputs=outputs)
        for threads in (1, 3)
    )
    monkeypatch.setenv("PLANTER_KERNELS", "casadi-vm")
    plain = evaluate_many(machine, designs, samples, gradients=True, outputs=outputs)
    assert compiled.gradient is not None
    assert threaded.gradient is not None
    assert plain.gradient is not None
    np.testing.assert_array_equal(threaded.values, compiled.values)
    np.testing.assert_array_equal(threaded.gradient, compiled.gradient)
    assert 0 < np.isfinite(plain.values).all(axis=1).sum() < COMPILED or machine.loops is None
    np.testing.assert_allclose(compiled.values, plain.values, rtol=1e-11)
    slopes, expected = (
        gradient * machine.design for gradient in (compiled.gradient, plain.gradient)
    )
    np.testing.assert_allclose(slopes, expected, rtol=0, atol=1e-11 * np.nanmax(np.abs(expected)))
