"""Meanings for the terminal, at most 80 columns wide."""

from __future__ import annotations

import textwrap

from planter.explain.results import DrawnSymbol, Explained, ExplainedMachine, ExplainedMechanism, KnownNames, Meaning
from planter.files import units

WIDTH = 80


def show_meanings(explanation: Explained) -> None:
    """Print every meaning."""
    for meaning in explanation.meanings:
        print("\n".join(format_meaning(meaning)) + "\n")


def format_meaning(meaning: Meaning) -> list[str]:
    """Return a meaning as lines."""
    unit = f" [{meaning.unit}]" if meaning.unit and meaning.unit != "1" else ""
    lines = [f"{meaning.name}{unit}, {meaning.kind}, {meaning.machine}"]
    facts = [meaning.meaning, f"source: {meaning.source}"]
    if meaning.key and meaning.key != meaning.name:
        facts.append(f"shown as {meaning.key}")
    if meaning.value is not None:
        facts.append(f"value: {format_value(meaning)}")
    if meaning.allowed:
        facts.append(f"allowed: {meaning.allowed}")
    facts += [f"defined by {e.paper} ({e.equation}): {e.verdict}" for e in meaning.equations or ()]
    if meaning.figures:
        facts.append(f"drawn in {', '.join(meaning.figures)}")
    return [*lines, *(line for fact in facts for line in textwrap.wrap(
        fact, WIDTH, initial_indent="  ", subsequent_indent="    "))]  # fmt: skip


def format_value(meaning: Meaning) -> str:
    """Return a value with its unit in the file, and its origin."""
    number = f"{meaning.value:g} {units.unit(meaning.key or '')}".rstrip()
    return f"{number} ({meaning.origin})" if meaning.origin else number


def show_mechanism(mechanism: ExplainedMechanism) -> None:
    """Print values, quantities and functions of a mechanism."""
    print(textwrap.fill(f"{mechanism.machine}: {mechanism.title}, from {mechanism.source}", WIDTH))
    for assumption in mechanism.assumptions:
        print(textwrap.fill(f"assumes {assumption}", WIDTH, initial_indent="  ", subsequent_indent="    "))
    for title, meanings in (("Values", mechanism.values), ("Quantities", mechanism.quantities)):
        print(f"\n{title}")
        for meaning in meanings:
            unit = f" [{meaning.unit}]" if meaning.unit != "1" else ""
            facts = [f"{meaning.name}{unit}: {meaning.meaning}"]
            if meaning.value is not None:
                facts.append(
                    f"{meaning.key} = {format_value(meaning)}" + (f", {meaning.allowed}" if meaning.allowed else "")
                )
            for number, fact in enumerate(facts):
                indent = "  " if number == 0 else "    "
                print(textwrap.fill(fact, WIDTH, initial_indent=indent, subsequent_indent=f"{indent}  "))
    print("\nFunctions")
    for function in mechanism.functions:
        count = "" if function.operations is None else f", {function.operations} operations"
        print(f"  {function.name}({', '.join(function.inputs)}): {function.outputs} results{count}")


def show_machine(machine: ExplainedMachine) -> None:
    """Print symbols sheet by sheet, then those without a drawing."""
    by_name = {symbol.name: symbol for symbol in machine.symbols}
    for sheet in machine.sheets:
        print(f"{sheet.name}: {sheet.title}")
        _show_symbols([by_name[name] for name in sheet.symbols])
    print("on no drawing")
    _show_symbols([symbol for symbol in machine.symbols if symbol.sheet is None])


def _show_symbols(symbols: list[DrawnSymbol]) -> None:
    for symbol in symbols:
        places = ", ".join(place for place in (symbol.key, symbol.column) if place)
        facts = [symbol.meaning, f"shown as {places}" if places else "", symbol.left_out or ""]
        print(f"  {symbol.name} [{symbol.unit}]")
        for fact in filter(None, facts):
            print(textwrap.fill(fact, WIDTH, initial_indent="    ", subsequent_indent="      "))
    print()


def show_names(known_names: KnownNames) -> None:
    """Print all names by machine."""
    for show_machine, machine_names in known_names.names.items():
        print(f"{show_machine}:")
        print(textwrap.fill(", ".join(machine_names), WIDTH, initial_indent="  ", subsequent_indent="  ",
                            break_long_words=False, break_on_hyphens=False))  # fmt: skip
