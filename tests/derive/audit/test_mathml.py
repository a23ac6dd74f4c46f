"""Formulas and sentences typeset from expressions."""

from __future__ import annotations

import json
import pickle
import re
import xml.etree.ElementTree as ET
from html import unescape

import pytest
import sympy as sp

from derive.audit import typesetting as mathml
from derive.audit.typesetting import Said, join_parts
from derive.equations import Equation
from derive.generated_folder import GENERATED
from tests.support.made_up import MadeUpClaim

a, b, c, d, e, x, y, mu = sp.symbols("a b c d e x y mu")


def plain_text(element: str) -> str:
    """The signs of an element that a reader sees."""
    root = ET.fromstring(element)
    notes = "".join(note.text or "" for note in root.iter("annotation"))
    return "".join(root.itertext()).removesuffix(notes)


def equation(residual: sp.Expr, defines: sp.Symbol | None = None, relation: str = "=") -> Equation:
    return Equation("n", residual, "test", MadeUpClaim.SUM, defines=defines, relation=relation)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("solved", "text"),
    [
        (equation(mu - a * b, mu), "\N{GREEK SMALL LETTER MU}=a\N{INVISIBLE TIMES}b"),
        (equation(c - b + a, c), "c=\N{MINUS SIGN}a+b"),
        (equation(a + b), "a+b=0"),
        (equation(a - b * c, a, ">="), "a\N{GREATER-THAN OR EQUAL TO}b\N{INVISIBLE TIMES}c"),
        (equation(2 * a - b, a), "2\N{INVISIBLE TIMES}a\N{MINUS SIGN}b=0"),
    ],
)
def test_equation_is_typeset_solved_for_the_symbol(solved: Equation, text: str) -> None:
    assert plain_text(mathml.typeset_equation(solved)) == text


def test_long_sum_breaks_before_signs() -> None:
    terms = [sp.Symbol(f"a{i}") * sp.Symbol(f"b{i}") for i in range(60)]
    element = mathml.typeset_equation(equation(terms[0] - sp.Add(*terms[1:])))
    rows = ["".join(row.itertext()) for row in ET.fromstring(element).iter("mtr")]
    assert len(rows) > 2
    assert all(row.startswith("\N{MINUS SIGN}") for row in rows[1:])
    assert all(f"a{i}\N{INVISIBLE TIMES}b{i}" in plain_text(element) for i in range(60))


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (-a * (b - c), "\N{MINUS SIGN}a\N{INVISIBLE TIMES}(b\N{MINUS SIGN}c)"),
        ((a + b) ** 2, "(a+b)2"),
        (sp.Pow(a * b, 2, evaluate=False), "(a\N{INVISIBLE TIMES}b)2"),
        (sp.Mul(-1, a + b, evaluate=False), "\N{MINUS SIGN}(a+b)"),
        (sp.cos(a) * b, "b\N{INVISIBLE TIMES}cos\N{FUNCTION APPLICATION}(a)"),
        (sp.Abs(y), "|y|"),
        (a / b, "ab"),
        (sp.Rational(-2, 3) * a, "\N{MINUS SIGN}2\N{INVISIBLE TIMES}a3"),
        (sp.sqrt(a) / 2, "a2"),
        (1 / a**2, "1a2"),
        (sp.Piecewise((a, x < 0), (b, True)), "{ax<0botherwise"),
    ],
)
def test_expressions_are_set_as_they_read(expr: sp.Expr, text: str) -> None:
    assert plain_text(mathml.typeset_inline(expr)) == text


def test_unknown_expression_raises() -> None:
    with pytest.raises(TypeError, match="cannot set Interval"):
        mathml.typeset_expression(sp.Interval(0, 1))


def test_sentence_typesets_only_expressions() -> None:
    sentence = join_parts("; ", (Said("sign of ", -a * b), Said(x, " for ", y), "a < b & c"))
    assert str(sentence) == "sign of -a*b; x for y; a < b & c"
    element = mathml.typeset_sentence(sentence)
    assert element.count("<math>") == 3
    assert element.endswith("; a &lt; b &amp; c")
    ET.fromstring(f"<p>{element}</p>")
    again = pickle.loads(pickle.dumps(sentence))
    assert (again, again.pieces) == (sentence, sentence.pieces)


def test_written_mathml_is_well_formed_and_complete() -> None:
    records = json.loads((GENERATED / "audit.json").read_text(encoding="utf-8"))["equations"]
    typeset = json.loads((GENERATED / "audit_mathml.json").read_text(encoding="utf-8"))
    assert {(r["paper"], r["equation"]) for r in records} == {
        (p, n) for p, element in typeset.items() for n in element
    }
    for record in records:
        element = typeset[record["paper"]][record["equation"]]
        for part in ("terms", "unexplained", "vanishing", "correction"):
            assert len(element[part]) == len(record[part])
        ET.fromstring(
            f"<p>{element['printed']}{element['derived']}{element['finding']}{''.join(element['correction'])}</p>"
        )
        notes = re.findall(
            r"<annotation[^>]*>(.*?)</annotation>", element["printed"] + element["derived"]
        )
        assert [unescape(note) for note in notes] == [
            record[s] for s in ("printed", "derived") if record[s]
        ]
