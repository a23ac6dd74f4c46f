"""Rows of displayed equations: where one ends and the next begins."""

import pytest

from derive.audit.texts.documents import build_document, list_rows

MATRICES = r"""
.. math::
   :label: inertia

   \mathbf{I} =
   \begin{bmatrix}
     A & 0\\
     0 & B
   \end{bmatrix}
   = \mathbf{J} =
   \begin{bmatrix}
     C & 0\\
     0 & D
   \end{bmatrix}

   \mathbf{K} =
   \begin{bmatrix}
     A & 0\\
     0 & A
   \end{bmatrix}
"""


def test_blank_line_ends_a_row_with_a_matrix() -> None:
    rows = list_rows(build_document("a.rst", ".rst", MATRICES))
    assert [(row.number, row.line) for row in rows] == [("inertia", 5), ("inertia b", 16)]
    assert rows[1].latex.startswith(r"\mathbf{K}")


def _rows(body: str) -> list[str]:
    return [
        " ".join(row.latex.split())
        for row in list_rows(build_document("a.tex", ".tex", rf"\[ {body} \]"))
    ]


@pytest.mark.parametrize(
    ("body", "rows"),
    [
        (r"\begin{array}{rcl} x &=& r \\ y &=& s + l \end{array}", ["x &=& r", "y &=& s + l"]),
        (r"\begin{array}{rcl} x &=& r \\ &=& s + l \end{array}", [r"x &=& r \\ &=& s + l"]),
        (r"\begin{array}{c} x \\ y \end{array} = 0", [r"\begin{array}{c} x \\ y \end{array} = 0"]),
        (
            r"\begin{array}{cc} x = r & y = s \end{array}",
            [r"\begin{array}{cc} x = r & y = s \end{array}"],
        ),
        (r"m a = F + k x \Rightarrow a = F/m + k x/m", ["m a = F + k x", "a = F/m + k x/m"]),
        (
            r"x = r s \quad\implies\quad y = s \qquad \rightarrow z = r",
            ["x = r s", "y = s \\qquad \\rightarrow z = r"],
        ),
        (r"\theta = 0 \Rightarrow x = r", [r"\theta = 0 \Rightarrow x = r"]),
        (r"m_1 = m_2 \implies x = r", [r"m_1 = m_2 \implies x = r"]),
        (r"x \to 0 \Rightarrow y = r", [r"x \to 0 \Rightarrow y = r"]),
        (r"\begin{gathered} x = r + s \\ \Rightarrow y = r \end{gathered}", ["x = r + s", "y = r"]),
        (
            r"\begin{gathered} x = 0 \\ \Rightarrow y = r \end{gathered}",
            [r"x = 0 \\ \Rightarrow y = r"],
        ),
        (r"\boxed{x = r + s}", ["x = r + s"]),
        (r"\boxed{x + r} s = l", [r"\boxed{x + r} s = l"]),
        (r"\text{Let us define: } x = r", ["x = r"]),
        (r"\textrm{then } \quad x = r", [r"\quad x = r"]),
        (r"\text{then it can be written as } x = r", ["x = r"]),
        (r"\text{if } x = r", [r"\text{if } x = r"]),
        (r"\text{at rest we find: } x = r", [r"\text{at rest we find: } x = r"]),
        (r"\text{Force on the body: } x = r", [r"\text{Force on the body: } x = r"]),
        (r"\text{torque of } x = r", [r"\text{torque of } x = r"]),
        (r"\text{so} = r", [r"\text{so} = r"]),
    ],
)
def test_rows_end_where_an_equation_does(body: str, rows: list[str]) -> None:
    assert _rows(body) == rows


# environments between dollars, as Markdown has them


@pytest.mark.parametrize("environment", ["align", "align*", "equation", "gather"])
def test_environment_between_dollars_gives_rows(environment: str) -> None:
    source = f"$$\n\\begin{{{environment}}}\na &= b \\\\\nc &= d\n\\end{{{environment}}}\n$$\n"
    rows = list_rows(build_document("text.md", ".md", source))
    assert [(row.latex, row.line) for row in rows] == [("a &= b", 3), ("c &= d", 4)]


def test_two_environments_between_dollars_are_not_dropped() -> None:
    source = "$$\n\\begin{align}a &= b\\end{align}\n\\begin{align}c &= d\\end{align}\n$$\n"
    (row,) = list_rows(build_document("text.md", ".md", source))
    assert row.line == 2


def test_row_that_ends_with_a_matrix_is_not_continued() -> None:
    lines = (
        "& A = \\begin{bmatrix} 1 \\\\ 2 \\end{bmatrix}\\\\",
        "& B = {x}\\\\",
        "& C = y +\\\\",
        "& z",
    )
    source = ".. math::\n" + "".join(f"    {line}\n" for line in lines)
    rows = list_rows(build_document("text.rst", ".rst", source))
    assert [row.line for row in rows] == [2, 3, 4]


def test_display_that_begins_with_equality_goes_on_from_the_one_before() -> None:
    source = "$$ a^2 = b + c $$\n\n</br>\n\n$$ = d $$\n\n$$ = e $$\n\nIt follows:\n\n$$ = f $$\n"
    rows = list_rows(build_document("text.md", ".md", source))
    assert [row.latex for row in rows] == ["a^2 = b + c", "a^2 = d", "a^2 = e", "= f"]
    assert [row.line for row in rows] == [1, 5, 7, 11]


def test_comments_in_displays_of_markdown_and_rst_are_left_out() -> None:
    source = ".. math::\n    a &= b % + \\left[ c\n    \\\\\n    d &= 5\\% e\n\n100% text = c\n"
    rows = list_rows(build_document("text.rst", ".rst", source))
    assert [" ".join(row.latex.split()) for row in rows] == ["a &= b", "d &= 5\\% e"]


def test_fences_of_mathematics_and_of_code_do_not_swallow_each_other() -> None:
    source = (
        "```math\na = b\n```\nText.\n```math\nc = d\n```\n```python\ne = f\n```\n```math\ng "
        "= h\n```\n"
    )
    assert [row.latex for row in list_rows(build_document("text.md", ".md", source))] == [
        "a = b",
        "c = d",
        "g = h",
    ]


def test_underscores_that_markdown_escapes_are_subscripts() -> None:
    (row,) = list_rows(build_document("text.md", ".md", "$$ \\dot{x}\\_p = T\\_{cart} \\\\_ $$\n"))
    assert row.latex == "\\dot{x} _p = T _{cart} \\\\_"


def test_formulas_between_single_dollars_that_are_alone_are_rows() -> None:
    source = (
        "The place is\n\n$ a = b $\n\n$c = d$.\n$e = f$\n\n- $g = h$\n\n$\ni = "
        "\\frac{j}{k}\n$\n\n$$ l = m $$\n"
    )
    rows = list_rows(build_document("text.md", ".md", source))
    assert [(row.latex, row.line, row.refused) for row in rows] == [
        ("a = b", 3, ""),
        ("c = d", 5, ""),
        ("e = f", 6, ""),
        ("g = h", 8, ""),
        ("i = \\frac{j}{k}", 11, ""),
        ("l = m", 14, ""),
    ]


@pytest.mark.parametrize("suffix", [".md", ".tex"])
def test_formula_alone_on_a_line_of_a_sentence_is_told(suffix: str) -> None:
    source = "It runs where\n$a = b$\nholds; $c = d$ and\n$x$\nare inline if\n$e = f$.\n"
    rows = list_rows(build_document(f"text{suffix}", suffix, source))
    assert [(row.latex, row.line) for row in rows] == [("a = b", 2), ("e = f", 6)]
    assert all("passed over" in row.refused for row in rows)


def test_formula_alone_on_a_line_that_words_lead_to_is_a_row() -> None:
    source = (
        "The force is\n$a = b$\nwhere $b$ is known. It follows that\n$c = d$,\n$e = f$.\nNow for "
        "small angles:\n$g = h$\n"
    )
    rows = list_rows(build_document("text.md", ".md", source))
    assert [(row.latex, row.line, row.refused) for row in rows] == [
        ("a = b", 2, ""),
        ("c = d", 4, ""),
        ("e = f", 5, ""),
        ("g = h", 7, ""),
    ]


def test_inline_formulas_and_prices_are_no_rows() -> None:
    source = "It costs $5 = cheap.\n\nWith $a = b$ it turns, and $c = d$.\n\n| $e = f$ | $g$ |\n"
    assert list_rows(build_document("text.md", ".md", source)) == []
