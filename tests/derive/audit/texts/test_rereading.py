"""Changed formulas read by the term that changed: the same trees as when they are read as a
whole.
"""

import re
from collections.abc import Iterator

import pytest

from derive.audit.texts import corrections
from derive.audit.texts.corrections import Rereader
from derive.audit.texts.formula import (
    FormulaError,
    Node,
    RelationChain,
    read_formula,
    tokenize_formula,
)

FORMULAS = (
    r"J \ddot\theta + (m l_1 - 2 m) g \sin(\theta + \phi) - \frac{a b}{c - 3} = F \cos\theta",
    r"- (a + b (c - d)^2) \left( x - y / 2 \right) = \sqrt{a^2 + b} - \min(a, b - c) = 0",
    r"\begin{bmatrix} a + b & -c \\ 0 & d (a - 2) \end{bmatrix} = \begin{bmatrix} x & y \\ z & - "
    r"z \end{bmatrix}",
    r"a \cdot -b \times (c + d) - \dot x (t) m(x) = \begin{cases} a - b & x > 0 \\ c & x < 0 "
    r"\end{cases}",
    r"|a - b| (c + d) = \pm a (b - c)",
    r"\half (a + b) - \twice{a - b} = c",
)
MACROS = {"\\half": (0, r"\frac{1}{2}"), "\\twice": (1, "2 (#1) + #1")}


def describe(chain: RelationChain) -> str:
    return re.sub(r"(start|end)=\d+,? ?", "", repr(chain))


def list_changes(latex: str) -> Iterator[tuple[int, int, str]]:
    for token in tokenize_formula(latex, MACROS):
        if not token.fixed:
            yield from (
                (token.start, token.end, new)
                for new in ("", "z", "t", "1", "+", "-", "(a - b)", "2 z")
            )
            yield from ((token.start, token.start, new) for new in ("-", "2 ", "z + "))
            yield from ((token.end, token.end, new) for new in ("^2", " + z", " - z y"))


def read(latex: str) -> str | None:
    try:
        return describe(read_formula(latex, MACROS))
    except FormulaError:
        return None


@pytest.mark.parametrize("latex", FORMULAS)
def test_changed_formula_is_read_as_when_read_as_a_whole(latex: str) -> None:
    rereader = Rereader(latex, read_formula(latex, MACROS), MACROS, {})
    outcomes = set()
    for start, end, new in list_changes(latex):
        changed = latex[:start] + new + latex[end:]
        try:
            tree = describe(rereader.read([(start, end, new)], changed))
        except FormulaError:
            tree = None
        assert tree == read(changed), changed
        outcomes.add(tree)
    assert len(outcomes) > 30


def test_only_the_changed_term_is_read_again(monkeypatch: pytest.MonkeyPatch) -> None:
    latex = FORMULAS[0]
    rereader, sources = Rereader(latex, read_formula(latex), {}, {}), list[str]()

    def note(source: str, *rest: object) -> tuple[tuple[int, Node], ...]:
        sources.append(source)
        return read_terms(source, *rest)  # type: ignore[arg-type]

    read_terms = corrections.read_terms
    monkeypatch.setattr(corrections, "read_terms", note)
    start = latex.index("l_1")
    rereader.read([(start, start + 3, "x")], latex.replace("l_1", "x"))
    assert sources == ["m x"]
