"""Texts compared with a mechanism: what the names file may say, and errors in the files."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

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
