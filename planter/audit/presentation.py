"""Presentation of an audit: findings first, then laws, causes, equations, statements and numbers of
each paper.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any, TypeVar

from planter.audit import numbers
from planter.audit.equation_page import format_change, list_equation_blocks, mark_verdict
from planter.audit.registry import EXPERIMENTS, FRONTS
from planter.audit.results import AuditResult
from planter.audit.verdicts import HEADLINE, UNJUDGED
from planter.errors import InputError
from planter.progress import Listener
from planter.report import files, style
from planter.report.html import (
    Block,
    Cell,
    FigureSvg,
    Folded,
    Items,
    KeyFigure,
    Keys,
    Section,
    Table,
    Text,
)
from planter.report.labels import clean_zero
from planter.report.presentation import ResultPresentation
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Entry = Mapping[str, Any]
FrontTable = Mapping[str, Any]
SomeEntry = TypeVar("SomeEntry", bound=Callable[..., FrontTable])
TRANSCRIBED = "The equations were audited as transcribed, each against an independent derivation."
SOURCE = (
    "The machine-read text of each paper was audited, not its page images; gaps that were filled "
    "in are listed, and a "
    "finding that depends on one character may be an error of reading. If a symbol is ambiguous, "
    "the reading most "
    "favourable to the paper counts."
)
READ = (
    "The displayed equations were read from the text's own LaTeX, and each was compared with the "
    "mechanism's motion at "
    "random values. A name means what the file of names says, else the quantity whose name it "
    "spells: see that it does."
)
NUMBER_VERDICTS = ("not reproduced", "not recomputable", "consistent", "reproduced")
"""Verdicts on numbers, the most serious first."""


def present_audit(result: Mapping[str, Any], typeset: Entry) -> ResultPresentation:
    """Return the presentation of an audit; `typeset` has the formulas as MathML by paper and
    equation.
    """
    counts = result["summary"].values()
    equations, numbers = (
        sum(sum(s[part].values()) for s in counts) for part in ("equations", "numbers")
    )
    at_fault = sum(s["at_fault"] for s in counts)
    differing = sum(s["numbers"].get("not reproduced", 0) for s in counts)
    laws = result.get("laws", ())
    figures = {
        "printed equations are at fault": (at_fault, equations),
        "laws are broken": (sum(bool(law["caused_by"]) for law in laws), len(laws)),
        "printed numbers are not reproduced": (differing, numbers),
    }
    counted = [(f"{count} of {total}", words) for words, (count, total) in figures.items() if total]
    front, experiment = result.get("front"), result.get("experiment")
    return ResultPresentation(
        title="Formula audit",
        conclusion=f"{'; '.join(map(' '.join, counted)) or 'No equation was judged'}.",
        key_figures=[KeyFigure(share, "", words) for share, words in counted],
        record=AuditResult.read(result),
        sections=list(_list_sections(result, typeset)),
        details=lambda: [
            *([] if front is None else [build_figure_section(front)]),
            *([] if experiment is None else [build_experiment_figure(experiment)]),
            Section("Meanings of the terms", [Keys(MEANINGS)]),
        ],
        texts=lambda: {
            **({} if front is None else format_front_files(front)),
            **(
                {}
                if experiment is None
                else format_figure_files("experiment", plot_hypotheses(experiment))
            ),
        },
        summary_parts=result,  # its keys are in the order of the stored verdicts
        provenance={"planter": __version__},
    )


def _list_sections(result: Mapping[str, Any], typeset: Entry) -> Iterator[Section]:
    yield Section("Summary", list(_summarise(result)))
    for paper in result["summary"]:
        entries = _group_parts(result, paper)
        formulas = typeset.get(paper, {})
        yield from (
            Section(f"{paper}: {part}", list(list_blocks(entries[part], formulas)))
            for part, list_blocks in PARTS.items()
            if entries[part]
        )
    if "rows" in result:
        yield from _list_text_sections(result)
    if "front" in result:
        yield from list_front_sections(result["front"])
    if "experiment" in result:
        yield from list_experiment_sections(result["experiment"])


def _list_text_sections(result: Mapping[str, Any]) -> Iterator[Section]:
    """Yield the corrections in the LaTeX of a text, and the rows of it that are not judged."""
    if corrected := [e for e in result["equations"] if e.get("corrected_latex")]:
        yield Section(
            "Corrections in the text's own LaTeX", [Items([format_change(e) for e in corrected])]
        )
    rows = result["rows"]
    unjudged = [
        (f"{row['file']}:{row['line']}", row["status"], row["reason"])
        for row in rows
        if row["reason"]
    ]
    if unjudged:
        read = sum(row["status"] == "read" for row in rows)
        counted = (
            f"{read} of {len(rows)} displayed rows were read, {len(rows) - len(unjudged)} "
            f"judged; the others:"
        )
        yield Section(
            "Rows that are not judged", [Text(counted), Table(("place", "row", "reason"), unjudged)]
        )


def _group_parts(result: Mapping[str, Any], paper: str) -> dict[str, list[Entry]]:
    return {part: [e for e in result.get(part, ()) if e["paper"] == paper] for part in PARTS}


def _summarise(result: Mapping[str, Any]) -> Iterator[Block]:
    """Yield the counts of verdicts, and the main findings of each paper."""
    is_printed = all(e["legibility"] == "printed" and not e["rebuilt"] for e in result["equations"])
    yield Text(READ if "rows" in result else TRANSCRIBED if is_printed else SOURCE)
    papers = result["summary"].items()
    rows = [
        (name, _tally(s["equations"]), s["at_fault"], s["causes"], _tally(s["numbers"]), s["title"])
        for name, s in papers
    ]
    head = ("paper", "equations", "at fault", "causes", "numbers", "title")
    yield Table(head, rows, page_columns=head[-1:])
    for name, summary in papers:
        if findings := list(list_findings(_group_parts(result, name))):
            yield Text(f"{summary['title']}:")
            yield Items(findings)


def list_findings(parts: Mapping[str, Sequence[Entry]]) -> Iterator[str]:
    """Yield the main findings of a paper: broken laws, changed headline numbers, consequences,
    false statements.
    """
    broken = [e for e in parts["laws"] if e["caused_by"]]
    if broken and broken[0].get("owed"):
        yield _describe_cause(broken[0])
    if broken:
        listed = "; ".join(
            f"{e['law']} (by {format_amount(e['violation'], e['unit'])})" for e in broken
        )
        yield f"Of {len(parts['laws'])} laws the chain as a whole breaks {len(broken)}: {listed}."
    compared = [
        e for e in parts["consequences"] if e["printed"] is not None and e["about"] != HEADLINE
    ]
    if compared:
        yield _compare_numbers(compared)
    for entry in parts["consequences"]:
        if entry["statement"]:
            yield entry["statement"]
        elif entry["about"] == HEADLINE:
            yield _describe_headline(entry)
    for entry in parts["claims"]:
        if not entry["holds"]:
            measure = f"{entry['measure']}: {format_amount(entry['value'], entry['unit'])}"
            yield (
                f"Not so: {entry['claim']}. {_capitalise(measure)}, where it must {entry['must']}."
            )


def _describe_cause(law: Entry) -> str:
    return f"{_capitalise(law['law'])}: {law['owed']}"


def _compare_numbers(entries: Sequence[Entry]) -> str:
    """Return a sentence that compares related numbers in the paper, by the print and as derived."""
    parts = (
        f"{e['quantity']} {e['printed']:g}, {clean_zero(e['as_printed']):.3g}, "
        f"{format_amount(e['as_derived'], e['unit'])}"
        for e in entries
    )
    return (
        f"{_capitalise(entries[0]['about'])}, in the paper, by the print and as derived: "
        f"{'; '.join(parts)}."
    )


def _describe_headline(entry: Entry) -> str:
    """Return a sentence on a headline number by the print and as derived."""
    printed, derived = (
        format_amount(entry[key], entry["unit"]) for key in ("as_printed", "as_derived")
    )
    in_paper = "" if entry["printed"] is None else f" (in the paper {entry['printed']:g})"
    return (
        f"{_capitalise(entry['quantity'])}{in_paper}: {printed} by the print, {derived} as derived."
    )


def _list_consequence_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield headline numbers by the equations as printed and as derived, then the consequences."""
    for about in dict.fromkeys(e["about"] for e in entries):
        rows = [
            (
                e["quantity"],
                e["unit"],
                None if e["printed"] is None else float(e["printed"]),
                clean_zero(e["as_printed"]),
                clean_zero(e["as_derived"]),
                ", ".join(e["rests_on"]),
            )
            for e in entries
            if e["about"] == about
        ]
        yield Table((about, "unit", "in the paper", "by the print", "as derived", "rests on"), rows)
    if assumed := max((e["assumed_inputs"] for e in entries), key=len):
        pairs = (text.partition(" = ")[::2] for text in assumed)
        yield Folded("Assumed for this", [Table(("key", "value"), list(pairs))])


def _list_law_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the laws that a printed chain satisfies or breaks, and the share of each equation that
    breaks them.
    """
    for reading in dict.fromkeys(e["reading"] for e in entries):
        if reading:
            yield Text(
                f"Broken by: under the kindest joint reading, {reading}. Read literally: as the "
                f"printed model computes."
            )
    rows = [
        (
            e["law"],
            e["violation"],
            e["violation_literal"],
            e["unit"],
            list_repairs(e),
            e.get("search", ""),
        )
        for e in entries
    ]
    head = (
        "law",
        "broken by",
        "read literally",
        "unit",
        "restored by repairing",
        "search for the smallest set",
    )
    yield Table(head, rows, page_columns=head[-1:])
    for law in entries:
        shares = law.get("shares", ())
        if len(shares) > 1:
            cells = [
                (s["equation"], *(float(s[key]) for key in ("alone", "without", "shapley")))
                for s in shares
            ]
            columns = ("equation", "repaired alone", "left alone", "Shapley value")
            yield Table(columns, cells, f"{law['law']} [{law['unit']}]")
        if law.get("owed"):
            yield Text(_describe_cause(law))


def list_repairs(law: Entry) -> str:
    """Return the smallest sets of equations whose repair restores a law."""
    if law["violation"] is None:
        return UNJUDGED
    sets = [law["caused_by"], *law.get("or_by", ())] if law["caused_by"] else []
    return " or ".join(", ".join(chosen) for chosen in sets) or "kept"


def _list_cause_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the table of errors, each with the equations and the number of printed numbers that it
    affects.
    """
    rows = [
        (e["cause"], ", ".join(n.partition(": ")[2] for n in e["equations"]), len(e["numbers"]))
        for e in entries
    ]
    yield Table(("error", "equations", "numbers that its repair cures"), rows)


def _list_reference_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield sentences on the cross-references that cannot be right."""
    for entry in entries:
        numbers, instead = (
            ", ".join(f"({n})" for n in entry[key]) for key in ("refers_to", "instead")
        )
        yield Text(
            f"{', '.join(entry['quantities'])} cannot come from {numbers}, as the paper says: "
            f"these do not give "
            f"{', '.join(entry['lacking'])}; {instead} do."
        )


def _list_claim_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the table of the text's statements with their measures."""
    rows = [
        (
            e["claim"],
            clean_zero(e["value"]),
            e["unit"],
            e["must"],
            mark_verdict("holds" if e["holds"] else "fails"),
            e["measure"],
            ", ".join(e["assumed_inputs"]),
        )
        for e in entries
    ]
    head = ("statement", "value", "unit", "must", "verdict", "measure", "assumed")
    yield Table(head, rows, page_columns=head[-2:])


def _list_number_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield a table of numbers for each verdict, and the inputs to which letters in them refer."""
    letters: dict[str, str] = {}
    for verdict in NUMBER_VERDICTS:
        rows = []
        for e in entries:
            if e["verdict"] == verdict:
                basis = describe_basis(e)
                letter = letters.setdefault(basis, _letter(len(letters))) if basis else ""
                difference = e["difference"] if verdict == "not reproduced" else ""
                printed = (e["quantity"], e["place"], e["unit"], e["printed_text"])
                rows.append((*printed, e["recomputed"], difference, letter))
        if rows:
            head = ("quantity", "place", "unit", "printed", "computed", "differs by", "note")
            yield _without_empty_columns(head, rows, f"{verdict}: {len(rows)}")
    if letters:
        yield Table(
            ("note", "numbers rest on"), [(letter, basis) for basis, letter in letters.items()]
        )


def _letter(index: int) -> str:
    """Return the letter of a note.

    >>> _letter(0), _letter(26)
    ('a', 'aa')
    """
    first, second = divmod(index, len(ascii_lowercase))
    return (ascii_lowercase[first - 1] if first else "") + ascii_lowercase[second]


def _without_empty_columns(
    head: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str
) -> Table:
    columns = [k for k in range(len(head)) if any(row[k] != "" for row in rows)]
    return Table([head[k] for k in columns], [[row[k] for k in columns] for row in rows], caption)


def describe_basis(number: Entry) -> str:
    """Return the basis of a number beyond the disclosed inputs."""
    assumed = number["assumed_inputs"]
    listed = ", ".join(assumed) if len(assumed) <= 2 else f"{len(assumed)} inputs"
    lacking = f"not disclosed: {', '.join(number['needs'])}" if number["needs"] else ""
    rounding = number["verdict"] == "consistent" and number["interval"]
    ends = "rounded inputs: {:.5g} to {:.5g}".format(*rounding) if rounding else ""
    parts = (listed and f"assumed: {listed}", lacking, ends, number["reading"], number["reason"])
    return "; ".join(part for part in parts if part)


def format_amount(value: float | None, unit: str) -> str:
    """Return a value with its unit, to three digits.

    >>> format_amount(0.00275414, ""), format_amount(31.2514, "deg"), format_amount(None, "N")
    ('0.00275', '31.3 deg', '-')
    """
    return "-" if value is None else f"{clean_zero(value):.3g} {unit}".strip()


def _capitalise(text: str) -> str:
    """Return a sentence with a capital first letter, the others unchanged."""
    return f"{text[:1].upper()}{text[1:]}"


def _tally(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or "none"


PARTS: dict[str, Callable[[Sequence[Entry], Entry], Iterator[Block]]] = {
    "consequences": _list_consequence_blocks,
    "laws": _list_law_blocks,
    "causes": _list_cause_blocks,
    "references": _list_reference_blocks,
    "equations": list_equation_blocks,
    "claims": _list_claim_blocks,
    "numbers": _list_number_blocks,
}
"""Functions that list the blocks of each part of a paper, of its entries and formulas."""
MEANINGS = {
    "confirmed": "the derivation gives the same",
    "confirmed as rebuilt": "the same, where pieces of the machine-read text were completed",
    "untested": "a definition, or a naming, that nothing here can test",
    "misprint": "what differs is removed by one or two edits",
    "incomplete": "the print lacks terms: of the derivation, or one with which it holds",
    "contradicted": "a printed term is neither derived nor explained by an edit",
    "reconstructed": "the print is lost; the derivation stands alone",
    "definition": "names a quantity, and agrees with what else the paper prints of it",
    "not judged": "the equation could not be judged, for the reason that stands with it",
    "hangs on": "a reading that the paper leaves open, a single character that may be misread, pieces completed, the "
    "domain of use: it holds where the machine uses it, and not everywhere",
    "repaired alone, left alone, Shapley": "what an equation's repair takes away, what it leaves when all others are "
    "repaired, and the mean over all orders of repair",
    "reproduced": "equal at the printed precision, from disclosed inputs only",
    "consistent": "equal within the rounding of the printed inputs; or equal by assumed inputs that meet more printed "
    "values than they are many",
    "not reproduced": (
        "differs, from disclosed inputs only: by what was computed less what is printed"
    ),
    "not recomputable": "rests on inputs that the paper does not disclose",
    "by the print": "computed with the equations as printed, misprints included",
    "as derived": "computed with the same inputs from the equations derived here",
    "holds, fails": (
        "the measure is, or is not, what the statement needs; with assumed inputs, for these alone"
    ),
}


def search_front(paper: str | None, progress: Listener | None) -> FrontTable:
    """Return the front of a paper. Raises InputError if the paper has no front."""
    return _find_entry(FRONTS, "--front", paper)(progress)


def compare_hypotheses(
    paper: str | None, machine: str | None, progress: Listener | None
) -> FrontTable:
    """Return the hypotheses on the measurement of a paper, for a machine file if one is given.

    Raises InputError if the paper has none, and for a file that is not one of its kind of machine.
    """
    return _find_entry(EXPERIMENTS, "--experiment", paper)(progress, machine)


def _find_entry(entries: Mapping[str, SomeEntry], option: str, paper: str | None) -> SomeEntry:
    papers = [name for name in numbers.list_papers() if name in entries]
    if paper not in papers:
        raise InputError(f"{option} needs one of the papers {', '.join(papers)}")
    return entries[paper]


def list_experiment_sections(result: FrontTable) -> Iterator[Section]:
    """Yield the section of the hypotheses on a measurement, with their figures."""
    head = (
        "hypothesis",
        "parameters",
        "max / N",
        "min / N",
        "variance / N2",
        "mean / N",
        "miss / %",
        "key",
    )
    rows = [
        (
            row["label"],
            len(row["parameters"]),
            row["max_N"],
            row["min_N"],
            row["variance_N2"],
            row["mean_N"],
            row["largest_miss_percent"],
            row["name"],
        )
        for row in result["hypotheses"]
    ]
    yield Section(
        "Hypotheses on the experiment",
        [Items(result["statements"]), Table(head, rows, page_columns=head[-3:])],
    )


def list_front_sections(front: FrontTable) -> Iterator[Section]:
    """Yield the sections with the statements, and with the points of each front."""
    yield Section("Attainable range and variance", [Items(front["statements"])])
    for curve in front["fronts"]:
        rows = [
            (p["range_N"], p["variance_N2"], p["flank"], p["least_push_N"]) for p in curve["points"]
        ]
        yield Section(f"Attained with {curve['contact']}", [Table(HEAD, rows)])


def build_figure_section(front: FrontTable) -> Section:
    """Return the section with the figure of the fronts."""
    return Section(
        "Figure of the fronts", [FigureSvg(style.render_svg(plot_front(front)), CAPTION)]
    )


LABEL_WIDTH = 34
"""Characters of a line of a label in a figure."""
HEAD = ("range / N", "variance / N2", "flanks", "least push of the cam / N")
CAPTION = (
    "Largest variance of the support force for a range that a search of inputs within the stated "
    "bounds attained in "
    "the exact model, and the figures of the paper. The search is heuristic: values below are "
    "attained, values above "
    "are not excluded."
)


def format_front_files(front: FrontTable) -> dict[str, str | bytes]:
    """Return the contents of front.json, front.csv and the figure by file name."""
    names = ("contact", "range_N", "variance_N2", "least_push_N", "flank")
    lines = [
        ",".join((curve["contact"], *(_format_cell(p[n]) for n in names[1:])))
        for curve in front["fronts"]
        for p in curve["points"]
    ]
    return {
        "front.json": files.summary_text(front),
        "front.csv": "\n".join([",".join(names), *lines]) + "\n",
        **format_figure_files("front", plot_front(front)),
    }


def format_figure_files(name: str, figure: Figure) -> dict[str, str | bytes]:
    """Return the contents of a figure's files by file name."""
    return {f"{name}.{ending}": text for ending, text in style.render_figure(figure).items()}


EXPERIMENT_CAPTION = (
    "Least to largest force that each hypothesis gives, its parameters fitted to the measured "
    "extremes and variance, "
    "and the measured extremes as lines. The share is the largest miss of the three figures."
)


def build_experiment_figure(result: FrontTable) -> Section:
    """Return the section with the figure of the hypotheses on a measurement."""
    figure = FigureSvg(style.render_svg(plot_hypotheses(result)), EXPERIMENT_CAPTION)
    return Section("Figure of the hypotheses", [figure])


@style.with_style
def plot_hypotheses(result: FrontTable) -> Figure:
    """Plot the range of the force of each hypothesis, with its largest miss and the measured
    extremes.
    """
    plot = style.new_figure(4.4)
    axes = plot.subplots()
    rows = result["hypotheses"]
    for key in ("min_N", "max_N"):
        axes.axvline(result["measured"][key], color=style.INK, linewidth=0.8, linestyle=(0, (4, 2)))
    right = max(row["max_N"] for row in [*rows, result["measured"]])
    for place, row in enumerate(rows):
        shade = style.BLUE if row["reached"] else style.SOFT
        axes.barh(place, row["max_N"] - row["min_N"], left=row["min_N"], height=0.5, color=shade)
        verdict = "reached" if row["reached"] else f"off by {row['largest_miss_percent']:.0f} %"
        count = len(row["parameters"])
        axes.text(
            1.04 * right,
            place,
            f"{verdict}, {count} parameter{'' if count == 1 else 's'}",
            va="center",
        )
    axes.set_yticks(range(len(rows)), [textwrap.fill(row["label"], LABEL_WIDTH) for row in rows])
    axes.grid(visible=False, axis="y")
    axes.invert_yaxis()
    axes.set_xlim(0, 1.6 * right)
    axes.set_xlabel("force at the sensor / N")
    return plot


def _format_cell(value: Any) -> str:
    return value if isinstance(value, str) else repr(float(value))


@style.with_style
def plot_front(front: FrontTable) -> Figure:
    """Plot fronts of variance over range from the origin, and the points of the paper."""
    plot = style.new_figure(3.6)
    axes = plot.subplots()
    for index, curve in enumerate(front["fronts"]):
        ends = [*curve["points"], curve["largest_range"]]
        x, y = ([0.0, *(p[key] for p in ends)] for key in ("range_N", "variance_N2"))
        shade = style.PALETTE[index]
        axes.plot(
            x,
            y,
            color=shade,
            marker="o",
            markersize=3,
            linewidth=1.3 - 0.4 * index,
            label=curve["contact"],
            linestyle="-" if index == 0 else (0, (4, 2)),
        )
        if index == 0:
            axes.fill_between(x, y, color=shade, alpha=0.12, linewidth=0)
    for mark in front["table"]:
        axes.plot(mark["range_N"], mark["variance_N2"], "X", color=style.INK, markersize=7)
        axes.annotate(
            f"Table 1, {mark['name']}",
            (mark["range_N"], mark["variance_N2"]),
            (7, 3),
            textcoords="offset points",
        )
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0, top=1.1 * max(mark["variance_N2"] for mark in front["table"]))
    axes.set_xlabel("range of the support force / N")
    axes.set_ylabel("variance / N²")
    axes.legend(frameon=False, loc="upper right", title="exact model, any inputs within the bounds")
    return plot
