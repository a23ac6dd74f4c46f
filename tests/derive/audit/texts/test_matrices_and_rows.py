"""Derivatives of reported quantities, matrices and lists, meanings that hold in one row, and dots
in corrections.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import sympy as sp

from derive.audit.case import Case
from derive.audit.terms import holds
from derive.generated_folder import OwnError
from tests.support import own
from tests.support.made_up import read_text


def _read_case(tmp_path: Path, text: str, names: str) -> Case:
    mechanism = (own.EXAMPLES / "slider_crank.py").read_text(encoding="utf-8")
    return read_text(tmp_path, mechanism, text, names)


VALID = {
    "matrix and transposed list": (
        r"\begin{align} x^T M x &= m_r r^2 + m_s l^2 \\ x &= [r, l]^T \end{align}",
        "[names]\n'x' = \"matrix(2, r, l)\"\n'M' = \"matrix(2, m_r, 0, 0, m_s)\"\n",
    ),
    "names of a row": (
        r"\begin{align} a &= 2 b \\ a &= 3 b \end{align}",
        "[names]\n'a' = \"2*r\"\n'b' = \"r\"\n[rows]\n'2' = { names = { 'a' = \"3*r\" } }\n",
    ),
    "matrices in macros": (
        "\\begin{align}\n x &= \\vp{\\r}{l} \\\\\n y &= \\twice r\n\\end{align}",
        "[macros]\n'\\vp' = '\\begin{array}{c} {#1} \\\\ {#2} \\end{array}'\n'\\twice' = "
        "'\\vp{#1}{#1}'\n'\\r' = 'r'\n"
        "[names]\n'x' = \"matrix(2, r, l)\"\n'y' = \"matrix(2, r, r)\"\n",
    ),
    "gradient": (
        r"\[ \frac{\partial T}{\partial q} = \begin{bmatrix} 2 m_s s \\ m_s l \end{bmatrix} \]",
        "[names]\n'T' = \"m_s*s**2 + m_s*l*beta\"\n'q' = \"matrix(2, s, beta)\"\n",
    ),
}


@pytest.mark.parametrize(("text", "names"), VALID.values(), ids=VALID)
def test_rows_hold_by_the_meanings_of_their_names(tmp_path: Path, text: str, names: str) -> None:
    case = _read_case(tmp_path, text, names)
    assert {row["reason"] for row in case.source.list_rows()} == {""}
    assert {equation.residual for equation in case.paper.equations.values()} == {0}


PARTIAL = "[names]\n'V' = \"m_s*beta**2\"\n'W' = \"m_s*s*beta\"\n"
ROWS = [
    # a row, a names file, and what the reason says for which it is not judged
    (r"v(w) + 3 w = 0", "[names]\n'v' = \"matrix(2, r, l)\"\n'w' = \"matrix(2, m_r, m_s)\"\n", ""),
    (r"T (\varphi, \beta) = \vphantom{\frac{l}{l}} m_r l^2", "[names]\n'T' = \"J\"\n", ""),
    (r"\sin\beta = \beta", "", ""),
    (r"\sin\beta \approx \beta", "", "approximation"),
    (r"s = \a", "[macros]\n'\\a' = '\\a \\\\ \\a'\n", "without end"),
    (r"\frac{d W}{d \beta} = m_s s", PARTIAL, "partial"),
    (r"\frac{d W}{d r} = m_s s", PARTIAL, "r"),
    (r"\frac{d^2 V}{d\beta^2} = m_s s", PARTIAL, "higher order"),
]


@pytest.mark.parametrize(("latex", "names", "reason"), ROWS)
def test_row_that_is_not_judged_says_why(
    tmp_path: Path, latex: str, names: str, reason: str
) -> None:
    (row,) = _read_case(tmp_path, rf"\[ {latex} \]", names).source.list_rows()
    assert reason in row["reason"]
    assert bool(reason) == bool(row["reason"])


@pytest.mark.parametrize("meaning", ["matrix(2, r)", "matrix(0, r)", "matrix(2)", "matrix(r, r)"])
def test_invalid_matrix_names_its_key(tmp_path: Path, meaning: str) -> None:
    with pytest.raises(OwnError, match=r"names\.x"):
        _read_case(tmp_path, r"\[ x = 2 \]", f"[names]\n'x' = \"{meaning}\"\n")


def test_no_correction_puts_dots_on_a_constant(tmp_path: Path) -> None:
    case = _read_case(tmp_path, r"\[ s = r\cos\varphi + l\cos\beta + 2 l \]", "")
    (correction,) = [
        case.source.repair(number, case.points, case.draw) for number in case.paper.equations
    ]
    assert correction is None or r"\dot" not in correction.latex


CUBE = (
    r"r^3\cos^3\varphi",
    r"3 r l \cos\varphi \cos\beta",
    r"r\cos\varphi",
    r"l\cos\beta",
    r"l^3\cos^3\beta",
)
SIGNS = {
    "right": ("{} + {} ({} + {}) + {}", ""),
    "outermost": ("-{} + {} ({} + {}) - {}", "+{} + {} ({} + {}) + {}"),
    "innermost": ("{} + {} ({} - {}) - {}", "{} + {} ({} + {}) + {}"),
    "signs and a factor": ("-{} - {} ({} + {}) - 5 {}", ""),
}


@pytest.mark.parametrize(("printed", "corrected"), SIGNS.values(), ids=SIGNS)
def test_signs_of_several_terms_are_found_together(
    tmp_path: Path, printed: str, corrected: str
) -> None:
    case = _read_case(tmp_path, rf"\[ s^3 = {printed.format(*CUBE)} \]", "")
    (number,) = case.paper.equations
    points = tuple(case.points)
    assert holds(case.paper.equations[number].residual, points) == (printed == SIGNS["right"][0])
    repair = case.source.repair(number, case.points, case.draw)
    if corrected:
        assert repair is not None
        assert repair.latex.split() == rf"s^3 = {corrected.format(*CUBE)}".split()
    elif printed != SIGNS["right"][0]:
        assert repair is None


REPORTING = """
from derive import Mechanism, quantities

q = quantities("l | m | rod | 2\\ng | m/s2 | free fall | 9.81\\nm | kg | bob | 3")
m = Mechanism("pendulum", q, gravity=q.g)
a = m.coordinate("a", "rad", "swing")
B = m.point("B", m.O, m.frame("rod", a), q.l)
bob = m.body("bob", m.world, q.m, B)
E = m.report("E", "J", "energy of the bob", q.m * q.l**2 * m.rate(a) ** 2 / 2)
m.report("twice", "J", "twice the energy", 2 * E)
"""


def test_derivatives_of_reported_quantities(tmp_path: Path) -> None:
    text = r"""\begin{align}
 \frac{\partial E}{\partial \dot a} &= m l^2 \dot a \\
 \frac{d}{dt} \mathrm{twice} &= 2 m l^2 \dot a \ddot a \\
 \frac{\partial \mathrm{twice}}{\partial E} &= 2 \\
 \frac{\partial a}{\partial E} &= 0
\end{align}"""
    source = read_text(tmp_path, REPORTING, text).source
    residuals = [
        [left.value - right.value for _, _, left, right in row.read.residuals(row.names)]
        for row in source.rows
        if row.read is not None
    ]
    assert [[sp.simplify(residual) for residual in row] for row in residuals] == [[0], [0]]
    assert "depends on other" in source.rows[3].reason


def test_identities_hold_and_definitions_are_not_judged(tmp_path: Path) -> None:
    text = r"""\begin{align}
 2 \frac{d}{dt} \sin\beta &= 2 \dot\beta \cos\beta \\
 K l &= m_r l^2 \\
 K &= m_r l
\end{align}"""
    case = _read_case(tmp_path, text, "[names]\n'K' = \"m_r*l\"\n")
    claims = [str(equation.claims) for equation in case.paper.equations.values()]
    assert ["same by the meaning" in claim for claim in claims] == [False, False, True]


def test_values_of_the_table_are_not_judged(tmp_path: Path) -> None:
    case = _read_case(tmp_path, r"\begin{align} r &= 30 \\ s &= 3 \end{align}", "")
    claims = [str(equation.claims) for equation in case.paper.equations.values()]
    assert ["a value that the text gives" in claim for claim in claims] == [True, False]


@pytest.mark.parametrize(
    ("latex", "holds"),
    [
        (r"\frac{d V}{d \beta} = 2 m_s \beta", True),
        (r"\frac{d V}{d \beta} = m_s \beta", False),
        (r"\frac{d}{d \beta} \left(\sin\beta\right) = \cos\beta", True),
        (r"\frac{d s}{d \beta} = \frac{\dot s}{\dot\beta}", True),
        (r"\frac{d s}{d \beta} = \frac{\dot\beta}{\dot s}", False),
        (r"\frac{\mathrm{d} s}{\mathrm{d} \beta} \frac{d\beta}{ds} = 1", True),
    ],
)
def test_derivative_to_a_name_is_that_along_the_motion(
    tmp_path: Path, latex: str, holds: bool
) -> None:
    case = _read_case(tmp_path, rf"\[ {latex} \]", "[names]\n'V' = \"m_s*beta**2\"\n")
    assert [row["reason"] for row in case.source.list_rows()] == [""]
    (equation,) = case.paper.equations.values()
    assert (sp.simplify(equation.residual) == 0) == holds
