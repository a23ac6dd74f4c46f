"""How a result is presented: declared once, from which the terminal, the page and the folder of a
command follow.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from itertools import islice, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter import safe_text
from planter.files import units
from planter.files.document import Document
from planter.files.record import Record, WarningRecord
from planter.kernels import Array
from planter.progress import Listener
from planter.report import files, labels, process
from planter.report.console import Console
from planter.report.html import (
    PAGE_LINES,
    Block,
    Cell,
    Command,
    Conclusion,
    FigureSvg,
    Folded,
    Items,
    KeyFigure,
    KeyFigures,
    Keys,
    Section,
    Table,
    Text,
    is_number,
    render_page,
)
from planter.report.labels import (
    clean_zero,
    format_cell,
    format_label,
    format_name,
    separate_words,
    tabulate_named,
)
from planter.report.options import PROOF

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.document import Document


def list_proof_files(certificate: str | None) -> dict[str, str]:
    """Return the files of a proof: its certificate, if there is one, and the program that checks
    it.
    """
    if certificate is None:
        return {}
    checker = "check_proof.py"
    program = resources.files("planter.engine.proof").joinpath(checker).read_text(encoding="utf-8")
    return {PROOF: certificate, checker: program}


def describe_proof(proof: Mapping[str, Any]) -> Iterator[Block]:
    """Yield the bound on the objective of any design within the bounds, its gap to the optimum, and
    the method.

    Bound and gap are dashes if the objective is not bounded.
    """
    yield Text(
        f"{proof['statement'][0].upper()}{proof['statement'][1:]}.",
        "" if proof["proved"] else "warning",
    )
    yield Keys(
        {
            labels.format_label(key): value
            for key, value in proof.items()
            if key not in ("statement", "design")
        }
    )
    rows = [(labels.format_label(key), value) for key, value in proof["design"].items()]
    yield Table(("quantity", "best design that is known"), rows)
    yield Text(
        "By branch and bound on enclosures of the objective and its derivatives over boxes, in "
        "doubles whose rounding "
        "is added to each: it rests on the arithmetic of IEEE 754, and on sines, cosines, arc "
        "tangents within 2^-49.",
        "note",
    )


def tabulate_inputs(
    machine: Document, meanings: Mapping[str, str], besides: Collection[str] = ()
) -> Iterator[Block]:
    """Yield tables of every number of a file by its meaning, with unit, origin and key, without the
    sections `besides`.

    A number without a meaning has the words of its key.
    """
    by_section: dict[str, list[tuple[Cell, ...]]] = {}
    origins = machine.number_origins()
    for path, value in machine.numbers().items():
        section, _, key = path.partition(".")
        if section not in besides:
            meaning = meanings.get(path) or labels.format_name(key)
            row = (meaning, value, units.display_unit(path), origins[path], key)
            by_section.setdefault(section, []).append(row)
    yield Text(
        "What is not marked as the paper's was chosen by whoever wrote the machine file.", "note"
    )
    for section, rows in by_section.items():
        yield Folded(
            separate_words(section), [Table(("quantity", "value", "unit", "origin", "key"), rows)]
        )


def provenance_section(provenance: Mapping[str, Any]) -> Section:
    """Return versions, hash and seed, as `planter.report.files.list_provenance` returns them, as a
    section.
    """
    return Section(
        "Provenance",
        [Keys({separate_words(name): format_cell(value) for name, value in provenance.items()})],
    )


WIDTH = 80
"""Columns of a terminal that sentences are filled to."""


@dataclass(frozen=True)
class ModelAssumptions:
    """The title of a model, its assumptions, and the meanings of the file's numbers by their paths.

    `in_summary` adds the assumptions to summary.json.
    """

    title: str
    assumptions: Sequence[str]
    meanings: Mapping[str, str]
    in_summary: bool = True

    @classmethod
    def from_sidecar(cls, sidecar: Mapping[str, Any], in_summary: bool = True) -> ModelAssumptions:
        """Return the description of a generated model from its sidecar."""
        entries = (
            entry for vector in sidecar["vectors"].values() for entry in vector if "shown" in entry
        )
        meanings = {entry["shown"]: entry["meaning"] for entry in entries}
        return cls(
            f"{sidecar['title']} ({sidecar['source']})",
            sidecar["assumptions"],
            meanings,
            in_summary,
        )


@dataclass(frozen=True)
class PlacedFigure:
    """The place, within a section of the page, of a figure by its name; other figures follow the
    sections.
    """

    figure: str

    def html(self, name: str) -> str:
        """Return nothing: the page places the figure itself."""
        return ""


@dataclass(frozen=True)
class ResultPresentation:
    """The presentation of one result; `record` is the result as JSON.

    The terminal prints title, `conclusion` (one sentence) and `sections`; the page has all parts.
    The functions are called only if a folder is written: moving drawings, `figures` by name with
    their `captions`, sections behind the figures (`details`), `tables` of columns (n,) by CSV file
    name under the header lines `comments`, and other `texts` by file name.
    """

    title: str
    record: Record
    sections: Sequence[Section]
    conclusion: str = ""
    failures: Sequence[str] = ()
    """Sentences on what does not satisfy its limit, with its value; the page opens with them."""
    key_figures: Sequence[KeyFigure] = ()
    """Numbers that the page opens with; by default the first ones of `sections`."""
    document: Document | None = None
    model: ModelAssumptions | None = None
    meanings: Mapping[str, str] = field(default_factory=dict)
    """Meanings of the numbers of `document` by their paths; by default those of `model`."""
    displayed_inputs: Collection[str] = ()
    """Sections of `document` that `sections` display, so that the page's inputs leave them out."""
    motions: Callable[[], Iterable[Block]] = tuple
    figures: Callable[[], Mapping[str, Figure]] = dict
    captions: Mapping[str, str] = field(default_factory=dict)
    details: Callable[[], Iterable[Section]] = tuple
    tables: Callable[[], Mapping[str, Mapping[str, Array]]] = dict
    comments: Iterable[str] = ()
    texts: Callable[[], Mapping[str, str | bytes]] = dict
    summary_parts: Mapping[str, Any] = field(default_factory=dict)
    """Further keys of summary.json."""
    provenance: Mapping[str, Any] | None = None
    """What the result can be repeated from; by default versions, machine and hash of `document`."""

    @cached_property
    def _provenance(self) -> Mapping[str, Any]:
        if self.provenance is not None or self.document is None:
            return self.provenance or {}
        return files.list_provenance(self.document)

    def summary(self) -> dict[str, Any]:
        """Return the content of summary.json: the record, what the model assumes, the input and the
        provenance.
        """
        basis = describe_basis(self.model, self.document, self._provenance)
        return {**self.record.table(), **self.summary_parts, **basis}

    def page(self, svgs: Mapping[str, str]) -> str:
        """Return the page as HTML text, with figures as SVG texts by name."""
        sections: list[Section] = []
        figures = {
            name: FigureSvg(svg, self.captions.get(name, ""), separate_words(name))
            for name, svg in svgs.items()
        }
        for section in self.sections:
            blocks = [
                figures.pop(b.figure) if isinstance(b, PlacedFigure) else b for b in section.blocks
            ]
            sections.append(replace(section, blocks=blocks))
        lead: list[Block] = []
        if self.conclusion or self.failures:
            lead.append(Conclusion(self.conclusion, self.failures))
        if chosen := self.key_figures or find_key_figures(self.sections):
            lead.append(KeyFigures(chosen))
        motions = list(self.motions())
        if motions:
            lead.append(motions.pop(0))
        elif figures:
            lead.append(figures.pop(next(iter(figures))))
        main, details = split_sections(sections)
        if motions:
            details.append(Section("Motion", motions))
        if figures:
            details.append(Section("Figures", list(figures.values())))
        details += self.details()
        if self.model is not None:
            blocks = [Text(f"{self.model.title}. It assumes:"), Items(self.model.assumptions)]
            details.append(Section("Model", blocks))
        if self.document is not None:
            meanings = self.meanings if self.model is None else self.model.meanings
            inputs = tabulate_inputs(self.document, meanings, self.displayed_inputs)
            details.append(Section("Inputs", list(inputs)))
        if provenance := self._provenance:
            details.append(provenance_section(provenance))
        if command := process.format_command():
            details.append(Section("Reproduce", [Command(command)]))
        subtitle = "" if self.document is None else self.document.description
        return render_page(self.title, main, subtitle, lead=lead, details=details)

    def write(self, out: Path, progress: Listener | None = None) -> None:
        """Write summary.json, tables, figures, texts and report.html, all or none.

        Raises InputError if the folder cannot be written.
        """
        files.output_folder(out)
        images = files.render_figures(self.figures(), progress)
        page = self.page({name: str(image["svg"]) for name, image in images.items()})
        files.write_bundle(out, {**self._data(), "report.html": page}, images)

    def write_data(self, out: Path) -> None:
        """Write summary.json, tables and texts, but neither figures nor the page, which take
        longer.

        Raises InputError if the folder cannot be written.
        """
        files.write_bundle(out, self._data(), {})

    def _data(self) -> dict[str, str | bytes]:
        comments = list(self.comments)
        return {
            "summary.json": files.summary_text(self.summary()),
            **{
                name: files.cycle_csv(name, comments, columns)
                for name, columns in self.tables().items()
            },
            **self.texts(),
        }

    def show(self, console: Console, out: Path | None = None) -> None:
        """Write the folder if there is one, and print the result as JSON, or title, conclusion and
        sections.
        """
        if out is not None:
            self.write(out, console.progress)
        console.result(self.record, lambda: self._print(console))

    def _print(self, console: Console) -> None:
        for sentence in filter(None, (self.title, *self.failures, self.conclusion)):
            print_sentence(sentence)
        print()
        for section in self.sections:
            print_section(console, section)


MAIN_LINES = 2 * PAGE_LINES
"""Height of the sections in the main part of a page, in rows of a table: three printed sheets, of
which conclusion, key figures and picture fill the first.
"""


def split_sections(sections: Sequence[Section]) -> tuple[list[Section], list[Section]]:
    """Return the sections of the main part, which three printed sheets have room for, and the
    others.
    """
    main: list[Section] = []
    details: list[Section] = []
    room = MAIN_LINES
    for section in sections:
        fits = not section.detail and section.lines <= room
        (main if fits else details).append(section)
        room -= section.lines if fits else 0
    return main, details


MOST_KEY_FIGURES = 3
"""Numbers that a page opens with."""


def find_key_figures(sections: Sequence[Section]) -> list[KeyFigure]:
    """Return the first numbers of the lists and tables of sections: of a table, the first number of
    each row.

    A unit in a row is that of its numbers that are no counts, so that an integer among them is
    passed over. Rows of named values, with their keys, are named without the section.
    """
    return list(
        islice(
            (figure for section in sections for figure in _list_key_figures(section)),
            MOST_KEY_FIGURES,
        )
    )


def _list_key_figures(section: Section) -> Iterator[KeyFigure]:
    for block in section.blocks:
        if isinstance(block, Keys):
            for label, value in block.pairs.items():
                if is_number(value) and label != "seed":
                    yield _build_key_figure(value, label)
        elif isinstance(block, Table):
            for row in block.rows:
                numbers = [k for k, value in enumerate(row) if is_number(value)]
                unit = next(
                    (
                        str(row[k] or "")
                        for k, head in enumerate(block.head)
                        if head.endswith("unit")
                    ),
                    None,
                )
                sizes = (
                    [k for k in numbers if isinstance(row[k], float)]
                    if unit and 0 not in numbers
                    else []
                )
                index = next(iter(sizes or numbers), None)
                if (
                    index and row[0] is not None
                ):  # rows whose first cell is a number are only counted by it
                    name, stroke, behind = str(row[0]).rpartition(" / ")
                    head = "" if block.head[index] == "value" else block.head[index]
                    title = "" if "key" in block.head else section.title
                    words = ", ".join(filter(None, (title, name or behind, head)))
                    yield _build_key_figure(
                        row[index], words, behind if stroke and unit is None else unit
                    )


def _build_key_figure(value: Cell, label: str, unit: str | None = None) -> KeyFigure:
    """Return a number to four digits; without a `unit`, that behind the stroke of its label."""
    words, _, behind = label.rpartition(" / ")
    number = f"{value:.4g}".replace("-", "\N{MINUS SIGN}")
    if unit is not None or not words:
        return KeyFigure(number, unit or "", label)
    return KeyFigure(number, behind, words)


def describe_basis(
    model: ModelAssumptions | None, document: Document | None, provenance: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the keys of summary.json that say what a result is based on: assumptions, input,
    provenance.
    """
    basis: dict[str, Any] = {}
    if model is not None and model.in_summary:
        basis["assumptions"] = model.assumptions
    if document is not None:
        basis["input"] = document.table()
    if provenance:
        basis["provenance"] = provenance
    return basis


def list_warning_sections(warnings: Sequence[str | WarningRecord]) -> list[Section]:
    """Return a section of warnings, or an empty list."""
    return (
        [Section("Warnings", [Items([str(warning) for warning in warnings], "warning")])]
        if warnings
        else []
    )


def describe_failure(
    name: str,
    value: float | None,
    limit: tuple[float | None, float | None],
    unit: str,
    place: str = "",
) -> str:
    """Return the sentence on a requirement that its value fails, whose `limit` is at least and at
    most; `place` is the angle.

    >>> describe_failure("depth", 28.53, (50.0, None), "mm", "152.8 deg")
    'Fails: depth is 28.53 mm at 152.8 deg, and must be at least 50 mm (21.47 mm short).'
    >>> describe_failure("tilt", 12.0, (None, 10.0), "deg")
    'Fails: tilt is 12 deg, and must be at most 10 deg (2 deg over).'
    """
    lower, upper = limit
    unit = f" {unit}" if unit not in ("", "1") else ""
    where = f" at {place}" if place else ""
    if value is None:
        return f"Fails: {name} has no value{where}."
    is_over = upper is not None and value > upper
    bound, words, excess = (upper, "most", "over") if is_over else (lower, "least", "short")
    stated = f"Fails: {name} is {value:.4g}{unit}{where}"
    if bound is None:
        return f"{stated}."
    amount = f"{abs(value - bound):.4g}{unit} {excess}"
    return f"{stated}, and must be at {words} {bound:.6g}{unit} ({amount})."


MOST_FAILURES = 4
"""Requirements that fail, each with a sentence of its own; more are counted."""


def shorten_failures(sentences: Sequence[str]) -> list[str]:
    """Return the first failures, and how many others there are."""
    rest = len(sentences) - MOST_FAILURES
    more = [f"{rest} more fail, as the table shows."] if rest > 0 else []
    return [*sentences[:MOST_FAILURES], *more]


def describe_violations(
    violated: Sequence[str], count: int, kind: str, separator: str = ", "
) -> str:
    """Return the sentence on how many of `count` requirements, or whatever their `kind`, are
    violated, and which.

    >>> describe_violations([], 1, "limit"), describe_violations(["F <= 3"], 2, "limit")
    ('The limit is satisfied.', '1 of 2 limits is violated: F <= 3.')
    """
    names = separator.join(violated)
    if count == 1:
        return f"The {kind} is violated: {names}." if violated else f"The {kind} is satisfied."
    plural = f"{kind[:-1]}ies" if kind.endswith("y") else f"{kind}s"
    if violated:
        return (
            f"{len(violated)} of {count} {plural} {'is' if len(violated) == 1 else 'are'} "
            f"violated: {names}."
        )
    return f"All {count} {plural} are satisfied."


def print_section(console: Console, section: Section) -> None:
    """Print the sentences, keys and tables of a section; drawings and folded parts are left to the
    page.
    """
    title = section.title
    for block, following in zip_longest(section.blocks, section.blocks[1:]):
        match block:
            case Text() | Items():
                if title:
                    print_sentence(f"{title}:")
                    title = ""
                items, mark = ([block.text], "") if isinstance(block, Text) else (block.items, "- ")
                for item in items:
                    print_sentence(item, mark)
                if not isinstance(following, Text | Items):
                    print()
            case Keys():
                console.table(title, ("", "value"), list(block.pairs.items()))
                title = ""
            case Table():
                columns = [
                    index for index, head in enumerate(block.head) if head not in block.page_columns
                ]
                rows = [[row[index] for index in columns] for row in block.rows]
                console.table(
                    block.caption or title, [block.head[index] for index in columns], rows
                )
                title = ""


def print_sentence(text: str, mark: str = "") -> None:
    """Print a text, filled to the width of a terminal."""
    print(
        textwrap.fill(
            units.typeset_degrees(safe_text.sanitise_line(text)),
            WIDTH,
            initial_indent=mark,
            subsequent_indent=" " * len(mark),
        )
    )


PAGE_COLUMNS = (
    "source",
    "share",
    "hinges_mm",
    "angle_error_deg",
    "multiplicity",
    "outside",
    "lower",
    "upper",
)
"""Columns of rows that only pages have."""


def list_record_sections(
    record: Record, names: Mapping[str, str], omit: Collection[str] = ()
) -> Iterator[Section]:
    """Yield the sections of a result: warnings, single values and groups, then each list of rows.

    `names` has the names of keys, and those of groups and lists under `group.KEY`; keys without a
    name have their words. Rows that hold rows themselves have a section each.
    """
    yield from list_warning_sections(getattr(record, "warnings", None) or [])
    table = record.table()
    entries = {key: value for key, value in table.items() if key not in (*omit, "warnings")}
    yield Section("Results", list(_list_blocks(entries, names)))
    for key, rows in entries.items():
        if not is_table(rows):
            continue
        title = name_group(key, names)
        if any(is_nested(value) for value in rows[0].values()):
            for number, row in enumerate(rows, 1):
                blocks = [*_list_blocks(row, names), *_list_tables(row, names)]
                yield Section(f"{title} {number}", blocks)
        else:
            yield Section(title, [tabulate_record_rows(rows, names)])


def _list_blocks(table: Mapping[str, Any], names: Mapping[str, str]) -> Iterator[Block]:
    """Yield the single values of a record, then each group with its tables."""
    single = {key: value for key, value in table.items() if not is_nested(value) and value != []}
    if single:
        yield _tabulate_values(single, names)
    for key, group in table.items():
        if isinstance(group, Mapping):
            inner = {name: value for name, value in group.items() if not is_nested(value)}
            yield _tabulate_values(inner, names, name_group(key, names))
            yield from _list_tables(group, names)


def _list_tables(table: Mapping[str, Any], names: Mapping[str, str]) -> Iterator[Block]:
    for key, rows in table.items():
        if is_table(rows):
            yield tabulate_record_rows(rows, names, name_group(key, names))


def _tabulate_values(
    values: Mapping[str, Any], names: Mapping[str, str], caption: str = ""
) -> Table:
    return tabulate_named({key: _clean(v) for key, v in values.items()}, names, caption)


def tabulate_record_rows(
    rows: Sequence[Mapping[str, Any]], names: Mapping[str, str], caption: str = ""
) -> Table:
    """Return a table of rows with a column for each key."""
    heads = [_name_column(key, names) for key in rows[0]]
    cells = [[format_cell(_clean(row.get(key))) for key in rows[0]] for row in rows]
    if "name" in rows[0]:  # a design value is named as on the page
        column = list(rows[0]).index("name")
        for row in cells:
            row[column] = names.get(str(row[column]), row[column])
    page_columns = [_name_column(key, names) for key in PAGE_COLUMNS]
    return Table(heads, cells, caption, page_columns)


def _name_column(key: str, names: Mapping[str, str]) -> str:
    return format_label(key, names[key]) if key in names else _capitalise(format_label(key))


def name_group(key: str, names: Mapping[str, str]) -> str:
    """Return the title of a group or list."""
    return names.get(f"group.{key}", _capitalise(format_name(key)))


def is_table(value: object) -> bool:
    """Return whether a value is a list of rows."""
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def is_nested(value: object) -> bool:
    """Return whether a value is a group or a list of rows."""
    return isinstance(value, Mapping) or is_table(value)


def _capitalise(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"


def _clean(value: Any) -> Any:
    return clean_zero(value) if isinstance(value, float) else value
