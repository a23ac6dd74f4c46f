"""Programs: what they find here is what their WebAssembly finds, and what a hand would."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from planter.kernels import compiler, programs
from planter.kernels.compiler import CompilerError
from planter.kernels.programs import LOOPS_FILE, MAIN_FILE, Program, ProgramStep, print_programs
from tests.support.wasm import Running, difference, needs_wasm

ANGLES = np.concatenate(
    [np.linspace(-50, 50, 301), np.linspace(-4e4, 4e4, 200), np.pi * np.arange(-20, 20) / 2]
)


def program() -> Program:
    """A matrix made of a vector, what that does to a row of angles, and their largest and mean."""
    x, a, t = ca.SX.sym("x", 2), ca.SX.sym("a", 3, 2), ca.SX.sym("t")
    rows = ca.MX.sym("rows", len(ANGLES), 3)
    return Program(
        "demo",
        {"x": np.array([0.7, -1.3]), "t": ANGLES},
        [
            ProgramStep(
                ca.Function(
                    "demo_matrix",
                    [x],
                    [ca.horzcat(x[0] * ca.SX([1, 2, 3]), x[1] ** ca.SX([1, 2, 3]))],
                    ["x"],
                    ["a"],
                )
            ),
            ProgramStep(
                ca.Function(
                    "demo_rows",
                    [t, a],
                    [ca.vertcat(ca.sin(t), ca.cos(t), a[2, 0] * t + a[0, 1])],
                    ["t", "a"],
                    ["rows"],
                ),
                ("t",),
            ),
            ProgramStep(
                ca.Function(
                    "demo_singles",
                    [rows],
                    [ca.vertcat(ca.mmax(rows[:, 2]), ca.sum1(rows[:, 0]))],
                    ["rows"],
                    ["singles"],
                )
            ),
        ],
    )


@pytest.fixture(scope="module")
def running() -> Running:
    return Running(programs.build_webassembly([program()]))


def test_program_equals_formulas() -> None:
    values = program()(x=np.array([2.0, 0.5]))
    assert values["a"] == pytest.approx([2, 4, 6, 0.5, 0.25, 0.125], rel=1e-15)
    line = 6 * ANGLES + 0.5
    assert values["rows"] == pytest.approx(
        np.concatenate([np.sin(ANGLES), np.cos(ANGLES), line]), abs=1e-9
    )
    assert values["singles"] == pytest.approx([line.max(), np.sin(ANGLES).sum()], rel=1e-12)


def test_vectors_are_consecutive() -> None:
    printed_program = program()
    ends = np.cumsum(list(printed_program.sizes.values()))
    assert list(printed_program.offsets.values()) == [0, *ends[:-1]]
    assert printed_program.size == ends[-1]
    assert list(printed_program.sizes) == ["x", "t", "a", "rows", "singles"]


@needs_wasm
def test_webassembly_equals_formulas_without_imports(running: Running) -> None:
    printed_program = program()
    assert list(running.module.imports) == []
    for x in ([0.7, -1.3], [2.0, 0.5], [-1e3, 1e-3]):
        values, expected = (
            running.vectors(printed_program, x=np.array(x)),
            printed_program(x=np.array(x)),
        )
        assert values is not None
        assert difference(values, expected) < 1e-14


@needs_wasm
def test_sine_and_cosine_are_accurate_far_from_zero(running: Running) -> None:
    sines = running.vectors(program())
    assert sines is not None
    sine, cosine, _ = sines["rows"].reshape(3, -1)
    assert np.abs(sine - np.sin(ANGLES)).max() < 4e-16
    assert np.abs(cosine - np.cos(ANGLES)).max() < 4e-16


@needs_wasm
def test_non_finite_result_is_reported(running: Running) -> None:
    assert running.vectors(program(), x=np.array([np.inf, 1.0])) is None
    assert running.vectors(program(), x=np.array([1e308, 1e308])) is None
    assert running.vectors(program(), x=np.array([1.0, 1.0])) is not None


def test_missing_compiler_error_names_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "bundled_command", lambda target="": ())
    with pytest.raises(CompilerError, match=r"pip install 'planter\[compiler\]'"):
        programs.build_webassembly([program()])


def test_text_is_loops_in_c() -> None:
    text = print_programs([program()])
    assert set(text) == {LOOPS_FILE, MAIN_FILE}
    assert "void demo_rows(long lanes" in text[LOOPS_FILE]
    assert "int demo(void)" in text[MAIN_FILE]
