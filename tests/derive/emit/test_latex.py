"""The derivation as a document: whole, in balance, and taken by LaTeX where there is one."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import sympy as sp

from derive.__main__ import main
from derive.emit.folder import built_in, render_texts
from derive.emit.targets import latex
from derive.mechanics.gearing.families import FAMILIES
from derive.model import ClosedForm, Let, System
from derive.quantity import Quantity, Vector
from tests.support import own

(TARGET,) = (target for target in built_in() if target.name == "latex")
COMPILER = shutil.which("pdflatex")


@pytest.fixture(scope="module")
def documents(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a mechanism with loops and friction by cases, and of the pitch curves."""
    place = tmp_path_factory.mktemp("documents")
    assert (
        main([str(own.EXAMPLES / "slider_crank.py"), "--target", "latex", "--out", str(place)]) == 0
    )
    for name, text in render_texts((), FAMILIES.values(), [TARGET]).items():
        (place / name).write_text(text)
    return place / "latex"


def faults(text: str) -> list[str]:
    """Braces and environments that nothing closes, or that close nothing."""
    bare = re.sub(r"\\[\\{}]", "", text)
    problems = ["braces"] if bare.count("{") != bare.count("}") else []
    opened: list[str] = []
    for kind, name in re.findall(r"\\(begin|end)\{(\w+)\*?\}", text):
        if kind == "begin":
            opened.append(name)
        elif not opened or opened.pop() != name:
            problems.append(f"environment {name}")
    lefts, rights = (len(re.findall(rf"\\{side}\b", text)) for side in ("left", "right"))
    return (
        problems
        + [f"environment {name}" for name in opened]
        + (["brackets"] if lefts != rights else [])
    )


def test_every_document_is_in_balance(documents: Path) -> None:
    texts = {path.stem: path.read_text() for path in documents.glob("*.tex")}
    assert texts.keys() == {"slider_crank", *(f"curve_{name}" for name in FAMILIES)}
    assert {name: faults(text) for name, text in texts.items()} == {name: [] for name in texts}
    text = texts["slider_crank"]
    assert faults(text.replace(r"\end{align}", "", 1)) != []
    assert faults(text.replace("}", "", 1)) == ["braces"]


def test_document_lists_every_quantity(documents: Path) -> None:
    text = (documents / "slider_crank.tex").read_text()
    for name in ("phi", "kappa", "beta_ddot", "F_Bx", "N_guide", "M_in"):
        assert rf"\texttt{{{name.replace('_', chr(92) + '_')}}}" in text
    assert re.search(r"\\ddot\{\\beta\}\\,c_\{\d+\} \+ \\ddot\{s\} &= ", text)
    assert text.count(r"\texttt{F\_Ox} (derived") == text.count(r"\texttt{v\_guide} (derived") == 1


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("phi52_dot", r"\dot{\phi}_{52}"),
        ("F_B1x", r"F_{\mathrm{B1x}}"),
        ("x_A_o", r"x_{\mathrm{A, o}}"),
        ("wall", r"\mathit{wall}"),
        ("A_", "A^{*}"),
        ("s_ddot", r"\ddot{s}"),
    ],
)
def test_a_name_is_written_as_a_symbol(name: str, written: str) -> None:
    assert latex.symbol(sp.Symbol(name)) == written


def test_long_sum_breaks_and_special_signs_are_escaped() -> None:
    terms = [Quantity(f"load_{i}", "N m2", "50 % of {it} & more_", "test") for i in range(40)]
    total = Quantity("total", "N m2", "sum", "test #1")
    form = ClosedForm(
        "sums", tuple(terms), (Let(total, sp.Add(*terms), "test"),), Vector("given", (total,))
    )
    text = render_texts([System("small", "Small", "test", (), closed_forms=(form,))], (), [TARGET])[
        "latex/small.tex"
    ]
    assert faults(text) == []
    assert text.count(r"\nonumber") >= 3
    assert r"50 \% of \{it\} \& more\_" in text
    assert "N m$^2$" in text


@pytest.mark.skipif(COMPILER is None, reason="no pdflatex here: the documents were not set")
@pytest.mark.parametrize("name", ["slider_crank", "curve_fourier"])
def test_latex_takes_it(name: str, documents: Path, tmp_path: Path) -> None:
    assert COMPILER is not None
    command = [
        COMPILER,
        "-interaction=nonstopmode",
        "-halt-on-error",
        f"-output-directory={tmp_path}",
    ]
    done = subprocess.run(
        [*command, f"{name}.tex"], cwd=documents, capture_output=True, text=True, check=False
    )
    assert not done.returncode, done.stdout[-2000:]
    assert (tmp_path / f"{name}.pdf").stat().st_size > 10_000
