"""Rows of displayed equations: where one ends and the next begins."""

from derive.texts.documents import build_document, list_rows

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
