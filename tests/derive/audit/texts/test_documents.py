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
