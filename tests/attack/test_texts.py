"""Formulas in texts and names files that would grow without end are refused before anything
computes them.
"""

from __future__ import annotations

import importlib.util
import signal
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from types import ModuleType

import pytest
from hypothesis import given, seed
from hypothesis import strategies as st

from derive.audit.texts.documents import build_document
from derive.audit.texts.interpretation import list_scalars
from derive.audit.texts.names import NameTable, StatedNames, find_stated
from derive.audit.texts.trial import build_subject as build
from derive.audit.texts.trial import list_quantities, read_case
from derive.generated_folder import OwnError
from tests.attack.test_attack import SEED, share
from tests.support.structure import ROOT

LONGEST_S = 20
"""Time in which a row is read or refused [s]; most take milliseconds."""


@pytest.fixture(autouse=True)
def _limited() -> Iterator[None]:
    """End a test that goes on without end."""
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, lambda *_: pytest.fail("no end"))
        signal.alarm(300)
    yield
    if hasattr(signal, "SIGALRM"):
        signal.alarm(0)


@cache
def statement() -> ModuleType:
    path = ROOT / "docs" / "examples" / "slider_crank.py"
    spec = importlib.util.spec_from_file_location("attacked_slider_crank", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def read_reason(row: str, kind: str = ".tex") -> str:
    """Return why the only row of a text is not judged, empty if it can be."""
    frame = {".tex": "\\begin{equation}\n%s\n\\end{equation}\n", ".md": "$$\n%s\n$$\n"}[kind]
    document = build_document(f"text{kind}", kind, frame % row)
    case = read_case(document, find_stated(statement()), NameTable(), statement())
    assert case.source is not None
    (entry,) = case.source.list_rows()
    return str(entry["reason"] or "")


@cache
def names() -> StatedNames:
    stated = find_stated(statement())
    return StatedNames(
        stated, list_quantities(stated, build(stated, 1.0)), NameTable(), statement()
    )


GROWING = {
    "tower": r"s = 9^{9^{9^{9}}}",
    "power": r"s = r\, 2^{99999}",
    "negative": r"s = r\, 3^{-9^{9}}",
    "root": r"s = \sqrt{9^{9^9}}",
    "part": r"s = r^{1/999999999999}",
    "function": r"s = r\sin(9^{99}\varphi)^{9^{9}}",
    "unknown tower": r"s = r\varphi^{\varphi^{\varphi^{\varphi}}}",
    "ten": r"s = r\cdot 10^{10^{10}}",
    "sum of powers": r"s = \sum_{i=1}^{50} r^{i^{i^{i}}}",
    "digits": "s = " + "9" * 6000,
    "number of numbers": r"s = r\,(9^{99})^{99}",
    "expansion": r"s = l(1+\sin\varphi+\cos\varphi+\sin 2\varphi)^{99}",
    "megabyte": "s = " + "r + " * 250_000 + "r",
    "brackets": "s = " + "(" * 3000 + "r" + ")" * 3000,
    "braces": "s = " + "{" * 20_000 + "r" + "}" * 20_000,
    "fractions": "s = " + r"\frac{r}{l+" * 400 + "e" + "}" * 400,
    "powers": "s = r" + "^{r" * 300 + "}" * 300,
    "exponentials": r"s = r\exp(\exp(\exp(\exp(\varphi))))",
}


@pytest.mark.parametrize("kind", [".tex", ".md"])
@pytest.mark.parametrize("case", GROWING)
def test_growing_formula_is_refused(case: str, kind: str) -> None:
    assert read_reason(GROWING[case], kind)


@pytest.mark.parametrize(
    "row",
    [
        r"s = r\cos\varphi + l\cos\beta",
        r"s = r\cdot 1.5^{20}",
        r"s = r(1+\varphi)^{12}",
        r"s = r\varphi^{\varphi}",
    ],
)
def test_usual_powers_are_read(row: str) -> None:
    assert not read_reason(row)


MEANINGS = (
    "9**9**9**9",
    "r*9**9**9",
    "2**99999",
    "r**(1/999999999)",
    "(r+l+e_0)**99",
    "9" * 5000,
    "1e400",
    "r*1e400",
    "exp(exp(exp(exp(phi))))",
    "phi**phi**phi**phi",
    "+".join(["r"] * 250_000),
    "(" * 500 + "r" + ")" * 500,
    "1/0",
    "0**-1",
    "-" * 5000 + "r",
    "(9**99)**99",
)


@pytest.mark.parametrize("text", MEANINGS, ids=lambda text: text[:24])
def test_growing_meaning_is_refused_or_small(text: str) -> None:
    with suppress(OwnError):
        value = names().evaluate(text)
        assert all(len(str(scalar.value)) < 10_000 for scalar in list_scalars(value))


_atom = st.sampled_from(["r", "l", r"\varphi", "9", "2.5", "0.1", "99", r"\pi", r"\sin\varphi"])
_formula = st.recursive(
    _atom,
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda p: rf"({p[0]})^{{{p[1]}}}"),
        st.tuples(inner, inner).map(lambda p: rf"({p[0]} + {p[1]})"),
        st.tuples(inner, inner).map(lambda p: rf"\frac{{{p[0]}}}{{{p[1]}}}"),
        inner.map(lambda p: rf"\sqrt{{{p}}}"),
        inner.map(lambda p: rf"\exp({p})"),
    ),
    max_leaves=12,
)


@seed(SEED)
@share
@given(formula=_formula)
def test_towers_of_any_shape_end(formula: str) -> None:
    read_reason(f"s = r \\cdot {formula}")
