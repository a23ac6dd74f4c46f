"""A self-contained HTML page: sections of text, keys, tables and figures in one file.

The page loads no external resources, and every text is escaped. Its content security policy allows at most one script,
by its hash. It follows the reader's light or dark setting; printed, it is black on white.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape as escaped
from string import Template
from typing import Protocol, runtime_checkable

from planter import safe_text
from planter.report import style

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
    """A part with CSS `style`, animated by an ES module `script`, which may be empty; without it the part is static."""

    @property
    def script(self) -> str: ...

    @property
    def style(self) -> str: ...


@dataclass(frozen=True)
class Section:
    """A heading and the blocks below it."""

    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Text:
    """A paragraph; `kind` may be `note` or `warning`."""

    text: str
    kind: str = ""

    def html(self, name: str) -> str:
        attribute = f' class="{escape_markup(self.kind)}"' if self.kind else ""
        return f"<p{attribute}>{escape_markup(self.text)}</p>"


@dataclass(frozen=True)
class Items:
    """A list of sentences."""

    items: Sequence[str]
    kind: str = ""

    def html(self, name: str) -> str:
        attribute = f' class="{escape_markup(self.kind)}"' if self.kind else ""
        return _lines(f"<ul{attribute}>", *(f"<li>{escape_markup(item)}</li>" for item in self.items), "</ul>")


@dataclass(frozen=True)
class Keys:
    """A list of names, each with a value."""

    pairs: Mapping[str, Cell]

    def html(self, name: str) -> str:
        rows = (
            f"<div><dt>{escape_markup(key)}</dt><dd>{cell_text(value)}</dd></div>" for key, value in self.pairs.items()
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
        caption = f"<caption>{escape_markup(self.caption)}</caption>" if self.caption else ""
        head = "".join(f'<th scope="col">{escape_markup(column)}</th>' for column in self.head)
        body = (f"<tr>{''.join(_cell(i, value) for i, value in enumerate(row))}</tr>" for row in self.rows)
        opened, closed = '<div class="wide"><table>', "</tbody></table></div>"
        return _lines(opened, caption, f"<thead><tr>{head}</tr></thead>", "<tbody>", *body, closed)


@dataclass(frozen=True)
class FigureSvg:
    """A drawing, as the SVG text of `style.render_svg`, and its caption."""

    svg: str
    caption: str = ""

    def html(self, name: str) -> str:
        caption = f"<figcaption>{escape_markup(self.caption)}</figcaption>" if self.caption else ""
        return _lines("<figure>", inline_svg(self.svg, name, self.caption), caption, "</figure>")


@dataclass(frozen=True)
class Folded:
    """A collapsible part with a title, which is printed expanded."""

    title: str
    blocks: Sequence[Block] = field(default_factory=tuple)

    def html(self, name: str) -> str:
        parts = (block.html(f"{name}-{i}") for i, block in enumerate(self.blocks))
        return _lines(f'<details open="open"><summary>{escape_markup(self.title)}</summary>', *parts, "</details>")


def escape_markup(text: str) -> str:
    """Return a text with markup escaped and invisible characters written out."""
    return escaped(safe_text.sanitise_text(text))


def cell_text(value: Cell) -> str:
    """Return a value as escaped text, numbers with at most six digits.

    >>> cell_text(62.33105858627), cell_text(0.1 + 0.2), cell_text("a < b"), cell_text(True)
    ('62.3311', '0.3', 'a &lt; b', 'yes')
    """
    if value is None:
        return "\N{EN DASH}"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value}".replace("-", "\N{MINUS SIGN}")
    if isinstance(value, float):
        return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")
    return value.markup if isinstance(value, MarkupCell) else escape_markup(value)


def inline_svg(svg: str, name: str, label: str = "") -> str:
    """Return SVG text as a part of a page: without prologue and size, with ids prefixed by `name`."""
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>\s*", "", body, flags=re.DOTALL)
    for pattern in (r'(\bid=")', r'(href="#)', r"(url\(#)"):
        body = re.sub(pattern, rf"\g<1>{name}-", body)
    body = re.sub(r'(<svg\b[^>]*?) width="[^"]*"', r"\1", body, count=1)
    body = re.sub(r'(<svg\b[^>]*?) height="[^"]*"', r"\1", body, count=1)
    return body.replace("<svg", f'<svg role="img" aria-label="{escape_markup(label)}"', 1).strip()


def render_page(title: str, sections: Sequence[Section], subtitle: str = "", extra_style: str = "") -> str:
    """Return the page as text; `extra_style` is additional CSS."""
    moving = [block for section in sections for block in section.blocks if isinstance(block, Scripted)]
    script = "".join(dict.fromkeys(block.script for block in moving))
    bodies = [_section(i, section) for i, section in enumerate(sections, 1)]
    links = (f'<li><a href="#s{i}">{escape_markup(s.title)}</a></li>' for i, s in enumerate(sections, 1))
    return _PAGE.substitute(
        title=escape_markup(title),
        subtitle=f'<p class="subtitle">{escape_markup(subtitle)}</p>' if subtitle else "",
        links="\n".join(links),
        body="\n".join(bodies),
        style=Template(_STYLE).substitute(ink=style.INK, paper=style.PAPER)
        + "".join(dict.fromkeys(block.style for block in moving))
        + extra_style,
        policy=f"default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src {policy_source(script)}",
        script=f'<script type="module">{script}</script>' if script else "",
    )


def policy_source(text: str) -> str:
    """Return the source of a content security policy for a script or style: its hash, or `none` if it is empty."""
    if not text:
        return "'none'"
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def _section(number: int, section: Section) -> str:
    parts = (block.html(f"s{number}-{i}") for i, block in enumerate(section.blocks, 1))
    return _lines(f'<section id="s{number}">', f"<h2>{escape_markup(section.title)}</h2>", *parts, "</section>")


def _cell(index: int, value: Cell) -> str:
    if index == 0:
        return f'<th scope="row">{cell_text(value)}</th>'
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return f'<td class="number">{cell_text(value)}</td>' if is_number else f"<td>{cell_text(value)}</td>"


def _lines(*parts: str) -> str:
    return "\n".join(part for part in parts if part)


# Figures are drawn in ink on paper; on a dark screen these two colours are exchanged.
_STYLE = """\
:root { color-scheme: light dark; --paper: #fefefe; --ink: #1b2430; --soft: #5d6672; --rule: #d5d9de;
  --warn: #a33c00; --warn-paper: #fff3ea; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181d; --ink: #e6e9ed; --soft: #a5adb8; --rule: #39414b;
  --warn: #ffb27d; --warn-paper: #33221a; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 52rem; padding: 1.5rem 1.25rem 4rem; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2.5rem 0 .6rem; padding-top: .6rem; border-top: 1px solid var(--rule); }
.subtitle, .note, caption, figcaption, nav { color: var(--soft); }
.subtitle { margin: .3rem 0 0; }
nav ol { display: flex; flex-wrap: wrap; gap: .1rem 1.2rem; list-style: none; margin: 1rem 0 0; padding: 0; }
a { color: inherit; }
.warning { background: var(--warn-paper); color: var(--warn); padding: .5rem .8rem; border-left: 3px solid; }
ul.warning { padding-left: 2rem; }
dl { display: flex; flex-wrap: wrap; gap: .5rem 2rem; margin: .8rem 0; }
dl > div { min-width: 8rem; }
dt { color: var(--soft); font-size: .85rem; }
dd { margin: 0; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; padding-bottom: .3rem; }
th, td { padding: .2rem .9rem .2rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--rule); }
th { font-weight: 600; }
tbody th { font-weight: 400; }
.number { text-align: right; white-space: nowrap; }
figure { margin: 1rem 0; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { font-size: .9rem; margin-top: .4rem; }
summary { cursor: pointer; color: var(--soft); margin: .8rem 0; }
@media screen and (prefers-color-scheme: dark) { svg [style*="fill: $ink"] { fill: var(--ink) !important; }
  svg [style*="stroke: $ink"] { stroke: var(--ink) !important; }
  svg [style*="fill: $paper"] { fill: var(--paper) !important; }
  svg [style*="stroke: $paper"] { stroke: var(--paper) !important; } }
@media print { :root { color-scheme: light; --paper: #fff; --ink: #000; --soft: #444; --rule: #bbb; --warn: #000;
  --warn-paper: #fff; } @page { margin: 18mm; } body { max-width: none; padding: 0; font-size: 10pt; }
  nav { display: none; } h2 { break-after: avoid; } figure svg { max-height: 95mm; }
  figure, tr, dl > div { break-inside: avoid; } caption, summary, thead { break-after: avoid; }
  thead { display: table-header-group; } .wide { overflow: visible; } }
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
<h1>$title</h1>
$subtitle
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
