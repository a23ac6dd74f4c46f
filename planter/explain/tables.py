"""Meanings as a person reads them, no wider than 80 columns."""

from __future__ import annotations

import textwrap

from planter.explain.results import DrawnSymbol, Explained, ExplainedMachine, KnownNames, Meaning

WIDTH = 80


def explained(found: Explained) -> None:
    """Every meaning, one below the other."""
    for one in found.meanings:
        print("\n".join(told(one)) + "\n")


def told(one: Meaning) -> list[str]:
    """A meaning as lines."""
    unit = f" [{one.unit}]" if one.unit and one.unit != "1" else ""
    lines = [f"{one.name}{unit}, {one.kind}, {one.machine}"]
    facts = [one.meaning, f"source: {one.source}"]
    if one.key and one.key != one.name:
        facts.append(f"shown as {one.key}")
    if one.allowed:
        facts.append(f"allowed: {one.allowed}")
    facts += [f"defined by {e.paper} ({e.equation}): {e.verdict}" for e in one.equations or ()]
    if one.figures:
        facts.append(f"drawn in {', '.join(one.figures)}")
    return [*lines, *(line for fact in facts for line in textwrap.wrap(
        fact, WIDTH, initial_indent="  ", subsequent_indent="    "))]  # fmt: skip


def machine(found: ExplainedMachine) -> None:
    """Symbols sheet by sheet, then those that are on none."""
    by_name = {one.name: one for one in found.symbols}
    for sheet in found.sheets:
        print(f"{sheet.name}: {sheet.title}")
        _rows([by_name[name] for name in sheet.symbols])
    print("on no drawing")
    _rows([one for one in found.symbols if one.sheet is None])


def _rows(symbols: list[DrawnSymbol]) -> None:
    for one in symbols:
        places = ", ".join(place for place in (one.key, one.column) if place)
        facts = [one.meaning, f"shown as {places}" if places else "", one.left_out or ""]
        print(f"  {one.name} [{one.unit}]")
        for fact in filter(None, facts):
            print(textwrap.fill(fact, WIDTH, initial_indent="    ", subsequent_indent="      "))
    print()


def names(found: KnownNames) -> None:
    """All names by machine."""
    for machine, own in found.names.items():
        print(f"{machine}:")
        print(textwrap.fill(", ".join(own), WIDTH, initial_indent="  ", subsequent_indent="  ",
                            break_long_words=False, break_on_hyphens=False))  # fmt: skip
