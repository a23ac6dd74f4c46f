"""Displayed equations of a text in LaTeX, Markdown, reStructuredText or a notebook: each row with
its place.
"""

from __future__ import annotations

import json
import re
from bisect import bisect
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from ...generated_folder import OwnError

SUFFIXES = (".tex", ".md", ".rst", ".ipynb")
"""Endings of the names of texts that can be read."""
_NUMBERED = (
    "equation",
    "align",
    "gather",
    "multline",
    "eqnarray",
    "alignat",
    "flalign",
    "dmath",
    "IEEEeqnarray",
)
_PLAIN = ("displaymath", "math")
_GROUPS = ("aligned", "split", "gathered", "alignedat", "subequations")
_SYSTEMS = ("array", "aligned", "cases", "matrix")
_ENVIRONMENT = "|".join([name + r"\*?" for name in _NUMBERED] + list(_PLAIN))
_DISPLAY = re.compile(
    rf"\\begin\{{({_ENVIRONMENT})\}}(?P<body>.*?)\\end\{{\1\}}|\\\[(?P<bracket>.*?)\\\]|(?<!\\)\$\$(?P<dollar>.*?)\$\$",
    re.S,
)
_RELATION = re.compile(
    r"=|<|>|\\(?:leq?|geq?|lt|gt|leqslant|geqslant|approx|equiv|simeq|triangleq|neq?|propto|sim|in|to|rightarrow"
    r"|Rightarrow|implies|mapsto)(?![A-Za-z])"
)
_REMARK = re.compile(
    r"\\(?:label|tag\*?|eqno|hspace\*?|vspace\*?)\s*\{[^{}]*\}|\\(?:nonumber|notag|quad|qquad|displaystyle)(?![A-Za-z])"
    r"|\\[,;:! ]|[&~\s]"
)
_BREAK = re.compile(r"\\\\\*?(?:\s*\[[^\]]*\])?|\\cr(?![A-Za-z])|\\newline(?![A-Za-z])")
_SPACE = r"(?:\\q?quad(?![A-Za-z])|\\[,;:! ]|[\s~&])*"
_ARROW = (
    rf"{_SPACE}\\(?:Rightarrow|rightarrow|Longrightarrow|longrightarrow|implies|iff|Leftrightarrow|Longleftrightarrow"
    rf"|therefore|leadsto)(?![A-Za-z]){_SPACE}"
)
_WORDS = re.compile(rf"{_SPACE}\\(?:text|textrm|textnormal|mbox|mathrm)\s*\{{([^{{}}]*)\}}")
_ATOM = r"[-+]?\s*(?:\d[\d.]*)?\s*\\?[A-Za-z]*(?:\{[^{}]*\})?(?:[_^](?:\{[^{}]*\}|\\[A-Za-z]+|\w))*(?:/\d+)?[\s.,;]*"
_CONNECTING = (
    r"(?:\W*\b(?:then|and|or|so|that|thus|hence|therefore|consequently|finally|also)\b)*\W*"
)
_CONDITION = (
    r"(?i)\b(?:if|when|whenever|for|near|at|small|assum\w*|suppos\w*|unless|provided|case|initial\w*"
    r"|rest|static\w*)\b"
)
_ANNOUNCING = (
    r"(?is).*\b(?:define|calculate|compute|write|written|expressed|obtain|get|have|find|follows|gives?|yields?|becomes?)\b"
    r".*(?::|\bas)\s*"
)
_BETWEEN = re.compile(
    rf"(?P<arrow>(?:,|;)?{_ARROW})|"
    r"(?:,|;)?\s*(?:\\qquad|\\quad\s*\\quad|,\s*\\quad|;\s*\\quad"
    r"|(?:\\quad|\\,|\\ "
    r"|\s)*\\(?:text|mbox|mathrm|textrm)\s*\{\s*,?\s*(?:and|or|with|where|und|et)\s*,?\s*\}"
    r"(?:\\quad|\\,|\\ |\s)*)"
)


_COMMENT = r"(?<!\\)(?:\\\\)*%[^\n]*"
_BLANK = re.compile(
    r"(?:\s|\$\$|\\[\[\]]|\\(?:begin|end)\{[a-z]+\*?\}|</?[a-z]+[^<>]*>|\\\\|\.\. math::)*"
)
"""What may stand between a row and the next one if that begins with the equality sign and so goes
on from it.
"""


@dataclass(frozen=True)
class Row:
    """A displayed equation: its number, its own LaTeX, the file and the line [1, 2, ...] at which
    it begins.

    ``refused`` says why it is no equation, where that shows before its formula is read.
    """

    number: str
    latex: str
    file: str
    line: int
    refused: str = ""


@dataclass(frozen=True)
class TextDocument:
    """A text with what is no equation blanked out, its macros, and the line in the file of each of
    its lines.
    """

    name: str
    kind: str
    text: str
    lines: tuple[int, ...]
    macros: dict[str, tuple[int, str]] = field(default_factory=dict)

    def line_at(self, position: int) -> int:
        """Return the line in the file of a position in the text."""
        return self.lines[self.text.count("\n", 0, position)]


def read_document(path: Path) -> TextDocument:
    """Read a text. Raises OwnError, which names the file, if it is none that can be read."""
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise OwnError(f"{path}: the text must end in one of {', '.join(SUFFIXES)}")
    try:
        source = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise OwnError(f"{path}: byte {error.start} is not UTF-8: save the text in UTF-8") from None
    except OSError as error:
        raise OwnError(f"{path}: {error.strerror}") from None
    return build_document(path.name, kind, source)


def build_document(name: str, kind: str, source: str) -> TextDocument:
    """Build a document from its source. Raises OwnError for a notebook that is no JSON."""
    source = source.replace("\r\n", "\n").replace("\r", "\n")
    if kind == ".ipynb":
        text, lines = _read_notebook(name, source)
    else:
        text, lines = source, tuple(range(1, source.count("\n") + 2))
    text = _unbox(_blank_out(text, kind))
    if kind != ".tex":
        for display in _list_displays(TextDocument(name, kind, text, lines)):
            body = re.sub(_COMMENT, _blank, text[display.start : display.end])
            if kind == ".md":  # Markdown itself escapes what it would take for emphasis
                body = re.sub(r"(?<!\\)\\_(?=[A-Za-z0-9{\\])", " _", body)
            text = text[: display.start] + body + text[display.end :]
    return TextDocument(name, kind, text, lines, find_macros(text))


def _read_notebook(name: str, source: str) -> tuple[str, tuple[int, ...]]:
    """Return the text of the Markdown cells, and for each of its lines the line in the file."""
    try:
        cells = json.loads(source)["cells"]
        texts = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown"]
    except (ValueError, KeyError, TypeError) as error:
        raise OwnError(f"{name}: this is no notebook: {type(error).__name__}: {error}") from None
    in_file, at = source.split("\n"), 0
    lines: list[int] = []
    text = "\n\n".join(texts)
    for line in text.split("\n"):
        inner = json.dumps(line, ensure_ascii=False)[1:-1]
        escaped = json.dumps(line)[1:-1]
        if line.strip():
            at = next(
                (
                    k
                    for k in range(at, len(in_file))
                    if inner in in_file[k] or escaped in in_file[k]
                ),
                at,
            )
        lines.append(at + 1)
    return text, tuple(lines)


def _blank_out(text: str, kind: str) -> str:
    """Return a text of the same length without comments, code and what stands after its end."""
    if kind == ".tex":
        patterns = [
            _COMMENT,
            r"\\begin\{(verbatim|lstlisting|minted|comment)\*?\}.*?\\end\{\1\*?\}",
            r"\\iffalse(?![A-Za-z]).*?\\fi(?![A-Za-z])",
            r"\\end\{document\}.*",
        ]
    else:
        patterns = [r"<!--.*?-->"]
    if kind in (".md", ".ipynb"):
        patterns += [r"^(?P<fence>```+|~~~+)(?P<info>[^\n]*)\n.*?^(?P=fence)[ \t]*$"]
        patterns += [r"(?<!`)`[^`\n]+`(?!`)"]
    for pattern in patterns:
        text = re.sub(pattern, _blank, text, flags=re.S | re.M)
    return text


def _unbox(text: str) -> str:
    """Return a text of the same length without boxes around whole equations."""
    for match in re.finditer(r"\\boxed\s*\{", text):
        end = find_group_end(text, match.end() - 1)
        if end is not None and _RELATION.search(_hide(text[match.end() : end - 1])):
            text = (
                text[: match.start()]
                + " " * len(match.group())
                + text[match.end() : end - 1]
                + " "
                + text[end:]
            )
    return text


def _blank(match: re.Match[str]) -> str:
    """Return as many blanks as were matched, what a fence of mathematics holds unchanged."""
    if match.groupdict().get("info", "").strip() in ("math", "{math}"):
        return match.group()
    return re.sub(r"[^\n]", " ", match.group())


def find_macros(text: str) -> dict[str, tuple[int, str]]:
    """Return the macros that a text defines, by name: the number of their arguments, and their
    bodies.
    """
    macros: dict[str, tuple[int, str]] = {}
    head = re.compile(
        r"\\(?:(?:re)?newcommand|providecommand|def|DeclareMathOperator)\*?\s*\{?\s*(\\[A-Za-z]+)\s*\}?"
        r"\s*(?:\[(\d)\])?((?:#\d)*)\s*(?=\{)"
    )
    for match in head.finditer(text):
        end = find_group_end(text, match.end())
        if end is not None:
            count = int(match.group(2) or len(match.group(3)) // 2)
            body = text[match.end() + 1 : end - 1]
            operator = match.group().startswith("\\DeclareMathOperator")
            macros[match.group(1)] = count, rf"\operatorname{{{body}}}" if operator else body
    return macros


def find_group_end(text: str, start: int) -> int | None:
    """Return the position after a braced group that begins at ``start``, None if it is not
    closed.
    """
    depth = 0
    for match in re.compile(r"\\.|[{}]", re.S).finditer(text, start):
        depth += {"{": 1, "}": -1}.get(match.group(), 0)
        if depth == 0 and match.group() == "}":
            return match.end()
    return None


@dataclass(frozen=True)
class _Display:
    """A displayed formula: where its body begins and ends, whether its rows are numbered, and its
    label.

    ``refused`` says why it is passed over, empty if it is read.
    """

    start: int
    end: int
    numbered: bool
    single: bool
    label: str = ""
    refused: str = ""


def list_rows(document: TextDocument) -> list[Row]:
    """List every row of every displayed equation of a document, continued lines joined, in their
    order.

    A number is that of a tag or label, else that which LaTeX counts, else the line; none stands
    twice.
    """
    rows: list[Row] = []
    numbers: set[str] = set()
    count, stop = 0, 0
    for display in sorted(_list_displays(document), key=lambda display: display.start):
        spans = list(_list_spans(document, display))
        for index, (start, end) in enumerate(spans):
            latex = document.text[start:end]
            silent = bool(re.search(r"\\(?:nonumber|notag)(?![A-Za-z])", latex))
            counted = display.numbered and not silent and (index == 0 or not display.single)
            count += counted
            tag = re.search(r"\\tag\*?\s*\{([^{}]*)\}", latex)
            label = re.search(r"\\label\s*\{([^{}]*)\}", latex)
            line = document.line_at(start)
            name = tag.group(1) if tag else label.group(1) if label else display.label
            if name and name in numbers:
                name = f"{name} {chr(ord('a') + index % 26)}"
            name = name or (str(count) if counted else "")
            if not name or name in numbers:
                name = next(n for n in _line_names(line) if n not in numbers)
            numbers.add(name)
            clean = latex[_opening_words(latex) :].strip()
            if rows and re.match(r"&?\s*=", clean) and _BLANK.fullmatch(document.text[stop:start]):
                clean = f"{_left_side(rows[-1].latex)} {clean}".strip()
            stop = end
            refused = display.refused
            if not _RELATION.search(clean):
                refused = "no relation stands in it: it states nothing"
            rows.append(Row(" ".join(name.split()), clean, document.name, line, refused))
    return rows


def _left_side(latex: str) -> str:
    """Return what stands before the first relation of a row, empty if it has none."""
    relation = _RELATION.search(_hide(latex))
    return latex[: relation.start()].strip().lstrip("&") if relation else ""


def _line_names(line: int) -> Iterator[str]:
    yield f"line {line}"
    yield from (f"line {line}{chr(ord('a') + k)}" for k in range(26))
    yield from (f"line {line} {k}" for k in range(1000))


def _list_displays(document: TextDocument) -> Iterator[_Display]:
    text = document.text
    directives = list(_list_directives(text)) if document.kind in (".rst", ".md") else []
    for display in directives:
        if not _DISPLAY.search(text, display.start, display.end):
            yield display
    for match in _DISPLAY.finditer(text):
        group = next(
            name for name in ("body", "bracket", "dollar") if match.group(name) is not None
        )
        start, end = match.span(group)
        environment = (match.group(1) or "").rstrip("*")
        if head := re.match(r"\s*(?:\{[lcrsS|*\d]*\})?", text[start:end]):
            start += head.end() if environment in ("alignat", "IEEEeqnarray") else 0
        numbered = environment in _NUMBERED and not (match.group(1) or "").endswith("*")
        label = next((d.label for d in directives if d.start <= start < d.end), "")
        yield _Display(
            start, end, numbered, environment in ("equation", "multline", "dmath", ""), label
        )
    if document.kind != ".rst":
        yield from _list_single_dollars(text)


_ALONE = re.compile(
    r"^[ \t]*(?:(?:[-*+]|\d+[.)])[ \t]+)?(?:\$(?!\$)(?P<line>(?:\\.|[^$\\\n])+)\$(?!\$)"
    r"|\$[ \t]*\n(?P<block>(?:\\.|[^$\\])+?)\n[ \t]*\$(?!\$))[ \t]*[.,;]?[ \t]*(?:\\\\|<br[ "
    r"\t]*/?>)?[ \t]*$",
    re.M,
)
"""A formula between single dollars that has its line, or its lines, to itself."""
_GOES_ON = re.compile(
    r"[ \t]*\n[ \t]*(?!(?:where|with|and|so|thus|hence|therefore|which|in which|here|by)\b)[a-z]"
)
"""A line after a formula that goes on with its sentence, and does not explain the formula."""
IN_SENTENCE = (
    "passed over: it stands between single dollars in the lines of a sentence; write it "
    "between $$ to have it read"
)


def _list_single_dollars(text: str) -> Iterator[_Display]:
    """Yield formulas between single dollars that are alone on a line; those that a sentence goes
    through, or makes a condition, are passed over.
    """
    displays = [match.span() for match in _DISPLAY.finditer(text)]
    alone = [
        match
        for match in _ALONE.finditer(text)
        if not any(a <= match.start() < b for a, b in displays)
    ]
    hidden = _ALONE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)
    breaks = [0, *(match.end() - 1 for match in re.finditer(r"\n[ \t]*\n", text)), len(text)]
    for match in alone:
        start, end = match.span("line" if match.group("line") is not None else "block")
        at = bisect(breaks, match.start())
        paragraph = hidden[breaks[at - 1] : max(match.end(), breaks[at])]
        words_before = hidden[breaks[at - 1] : match.start()]
        words_after = hidden[match.end() : max(match.end(), breaks[at])]
        opening = " ".join(re.split(r"[.,:;]\s", words_before)[-1].split()[-2:])
        is_inside = re.search(_CONDITION, opening) or _GOES_ON.match(words_after)
        if not paragraph.strip() or _RELATION.search(text[start:end]):
            yield _Display(start, end, False, True, "", IN_SENTENCE if is_inside else "")


def _list_directives(text: str) -> Iterator[_Display]:
    """Yield the math directives of reStructuredText, and fenced math of Markdown."""
    fence = re.compile(r"^(```+|~~~+)[ \t]*\{?math\}?[ \t]*\n(?P<body>.*?)^\1[ \t]*$", re.S | re.M)
    for match in fence.finditer(text):
        named = re.search(r"^:label:[ \t]*(\S+)", match.group("body"), re.M)
        options = re.match(r"(?:[ \t]*:\w+:[^\n]*\n)*", match.group("body"))
        start = match.start("body") + (options.end() if options else 0)
        yield _Display(start, match.end("body"), False, False, named.group(1) if named else "")
    directive = re.compile(r"^(?P<indent>[ \t]*)\.\. math::[ \t]*(?P<first>[^\n]*)\n", re.M)
    for match in directive.finditer(text):
        indent = len(match.group("indent").expandtabs())
        start, end, label = match.start("first"), match.end(), ""
        body_begins = bool(match.group("first").strip())
        while end < len(text):
            stop = text.find("\n", end)
            stop = len(text) if stop < 0 else stop + 1
            line = text[end:stop]
            if line.strip() and len(line.expandtabs()) - len(line.expandtabs().lstrip()) <= indent:
                break
            option = re.match(r"\s*:(\w+):[ \t]*(\S*)", line)
            if option and not body_begins:
                label = option.group(2) if option.group(1) == "label" else label
                start = stop
            elif line.strip():
                body_begins = True
            end = stop
        yield _Display(start, end, False, False, label)


def _list_spans(document: TextDocument, display: _Display) -> Iterator[tuple[int, int]]:
    """Yield the ranges of the rows of a display, without blanks at their ends."""
    text = document.text
    start, end = _unwrap(text, display.start, display.end)
    blank_lines = document.kind in (".rst", ".md")
    pieces = [
        piece
        for part in _split_at_breaks(text, start, end, blank_lines)
        for piece in _split_row(text, *part)
    ]
    if re.search(r"\\begin\{multline", text[max(0, display.start - 20) : display.start]):
        pieces = [(start, end)]
    for row_start, row_end in _join(text, pieces):
        body = text[row_start:row_end]
        if re.search(r"\w", _REMARK.sub("", body)):
            inner = len(body) - len(body.lstrip())
            yield row_start + inner, row_start + len(body.rstrip())


def _opening_words(row: str) -> int:
    """Return the length of words before an equation that only announce it: then, or "we can write"
    with a colon.

    Words that name a condition, or what the equation is of, belong to it.
    """
    length = 0
    while match := _WORDS.match(row, length):
        words = match.group(1)
        announces = re.fullmatch(_CONNECTING, words) or re.fullmatch(_ANNOUNCING, words)
        relation = _RELATION.search(_hide(row[match.end() :]))
        follows = relation and re.search(
            r"\w", _REMARK.sub("", row[match.end() : match.end() + relation.start()])
        )
        if not words.strip() or not announces or re.search(_CONDITION, words) or not follows:
            break
        length = match.end()
    return length


def _is_condition(piece: str) -> bool:
    """Return whether all sides of a piece are single names or numbers, as in theta = 0: a case, and
    no finding.
    """
    return all(
        re.fullmatch(rf"\s*{_ATOM}", _REMARK.sub(" ", side)) for side in _RELATION.split(piece)
    )


def _states_side_by_side(line: str) -> bool:
    """Return whether several cells of a line of an array are equations of their own."""
    cells = re.split(r"(?<!\\)&", _hide(line))
    return (
        sum(
            bool(re.search(rf"[\w)\]}}][^=]*(?:{_RELATION.pattern})\s*[\w\\(\[{{+-]", cell))
            for cell in cells
        )
        > 1
    )


def _unwrap(text: str, start: int, end: int) -> tuple[int, int]:
    """Return the inner range of a display that is nothing but one aligned group, or a system behind
    a brace.

    Markdown has environments such as align also between dollars.
    """
    names = "|".join((*_GROUPS, *_SYSTEMS, *(rf"{name}\*?" for name in _NUMBERED)))
    wrapped = re.compile(
        rf"(?s)\s*(?:\\label\{{[^{{}}]*\}}\s*)?(?P<brace>\\left\s*\\\{{\s*|\\left\s*\\lbrace\s*)?"
        rf"\\begin\{{(?P<name>{names})\}}(?:\[.\])?(?:\{{[lcr|@\s\d]*\}})?(?P<body>.*)\\end\{{(?P=name)\}}"
        r"\s*(?:\\right\s*\.)?[\s,.;]*(?:\\label\{[^{}]*\})?[\s,.;]*$"
    )
    match = wrapped.match(text[start:end])
    if match is None or (
        match.group("name") in _SYSTEMS[2:] and not _RELATION.search(match.group("body"))
    ):
        return start, end
    groups, body = (*_GROUPS, *_NUMBERED, "cases"), match.group("body")
    is_array = match.group("name") == "array"
    lines = [body[slice(*part)] for part in _split_at_breaks(body, 0, len(body), False)]
    if is_array and (any(map(_states_side_by_side, lines)) or not _RELATION.search(_hide(body))):
        return start, end
    if match.group("name").rstrip("*") not in groups and not match.group("brace") and not is_array:
        return start, end
    if rf"\end{{{match.group('name')}}}" in body:
        return start, end
    return _unwrap(text, start + match.start("body"), start + match.end("body"))


def _split_at_breaks(
    text: str, start: int, end: int, blank_lines: bool
) -> Iterator[tuple[int, int]]:
    """Yield the ranges between line breaks outside of environments and groups, and between
    texts.
    """
    pattern = re.compile(
        rf"\\(?:intertext|shortintertext)\s*\{{|\\begin\s*\{{|\\end\s*\{{|{_BREAK.pattern}|\\.|[{{}}]"
        + (r"|\n[ \t]*\n" if blank_lines else ""),
        re.S,
    )
    depth, at, position = 0, start, start
    while match := pattern.search(text, position, end):
        piece, position = match.group(), match.end()
        if "intertext" in piece and depth == 0:
            stop = find_group_end(text, position - 1) or end
            yield at, match.start()
            at = position = stop
        elif piece.startswith(("\\begin", "\\end")):
            depth += 1 if piece.startswith("\\begin") else -1
            position = find_group_end(text, position - 1) or end
        elif piece in "{}" and piece:
            depth += 1 if piece == "{" else -1
        elif depth == 0 and (_BREAK.fullmatch(piece) or not piece.strip()):
            yield at, match.start()
            at = position
    yield at, end


def _split_row(text: str, start: int, end: int) -> Iterator[tuple[int, int]]:
    """Yield several equations of one line one by one."""
    at = start
    for match in _BETWEEN.finditer(text, start, end):
        before, after = _hide(text[at : match.start()]), _hide(text[match.end() : end])
        if match["arrow"] and _is_condition(text[at : match.start()]):
            continue
        if (
            _RELATION.search(before)
            and _RELATION.search(after)
            and _is_balanced(text[at : match.start()])
        ):
            yield from _split_columns(text, at, match.start())
            at = match.end()
    yield from _split_columns(text, at, end)


def _split_columns(text: str, start: int, end: int) -> Iterator[tuple[int, int]]:
    """Yield the equations of pairs of columns, each with a relation; else the whole."""
    marks = [m.start() for m in re.finditer(r"(?<!\\)&", _hide(text[start:end]))]
    cuts = [0, *(mark for index, mark in enumerate(marks) if index % 2), end - start]
    parts = [(start + a, start + b) for a, b in pairwise(cuts)]
    stated = [part for part in parts if re.search(r"\w", _REMARK.sub("", text[slice(*part)]))]
    if len(stated) > 1 and all(_RELATION.search(_hide(text[slice(*part)])) for part in stated):
        yield from stated
    else:
        yield start, end


def _is_balanced(piece: str) -> bool:
    return piece.count("{") == piece.count("}") and piece.count("\\begin") == piece.count("\\end")


def _hide(piece: str) -> str:
    """Return a piece of the same length with environments, groups and remarks replaced by
    blanks.
    """
    out, depth, position = list(piece), 0, 0
    for match in re.finditer(r"\\begin\s*\{[^{}]*\}|\\end\s*\{[^{}]*\}|\\[{}]|[{}]", piece):
        if depth:
            out[position : match.start()] = " " * (match.start() - position)
        token = match.group()
        opens = token == "{" or token.startswith("\\begin")
        closes = token == "}" or token.startswith("\\end")
        depth += opens - closes
        if opens or closes:
            out[match.start() : match.end()] = " " * (match.end() - match.start())
        position = match.end()
    return "".join(out)


def _join(text: str, pieces: list[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Yield the ranges of rows: a line that goes on from the one before is joined to it.

    A line goes on if it has no relation, begins with one, or follows a line that ends with an
    operator, a relation or inside a bracket. What stands between joined lines remains part of the
    row.
    """
    joined: list[tuple[int, int]] = []
    for start, end in pieces:
        bare = _REMARK.sub("", _hide(text[start:end]))
        if not re.search(r"\S", bare):
            if "\\begin" in text[start:end]:
                joined.append((start, end))
            continue
        arrow = re.match(_ARROW, text[start:end])
        if arrow and joined and not _is_condition(text[slice(*joined[-1])]):
            joined.append((start + arrow.end(), end))
            continue
        relation = _RELATION.search(bare)
        goes_on = joined and (
            arrow
            or relation is None
            or relation.start() == 0
            or _is_open(text[slice(*joined[-1])], text[joined[-1][1] : start])
        )
        if goes_on and "intertext" not in text[joined[-1][1] : start]:
            joined[-1] = joined[-1][0], end
        else:
            joined.append((start, end))
    yield from joined


def _is_open(piece: str, _gap: str) -> bool:
    """Return whether a line ends inside a bracket, on an operator, or on a relation."""
    bare = _REMARK.sub("", _hide(piece))
    bare = re.sub(r"\\[{}]|\\(?:left|right|bigg?[lr]?|Bigg?[lr]?)(?![A-Za-z])", "", bare)
    if sum(map(bare.count, "([")) > sum(map(bare.count, ")]")):
        return True
    if re.search(r"\\end\s*\{[^{}]*\}[\s&.,;]*$", piece):
        return False
    tail = r"(?:[+\-*/=<>]|\\(?:cdot|times|pm|mp|leq?|geq?|equiv|approx))$"
    return bool(re.search(tail, bare) and re.search(tail, _REMARK.sub("", piece)))
