"""The audit as files: summary.json, and report.html with every equation as printed beside its verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from planter import __version__
from planter.audit import tables, typeset
from planter.report import files
from planter.report.html import Block, Cell, Folded, Items, Keys, Section, Table, Text, page

Entry = Mapping[str, Any]
_QUIET = ("confirmed", "definition", "reconstructed")
"""Verdicts that leave nothing to correct: their equations are folded."""


@dataclass(frozen=True)
class Formula:
    """An equation, typeset where that can be done, else as its text."""

    text: str

    def html(self, name: str) -> str:
        return typeset.equation(self.text) or f"<p><code>{escape(self.text)}</code></p>"


def write(out: str | Path, result: Mapping[str, Any]) -> None:
    """Writes summary.json and report.html. Raises InputError for a folder that it cannot write."""
    folder = files.output_folder(out)
    files.write_summary(folder / "summary.json", {**result, "provenance": {"planter": __version__}})
    files.write_text(folder / "report.html", text(result))


def text(result: Mapping[str, Any]) -> str:
    """The page of an audit."""
    subtitle = "Every equation and number of the papers, as printed and judged"
    return page("Formula audit", list(sections(result)), subtitle)


def sections(result: Mapping[str, Any]) -> Iterator[Section]:
    """An overview, the equations and numbers of each paper, and what the verdicts mean."""
    yield Section("Verdicts", [overview(result["summary"])])
    for paper, summary in result["summary"].items():
        mine = {part: [e for e in result[part] if e["paper"] == paper] for part in ("equations", "laws", "numbers")}
        yield Section(f"{summary['title']}: equations", list(equations(mine["equations"])))
        if mine["laws"]:
            yield Section(f"{summary['title']}: violated laws", [laws(mine["laws"])])
        yield Section(f"{summary['title']}: numbers", list(numbers(mine["numbers"])))
    yield Section("What the verdicts mean", [Keys(MEANINGS)])


def overview(summary: Mapping[str, Entry]) -> Block:
    """How often each verdict was given."""
    rows = [(s["title"], tables.tally(s["equations"]), tables.tally(s["numbers"])) for s in summary.values()]
    return Table(("paper", "equations", "numbers"), rows)


def equations(found: Sequence[Entry]) -> Iterator[Block]:
    """All equations in a table; those with something to correct in full, the others folded."""
    head = ("equation", "claims to be", "legibility", "verdict")
    rows = [(e["equation"], e.get("claims", ""), e["legibility"], e["verdict"]) for e in found]
    yield Table(head, rows)
    loud = [e for e in found if e["verdict"] not in _QUIET]
    for entry in loud:
        yield Folded(heading(entry), list(equation(entry)))
    quiet = [e for e in found if e["verdict"] in _QUIET and e["legibility"] != "lost" and e.get("printed")]
    blocks = [block for e in quiet for block in (Text(heading(e), "note"), Formula(e["printed"]))]
    if blocks:
        yield Folded("Equations without anything to correct", blocks)


def heading(entry: Entry) -> str:
    claims = f", {entry['claims']}" if entry.get("claims") else ""
    return f"({entry['equation']}){claims}: {entry['verdict']}"


def equation(entry: Entry) -> Iterator[Block]:
    """An equation as printed, what was found, corrections, missing terms with their sizes."""
    if entry.get("printed"):
        yield Formula(entry["printed"])
    yield Text(f"{entry['finding']}.")
    if entry["correction"]:
        yield Items([f"Smallest correction: {text}" for text in entry["correction"]])
    if entry["terms"]:
        rows = [(t["term"], t["max_abs"], t["unit"], t["share_of_largest"]) for t in entry["terms"]]
        yield Table(("missing term", "largest over the cycle", "unit", "share of the largest term"), rows)
    if entry["reading"]:
        yield Text(f"Read so: {entry['reading']}.", "note")


def laws(found: Sequence[Entry]) -> Block:
    """Laws that a printed chain as a whole violates."""
    rows = [(e["law"], e["violation"], e["unit"], ", ".join(e["caused_by"])) for e in found]
    return Table(("law", "violated by", "unit", "caused by"), rows)


def numbers(found: Sequence[Entry]) -> Iterator[Block]:
    """Numbers in a table, then what was assumed for some of them."""
    head = ("quantity", "unit", "printed", "recomputed", "verdict", "rests on")
    rows: list[Sequence[Cell]] = [
        (e["quantity"], e["unit"], e["printed_text"], e["recomputed"], e["verdict"], tables.basis(e)) for e in found
    ]
    yield Table(head, rows)
    longest: list[str] = max((e["assumed_inputs"] for e in found), key=len, default=[])
    if len(longest) > 2:
        yield Folded("Assumed inputs", [Items(longest)])


MEANINGS = {
    "confirmed": "the derivation gives the same",
    "misprint": "what differs is removed by one or two edits",
    "incomplete": "the print lacks terms that the derivation has",
    "contradicted": "a printed term is neither derived nor explained by an edit",
    "reconstructed": "the print is lost; the derivation stands alone",
    "definition": "names a quantity; there is nothing to derive",
    "reproduced": "equal at the printed precision, from disclosed inputs only",
    "consistent": "equal, and the assumed inputs hit more printed values than they are many",
    "not reproduced": "differs, from disclosed inputs only",
    "not recomputable": "rests on inputs that the paper does not disclose",
}
