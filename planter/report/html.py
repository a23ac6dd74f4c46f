"""A self-contained HTML page: sections of text, keys, tables and figures in one file.

A page opens with a conclusion, key figures and a picture. It loads no external resources, and every
text is escaped. Its content security policy allows at most one script, by its hash. It follows the
reader's light or dark setting, and is printed in light colours on A4.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape as escaped
from string import Template
from typing import Protocol, TypeGuard, runtime_checkable

from planter import safe_text
from planter.files import units
from planter.report import style

MANY_COLUMNS = 7
"""Columns from which on a table is printed in smaller type."""
WHOLE_ROWS = 14
"""Rows up to which a table is printed on one sheet."""
SHORT, LONG = 10, 24
"""Characters up to which a text stays on one line, and from which on it has a column of some
width.
"""
CLASS_NUMBER = ' class="number"'
Cell = str | int | float | bool | None
"""A value in a table; None is displayed as a dash."""


class MarkupCell(str):
    """A cell that is its text on a terminal and `markup`, which must be well formed, on a page."""

    markup: str

    def __new__(cls, text: str, markup: str) -> MarkupCell:
        cell = super().__new__(cls, text)
        cell.markup = markup
        return cell


class Block(Protocol):
    """A part of a section."""

    def html(self, name: str) -> str:
        """Return the part as HTML; `name` is unique on the page."""
        ...


@runtime_checkable
class Scripted(Block, Protocol):
    """A part with CSS `style`, animated by an ES module `script`, which may be empty; without it
    the part is static.
    """

    @property
    def script(self) -> str: ...

    @property
    def style(self) -> str: ...


@dataclass(frozen=True)
class Section:
    """A heading and the blocks below it; a `detail` is never in the main part of a page."""

    title: str
    blocks: Sequence[Block]
    detail: bool = False

    @property
    def lines(self) -> int:
        """Estimated height in print, in rows of a table."""
        return HEADING_LINES + sum(map(count_lines, self.blocks))


@dataclass(frozen=True)
class Text:
    """A paragraph; `kind` may be `note` or `warning`."""

    text: str
    kind: str = ""

    def html(self, name: str) -> str:
        attribute = f' class="{escape_markup(self.kind)}"' if self.kind else ""
        return f"<p{attribute}>{typeset_numbers(self.text)}</p>"


@dataclass(frozen=True)
class Conclusion:
    """The sentences that a page opens with, after the `failures`: what does not satisfy its
    limit.
    """

    text: str
    failures: Sequence[str] = ()

    def html(self, name: str) -> str:
        """Return the sentences as HTML."""
        kinds = [*((' class="failure"', text) for text in self.failures), ("", self.text)]
        paragraphs = (f"<p{kind}>{typeset_numbers(text)}</p>" for kind, text in kinds if text)
        kind = " failed" if self.failures else ""
        return f'<div class="conclusion{kind}">{"".join(paragraphs)}</div>'


@dataclass(frozen=True)
class Command:
    """The command line that gives a result."""

    line: str

    def html(self, name: str) -> str:
        """Return the line as HTML."""
        return f"<pre>{escape_markup(self.line)}</pre>"


@dataclass(frozen=True)
class KeyFigure:
    """A number that a page opens with, as text, with its unit, and what it is."""

    value: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class KeyFigures:
    """The numbers that a page opens with, three of them."""

    figures: Sequence[KeyFigure]

    def html(self, name: str) -> str:
        """Return the numbers as HTML."""
        rows = (
            f"<div><dt>{typeset_numbers(figure.meaning)}</dt><dd>{escape_markup(figure.value)} "
            f"<small>{escape_markup(units.typeset_unit(figure.unit))}</small></dd></div>"
            for figure in self.figures
        )
        return _lines('<dl class="key-figures">', *rows, "</dl>")


@dataclass(frozen=True)
class Items:
    """A list of sentences."""

    items: Sequence[str]
    kind: str = ""

    def html(self, name: str) -> str:
        attribute = f' class="{escape_markup(self.kind)}"' if self.kind else ""
        return _lines(
            f"<ul{attribute}>",
            *(f"<li>{typeset_numbers(item)}</li>" for item in self.items),
            "</ul>",
        )


@dataclass(frozen=True)
class Keys:
    """A list of names, each with a value."""

    pairs: Mapping[str, Cell]

    def html(self, name: str) -> str:
        rows = (
            f"<div><dt>{typeset_label(key)}</dt><dd>{cell_text(value)}</dd></div>"
            for key, value in self.pairs.items()
        )
        return _lines("<dl>", *rows, "</dl>")


@dataclass(frozen=True)
class Table:
    """Rows under column heads; numbers are right-aligned. The first cell of a row is its heading.

    A terminal is too narrow for the columns `page_columns`, which only a page has.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    page_columns: Collection[str] = ()

    def html(self, name: str) -> str:
        caption = f"<caption>{typeset_numbers(self.caption)}</caption>" if self.caption else ""
        numbers = {
            index
            for index in range(1, len(self.head))
            if self.rows and all(is_number(row[index]) or row[index] is None for row in self.rows)
        }
        head = "".join(
            f"<th "
            f'scope="col"{CLASS_NUMBER if index in numbers else ""}>{typeset_label(column)}</th>'
            if column
            else "<td></td>"
            for index, column in enumerate(self.head)
        )
        unit_columns = {index for index, column in enumerate(self.head) if column == "unit"}
        cells = (
            [
                units.typeset_unit(value)
                if index in unit_columns and isinstance(value, str)
                else value
                for index, value in enumerate(row)
            ]
            for row in self.rows
        )
        body = (
            f"<tr>{''.join(_cell(i, value, i in numbers) for i, value in enumerate(row))}</tr>"
            for row in cells
        )
        kind = ' class="many"' if len(self.head) > MANY_COLUMNS else ""
        unbroken = " whole" if len(self.rows) <= WHOLE_ROWS else ""
        opened = f'<div class="wide{unbroken}" tabindex="0"><table{kind}>'
        closed = "</tbody></table></div>"
        return _lines(opened, caption, f"<thead><tr>{head}</tr></thead>", "<tbody>", *body, closed)


@dataclass(frozen=True)
class FigureSvg:
    """A drawing, as the SVG text of `style.render_svg`, its caption, and its name for readers who
    cannot see it.
    """

    svg: str
    caption: str = ""
    name: str = ""

    def html(self, name: str) -> str:
        caption = (
            f"<figcaption>{typeset_numbers(self.caption)}</figcaption>" if self.caption else ""
        )
        return _lines(
            "<figure>", inline_svg(self.svg, name, self.caption or self.name), caption, "</figure>"
        )


@dataclass(frozen=True)
class Folded:
    """A collapsible part with a title, which is printed expanded."""

    title: str
    blocks: Sequence[Block] = field(default_factory=tuple)

    def html(self, name: str) -> str:
        parts = (block.html(f"{name}-{i}") for i, block in enumerate(self.blocks))
        return _lines(
            f'<details open="open"><summary>{escape_markup(self.title)}</summary>',
            *parts,
            "</details>",
        )


HEADING_LINES = 3
"""Height of a heading in print, in rows of a table."""
PAGE_LINES = 50
"""Rows of a table that a printed page has room for."""
LINE_LETTERS = 105
"""Letters of a line of text in print."""
FIGURE_LINES = 17
"""Height of a figure with its caption in print, in rows of a table."""


def count_lines(block: Block) -> int:
    """Return the estimated height of a block in print, in rows of a table."""
    if isinstance(block, Table):
        share = LINE_LETTERS / len(block.head)
        return 3 + sum(_count_row_lines(row, share) for row in block.rows)
    if isinstance(block, Folded):
        return 2 + sum(map(count_lines, block.blocks))
    if isinstance(block, Items):
        return sum(1 + len(item) // LINE_LETTERS for item in block.items)
    if isinstance(block, Keys):
        return 2 * (1 + len(block.pairs) // 4)
    if isinstance(block, Text):
        return 1 + len(block.text) // LINE_LETTERS
    return FIGURE_LINES


def _count_row_lines(row: Sequence[Cell], share: float) -> int:
    """Return the lines of a row: long texts are given about twice the `share` of letters."""
    return max(
        (1 + int(len(cell) / (2 * share)) for cell in row if isinstance(cell, str)), default=1
    )


def escape_markup(text: str) -> str:
    """Return a text with markup escaped and invisible characters written out."""
    return escaped(safe_text.sanitise_text(text))


def cell_text(value: Cell) -> str:
    """Return a value as escaped text, numbers with at most six digits.

    >>> cell_text(62.33105858627), cell_text(-0.0), cell_text("a < b"), cell_text(True)
    ('62.3311', '0', 'a &lt; b', 'yes')
    """
    if value is None:
        return "\N{EN DASH}"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value}".replace("-", "\N{MINUS SIGN}")
    if isinstance(value, float):
        return f"{value + 0.0:.6g}".replace("-", "\N{MINUS SIGN}")  # zero has no sign
    return value.markup if isinstance(value, MarkupCell) else typeset_numbers(value)


def typeset_label(label: str) -> str:
    """Return a label as escaped text, with the unit behind its last stroke, if it has one, as
    `typeset_unit` does.
    """
    return escape_markup(units.typeset_label(label))


def typeset_numbers(text: str) -> str:
    r"""Return a text as escaped text whose negative numbers have a minus sign, and angles the sign
    of degrees.

    >>> [typeset_numbers(text).count("\N{MINUS SIGN}") for text in ("between -3.2 and 1e-06", "x-2 in 2026-11")]
    [2, 0]
    >>> typeset_numbers("at 12.5 deg of 360 deg, 5 deg/s, from 5 deg.csv")
    'at 12.5° of 360°, 5 deg/s, from 5 deg.csv'
    """
    minus = re.sub(
        r"(?:(?<![\w.\])-])|(?<=\de))-(?=\.?\d)", "\N{MINUS SIGN}", units.typeset_degrees(text)
    )
    return escape_markup(minus)


def inline_svg(svg: str, name: str, label: str = "") -> str:
    """Return SVG text as a part of a page: without prologue and size, with ids prefixed by
    `name`.
    """
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>\s*", "", body, flags=re.DOTALL)
    for pattern in (r'(\bid=")', r'(href="#)', r"(url\(#)"):
        body = re.sub(pattern, rf"\g<1>{name}-", body)
    body = re.sub(r'(<svg\b[^>]*?) width="[^"]*"', r"\1", body, count=1)
    body = re.sub(r'(<svg\b[^>]*?) height="[^"]*"', r"\1", body, count=1)
    return body.replace("<svg", f'<svg role="img" aria-label="{escape_markup(label)}"', 1).strip()


def render_page(
    title: str,
    sections: Sequence[Section],
    subtitle: str = "",
    extra_style: str = "",
    lead: Sequence[Block] = (),
    details: Sequence[Section] = (),
) -> str:
    """Return the page as text; `lead` are the blocks that it opens with, `extra_style` is
    additional CSS. The `details` are folded on screen, and printed from a new sheet on.
    """
    parts_of_page = [*sections, *details]
    blocks = [*lead, *(block for section in parts_of_page for block in section.blocks)]
    moving = [block for block in blocks if isinstance(block, Scripted)]
    parts = [block.html(f"lead-{number}") for number, block in enumerate(lead, 1)]
    script = "".join(dict.fromkeys(block.script for block in moving))
    bodies = [_section(i, section) for i, section in enumerate(sections, 1)]
    folded = [_fold(i, section) for i, section in enumerate(details, len(sections) + 1)]
    if folded:
        bodies += ['<div class="details">', *folded, "</div>"]
    links = (
        f'<li><a href="#s{i}">{escape_markup(s.title)}</a></li>'
        for i, s in enumerate(parts_of_page, 1)
    )
    return _PAGE.substitute(
        title=escape_markup(title),
        subtitle=escape_markup(subtitle),
        lead=_lines('<div class="lead">', *parts, "</div>") if parts else "",
        links="\n".join(links),
        body="\n".join(bodies),
        style=Template(_STYLE).substitute(shades=_DARK_RULES)
        + "".join(dict.fromkeys(block.style for block in moving))
        + extra_style,
        policy=f"default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src "
        f"{policy_source(script)}",
        script=f'<script type="module">{script}</script>' if script else "",
    )


def policy_source(text: str) -> str:
    """Return the source of a content security policy for a script or style: its hash, or `none` if
    it is empty.
    """
    if not text:
        return "'none'"
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def _fold(number: int, section: Section) -> str:
    """Return a section that a reader opens; a link to what is in it opens it."""
    parts = (block.html(f"s{number}-{i}") for i, block in enumerate(section.blocks, 1))
    return _lines(
        f"<details><summary><h2>{escape_markup(section.title)}</h2></summary>",
        f'<div id="s{number}">',
        *parts,
        "</div></details>",
    )


def _section(number: int, section: Section) -> str:
    parts = (block.html(f"s{number}-{i}") for i, block in enumerate(section.blocks, 1))
    return _lines(
        f'<section id="s{number}">',
        f"<h2>{escape_markup(section.title)}</h2>",
        *parts,
        "</section>",
    )


def _cell(index: int, value: Cell, in_numbers: bool) -> str:
    if index and (is_number(value) or in_numbers):
        return f"<td{CLASS_NUMBER}>{cell_text(value)}</td>"
    length = len(re.sub(r"<[^>]*>", "", cell_text(value)))
    kind = ' class="short"' if length <= SHORT else ' class="long"' if length >= LONG else ""
    return (
        f"<td{kind}>{cell_text(value)}</td>"
        if index
        else f'<th scope="row"{kind}>{cell_text(value)}</th>'
    )


def is_number(value: Cell) -> TypeGuard[int | float]:
    """Return whether a cell is a number, which a truth value is not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _lines(*parts: str) -> str:
    return "\n".join(part for part in parts if part)


_DARK_RULES = "\n  ".join(
    f'svg [style*="{part}: {shade}"] {{ {part}: {dark} !important; }}'
    for shade, dark in {
        style.INK: "var(--ink)",
        style.PAPER: "var(--paper)",
        **style.DARK_SHADES,
    }.items()
    for part in ("fill", "stroke")
)
"""Figures are drawn in ink on paper; on a dark screen these two colours are exchanged, and others
are lighter.
"""
_STYLE = """\
:root { color-scheme: light dark; --canvas: #eef1f4; --paper: #fefefe; --sunk: #f6f8fa; --ink: #141c26; --soft: #4c5766;
  --rule: #d8dee6; --edge: #78838f; --a: #0b5cad; --good: #0a6640; --good-paper: #e4f4ec; --warn: #775200;
  --warn-paper: #fff3d6; --bad: #b3201a; --bad-paper: #fdebe9; }
@media (prefers-color-scheme: dark) { :root { --canvas: #0c1015; --paper: #151b22; --sunk: #1b222b; --ink: #e8edf2;
  --soft: #aab5c2; --rule: #2c3641; --edge: #76828f; --a: #74b6ff; --good: #63d69f; --good-paper: #12301f;
  --warn: #f0c25c; --warn-paper: #33290f; --bad: #ff8d83; --bad-paper: #3a1917; } }
* { box-sizing: border-box; }
html { background: var(--canvas); }
body { margin: 0 auto; max-width: 860px; padding: 28px 40px 48px; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
  font-variant-numeric: tabular-nums; }
h1 { font-size: 25px; line-height: 1.2; margin: 6px 0 2px; letter-spacing: -.01em; overflow-wrap: anywhere; }
h2 { font-size: 17px; margin: 30px 0 6px; }
p { margin: 6px 0; overflow-wrap: anywhere; }
.soft, .note, caption, figcaption, nav, .mast { color: var(--soft); }
.mast { display: flex; justify-content: space-between; gap: 10px; flex-wrap: wrap; font-size: 12.5px;
  border-bottom: 1px solid var(--rule); padding-bottom: 8px; }
.mast b { color: var(--ink); }
.conclusion { border-left: 4px solid var(--a); background: var(--sunk); padding: 12px 16px; margin: 16px 0 8px;
  font-size: 18px; line-height: 1.42; }
.conclusion p { margin: 0; } .conclusion p + p { margin-top: 6px; }
.conclusion.failed { border-color: var(--bad); }
.conclusion .failure { color: var(--bad); font-weight: 600; }
.key-figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(12rem, 100%), 1fr)); gap: 12px;
  margin: 14px 0; }
.key-figures > div { display: flex; flex-direction: column-reverse; justify-content: flex-end; min-width: 0;
  border: 1px solid var(--rule); border-radius: 6px; padding: 10px 12px; }
.key-figures dd { font-size: 27px; line-height: 1.15; letter-spacing: -.02em; font-weight: 650; }
.key-figures dd small { font-size: 15px; font-weight: 400; letter-spacing: 0; }
.key-figures dt { font-size: 12.5px; }
nav ol { display: flex; flex-wrap: wrap; gap: .1rem 1.2rem; list-style: none; margin: 1rem 0 0; padding: 0;
  font-size: 13px; }
nav a { display: inline-block; min-height: 24px; }
a { color: inherit; }
.warning { background: var(--warn-paper); color: var(--warn); padding: .5rem .8rem; border-left: 4px solid; }
ul.warning { padding-left: 2rem; }
dl { display: flex; flex-wrap: wrap; gap: .5rem 2rem; margin: .8rem 0; }
dl > div { min-width: 8rem; }
dt { color: var(--soft); font-size: .85rem; }
dd { margin: 0; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: 13.5px; min-width: 50%; }
caption { text-align: left; padding-bottom: .3rem; }
th, td { padding: 4px 14px 4px 0; text-align: left; vertical-align: baseline; border-bottom: 1px solid var(--rule); }
thead th { color: var(--soft); font-size: 12.5px; font-weight: 400; border-bottom: 1.5px solid var(--edge); }
thead th.number { white-space: normal; }
tbody th { font-weight: 400; } th small { display: block; color: var(--soft); font-size: 11.5px; }
td:not(.number, .short) { min-width: 4rem; } td.long { min-width: 11rem; }
.short { white-space: nowrap; }
.number { text-align: right; white-space: nowrap; }
figure { margin: 1rem 0; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { font-size: 13px; margin-top: .4rem; }
summary { cursor: pointer; color: var(--soft); margin: .8rem 0; min-height: 24px; }
.details { margin-top: 30px; } .details > details { border-top: 1px solid var(--rule); }
summary > h2 { display: inline; color: var(--ink); }
pre { background: var(--sunk); border: 1px solid var(--rule); border-radius: 6px; padding: 10px 14px; overflow-x: auto;
  font: 13px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; margin: 6px 0; white-space: pre-wrap;
  overflow-wrap: anywhere; }
@media (max-width: 640px) { body { padding: 16px 16px 40px; } h1 { font-size: 22px; } .conclusion { font-size: 16.5px; }
  .key-figures { grid-template-columns: minmax(0, 1fr); gap: 8px; } figure { overflow-x: auto; }
  figure > svg { min-width: 620px; }
  tbody th { position: sticky; left: 0; background: var(--paper); max-width: 45vw; overflow-wrap: anywhere; }
  tbody th:not(.short) { min-width: 6.5rem; } tbody th.long { min-width: 9.5rem; } }
@media screen and (prefers-color-scheme: dark) { $shades }
@page { size: A4; margin: 12mm 15mm; }
@media print { :root { color-scheme: light; --canvas: #fff; --paper: #fff; --sunk: #f6f8fa; --ink: #141c26;
  --soft: #4c5766; --rule: #d8dee6; --edge: #78838f; --a: #0b5cad; --good: #0a6640; --good-paper: #e4f4ec;
  --warn: #775200; --warn-paper: #fff3d6; --bad: #b3201a; --bad-paper: #fdebe9; }
  html, body { background: #fff; } body { max-width: none; padding: 0; font-size: 10pt; }
  * { print-color-adjust: exact; }
  nav { display: none; } h2 { break-after: avoid; margin-top: 18px; } figure svg { max-height: 240mm; }
  .conclusion { font-size: 12pt; padding: 8px 12px; margin: 8px 0; } .key-figures { margin: 8px 0; }
  .key-figures dt { font-size: 9pt; }
  .lead .planter-view svg { max-height: 78mm; }
  .details { break-before: page; margin-top: 0; }
  details::details-content { content-visibility: visible; height: auto; }
  figure, tr, dl > div, .key-figures, .conclusion { break-inside: avoid; }
  caption, summary, thead { break-after: avoid; } tbody > tr:first-child { break-before: avoid; }
  thead { display: table-header-group; } .wide { overflow: visible; } .wide.whole { break-inside: avoid; }
  table { font-size: 8.5pt; max-width: 100%; } thead th { font-size: 8pt; }
  table.many, table.many thead th { font-size: 7pt; } th small { font-size: 7.5pt; }
  table.many :is(th, td) { padding-right: 6px; } table.many th small { font-size: 7pt; }
  th, td:not(.number, .short), td.long { overflow-wrap: break-word; min-width: 0; }
  .long, table.many :is(tbody th, td:not(.number, .short)) { overflow-wrap: anywhere; } }
"""

_PAGE = Template("""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8" />
<meta http-equiv="Content-Security-Policy" content="$policy" />
<meta name="viewport" content="width=device-width, initial-scale=1" />
<title>$title</title>
<style>
$style</style>
</head>
<body>
<header>
<div class="mast"><span><b>planter</b> report</span><span>$subtitle</span></div>
<h1>$title</h1>
$lead
<nav aria-label="contents"><ol>
$links
</ol></nav>
</header>
<main>
$body
</main>
$script
</body>
</html>
""")
