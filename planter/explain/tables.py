"""Meanings as a person reads them, no wider than 80 columns."""

from __future__ import annotations

import textwrap

from planter.explain.results import DrawnSymbol, Explained, ExplainedMachine, ExplainedMechanism, KnownNames, Meaning
from planter.files import units

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
    if one.value is not None:
        facts.append(f"value: {shown_value(one)}")
    if one.allowed:
        facts.append(f"allowed: {one.allowed}")
    facts += [f"defined by {e.paper} ({e.equation}): {e.verdict}" for e in one.equations or ()]
    if one.figures:
        facts.append(f"drawn in {', '.join(one.figures)}")
    return [*lines, *(line for fact in facts for line in textwrap.wrap(
        fact, WIDTH, initial_indent="  ", subsequent_indent="    "))]  # fmt: skip


def shown_value(one: Meaning) -> str:
    """Return a value with its unit in the file, and where it is from."""
    number = f"{one.value:g} {units.unit(one.key or '')}".rstrip()
    return f"{number} ({one.origin})" if one.origin else number


def mechanism(found: ExplainedMechanism) -> None:
    """Print values, quantities and functions of a mechanism."""
    print(textwrap.fill(f"{found.machine}: {found.title}, from {found.source}", WIDTH))
    for assumption in found.assumptions:
        print(textwrap.fill(f"assumes {assumption}", WIDTH, initial_indent="  ", subsequent_indent="    "))
    for title, meanings in (("Values", found.values), ("Quantities", found.quantities)):
        print(f"\n{title}")
        for one in meanings:
            unit = f" [{one.unit}]" if one.unit != "1" else ""
            facts = [f"{one.name}{unit}: {one.meaning}"]
            if one.value is not None:
                facts.append(f"{one.key} = {shown_value(one)}" + (f", {one.allowed}" if one.allowed else ""))
            for number, fact in enumerate(facts):
                indent = "  " if number == 0 else "    "
                print(textwrap.fill(fact, WIDTH, initial_indent=indent, subsequent_indent=f"{indent}  "))
    print("\nFunctions")
    for function in found.functions:
        count = "" if function.operations is None else f", {function.operations} operations"
        print(f"  {function.name}({', '.join(function.inputs)}): {function.outputs} results{count}")


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
