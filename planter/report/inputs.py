"""Sections of a page on the inputs of a result: every number of its file, and its provenance."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from planter.files import units
from planter.report.html import Block, Cell, Folded, Keys, Section, Table, Text
from planter.report.labels import format_cell, separate_words

if TYPE_CHECKING:
    from planter.files.document import Document


def tabulate_inputs(machine: Document, meanings: Mapping[str, str], besides: Collection[str] = ()) -> Iterator[Block]:
    """Yield tables of every number of a file with its unit, meaning and origin, without the sections `besides`."""
    by_section: dict[str, list[tuple[Cell, ...]]] = {}
    origins = machine.number_origins()
    for path, value in machine.numbers().items():
        section, _, key = path.partition(".")
        if section not in besides:
            row = (key, value, units.display_unit(path), meanings.get(path, ""), origins[path])
            by_section.setdefault(section, []).append(row)
    yield Text("What is not marked as the paper's was chosen by whoever wrote the machine file.", "note")
    for section, rows in by_section.items():
        yield Folded(separate_words(section), [Table(("key", "value", "unit", "meaning", "origin"), rows)])


def provenance_section(provenance: Mapping[str, Any]) -> Section:
    """Return versions, hash and seed, as `planter.report.files.list_provenance` returns them, as a section."""
    return Section("Provenance", [Keys({name: format_cell(value) for name, value in provenance.items()})])
