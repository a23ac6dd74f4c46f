"""Files that nobody should hand in: a fixed corpus, and a generator that spoils good ones."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from planter.files import examples

NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1e308",
    "1e-320",
    "0",
    "-0.0",
    "-1",
    "1e15",
    "9" * 400,
    "0x10",
    "1_000",
    "1,5",
    "true",
    '""',
    '"12"',
    '"\\u0000"',
    "[]",
    "[1, 2]",
    "[[[]]]",
    "{}",
    "{ a = 1 }",
    "1979-05-27",
    "1.",
    ".5",
    "1e",
    "'''\n'''",
    "\U0001d7d8",
    "\u202e1",
)
"""What stands where a number should."""
PIECES = (
    "\x00",
    "\ufeff",
    "\r",
    "\t",
    "\x1b[31m",
    "\u2028",
    "]]",
    "[[",
    "=",
    "#",
    '"""',
    "'",
    "..",
    "a.b.c = 1",
    "[design]",
    "[origin]",
    "[" * 300,
    "name = 1",
    "=" * 50,
    "\xa0",
    "\ud7ff",
    "e\u0301",
    ";",
    ",,,,",
    "-" * 1000,
)
"""What stands where nothing should."""
CORPUS: tuple[bytes, ...] = (
    b"",
    b"\n",
    b"\x00",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"[",
    b"]",
    b"=",
    b"a",
    b"a=",
    b"[a]\n[a]",
    b"a = 1\na = 2",
    b"a = " + b"[" * 5000,
    b'a = "' + b"x" * 100_000 + b'"',
    b"x_mm,y_mm\n",
    b"x_mm;y_mm\n1;2\n",
    b"1,2,3\n" * 10,
    b"x_mm,y_mm\n" + b"nan,inf\n" * 20,
    b"x_mm,y_mm\n" + b"1e400,0\n" * 20,
    b"a,b\r\r\n1,2",
    b'"' * 99,
    b"\xff" * 64,
    bytes(range(256)),
    b"PK\x03\x04",
    b"%PDF-1.4",
    b"<html>",
    b"{}",
    b"null",
    b"import os",
    "name = '\u00e9'".encode("utf-16"),
    b"name = 'x'\n" * 2,
    b"[[pose]]\n" * 50,
)
"""The fixed corpus."""


@dataclass(frozen=True)
class Spoiled:
    """A good file after some blows."""

    name: str
    content: bytes


def _blow(lines: list[str], place: float, kind: str, piece: str, number: str) -> None:
    k = int(place * (len(lines) - 1))
    key, sign, _ = lines[k].partition("=")
    if kind == "number" and sign:
        lines[k] = f"{key}= {number}"
    elif kind == "cell":
        cells = lines[k].split(",")
        cells[len(piece) % len(cells)] = number
        lines[k] = ",".join(cells)
    elif kind == "drop":
        del lines[k]
    elif kind == "twice":
        lines.insert(k, lines[k])
    elif kind == "insert":
        lines.insert(k, piece)
    elif kind == "within":
        middle = len(lines[k]) // 2
        lines[k] = f"{lines[k][:middle]}{piece}{lines[k][middle:]}"
    elif kind == "cut":
        del lines[k:]
    elif kind == "exchange":
        lines[k], lines[-1] = lines[-1], lines[k]


KINDS = (
    "number",
    "number",
    "number",
    "cell",
    "drop",
    "twice",
    "insert",
    "within",
    "cut",
    "exchange",
)
BLOWS = st.lists(
    st.tuples(
        st.floats(0, 1), st.sampled_from(KINDS), st.sampled_from(PIECES), st.sampled_from(NUMBERS)
    ),
    min_size=1,
    max_size=4,
)
ENCODINGS = ("utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252")


@st.composite
def spoiled(draw: st.DrawFn, names: tuple[str, ...]) -> Spoiled:
    """A built-in file after one to four blows, in some encoding, with some line ends."""
    name = draw(st.sampled_from(names))
    lines = examples.example(name).splitlines() or [""]
    for blow in draw(BLOWS):
        _blow(lines, *blow)
        lines = lines or [""]
    ends = draw(st.sampled_from(("\n", "\n", "\r\n", "\r")))
    encoding = draw(st.sampled_from(ENCODINGS))
    return Spoiled(name, ends.join(lines).encode(encoding, errors="replace"))
