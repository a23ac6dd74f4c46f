"""Texts compared with a mechanism: what the names file may say, and errors in the files."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from derive.audit.record import record_equation
from derive.generated_folder import OwnError
from derive.texts.trial import read_trial
from tests.support import own

TEXT = r"""\begin{align}
 s &= r\cos\varphi + l\cos\beta \label{eq:s}\\
 T &= \frac{1}{2} m_s \dot{s}^2
\end{align}"""


@pytest.mark.parametrize(
    ("file", "content", "words"),
    [
        ("names.toml", "[names]\n'T' = 3\n", ("names.T", "text")),
        ("names.toml", "[names]\n'T' = \"kinetc()\"\n", ("names.T", "kinetc")),
        ("names.toml", "[names]\n'T' = \"__import__('os')\"\n", ("names.T", "__import__")),
        ("names.toml", "[names]\n'T = ' = \"r\"\n", ("T = ", "no name")),
        ("names.toml", "[nmes]\n'T' = \"r\"\n", ("nmes",)),
        ("names.toml", '[rows.99]\nskip = "no"\n', ("rows.99", "eq:s")),
        ("names.toml", "[rows.'eq:s']\nclaims = \"what F_gs is\"\n", ("rows.eq:s.claims", "what F_gas is")),
        ("names.toml", "[rows.1]\nnames = { T = 3 }\n", ("rows.1.names", "quotes")),
        ("names.toml", "until_s = -1\n", ("until_s", "positive")),
        ("names.toml", "[names\n", ("names.toml",)),
        ("slider_crank.py", "1 + \n", ("slider_crank.py",)),
        ("slider_crank.py", "x = 1\n", ("slider_crank.py", "Mechanism")),
        ("crank.tex", "\xff", ("crank.tex", "UTF-8")),
        ("crank.ipynb", "{", ("crank.ipynb", "notebook")),
        ("crank.pdf", "%PDF", ("crank.pdf", ".tex")),
    ],
)
def test_error_names_file_and_key(tmp_path: Path, file: str, content: str, words: tuple[str, ...]) -> None:
    shutil.copy(own.EXAMPLES / "slider_crank.py", tmp_path)
    (tmp_path / "crank.tex").write_text(TEXT, encoding="utf-8")
    (tmp_path / "names.toml").write_text("", encoding="utf-8")
    (tmp_path / file).write_bytes(content.encode("latin-1"))
    text = file if file.startswith("crank.") else "crank.tex"
    with pytest.raises(OwnError) as refused:
        read_trial(tmp_path / text, tmp_path / "slider_crank.py", tmp_path / "names.toml")
    for word in words:
        assert word in str(refused.value)
    assert "\n" not in str(refused.value)


FRAMES = """
from derive import Mechanism, quantities

q = quantities("l | m | arm | 0.4\\nm_1 | kg | mass | 2\\nT_1 | s | period | 1\\nT_2 | s | period | 3")
m = Mechanism("arm", q)
alpha = m.coordinate("alpha", "rad", "turn")
N, A = m.world, m.frame("A", alpha)
P = m.point("P", m.O, A, q.l)
L = m.name_("L", "N m", "moment", q.l * q.m_1 * m.motion.acceleration(P, A)[1])
"""
VECTORS = r"""\begin{align}
 ^N\omega^A &= \dot\alpha \hat{a}_3 \label{spin}\\
 L &= (\bar{r} \times m_1\,\bar{a}) \cdot \hat{a}_3 \label{cross}\\
 \frac{{}^Nd\bar{r}}{dt} &= \frac{{}^Ad\bar{r}}{dt} + {}^N\omega^A \times \bar{r} \label{seen}\\
 T &= T_1 \label{first}\\
 T &= T_2 \label{second}
\end{align}"""
VECTOR_NAMES = """
[names]
'^N\\omega^A' = "spin(A)"
'\\hat{a}_3' = "axis(A, 3)"
'\\bar{r}' = "position(P)"
'\\bar{a}' = "acceleration(P)"
'T' = "T_1"
[rows.second]
names = { 'T' = "T_2" }
"""


def test_frames_products_and_names_of_a_row_have_their_meaning(tmp_path: Path) -> None:
    for name, content in (("arm.py", FRAMES), ("arm.tex", VECTORS), ("arm.toml", VECTOR_NAMES)):
        (tmp_path / name).write_text(content, encoding="utf-8")
    case = read_trial(tmp_path / "arm.tex", tmp_path / "arm.py", tmp_path / "arm.toml")
    assert [row.reason for row in case.source.rows] == [""] * 5
    for number, equation in case.paper.equations.items():
        assert equation.residual == 0 or record_equation(case, number, "")["verdict"] == "confirmed", number
