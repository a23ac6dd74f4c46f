"""The comparison as tables that a person likes to read, no wider than 80 columns."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from planter.planting.designer.shown import COMPARED, peaks
from planter.planting.results import ComparedPair, ComparisonFound, NarrowBox
from planter.terminal.console import Console

WIDTH = 80
HEADER = ("", "sun, gear 6", "objective", "range / N", "var. / N2", "KKT")


def comparison(console: Console, result: ComparisonFound) -> None:
    """Devices by rank, those that are not settled apart, the narrow box, and what conflicts."""
    devices = result.devices
    settled, others = ([one for one in devices if one.settled is is_settled] for is_settled in (True, False))
    _say(statement(result))
    narrow = result.narrow
    own = ("-", "the paper's narrow box", *_numbers(narrow))
    rows = [(str(one.rank), name(one), *_numbers(one)) for one in settled]
    console.table(f"{result.machine}: settled pairs, true extremes and integrals", HEADER, [*rows, own])
    if others:
        console.table("Not settled, the best points that were reached", HEADER,
                      [("?", name(one), *_numbers(one)) for one in others])  # fmt: skip
    borne = [(str(one.rank or "?"), name(one), *peaks(one.designer)) for one in devices]
    console.table("What each has to bear, largest over a turn", ("", "sun, gear 6", *COMPARED), borne)
    for one in devices:
        _say(f"{name(one)}: {'; '.join(told(one))}")
    _say("")
    found = result.proposal
    if found is not None:
        told_of = ", ".join(found.conflicting) or "no single one"
        limits = ", ".join(f"{key} = {value:.6g}" for key, value in found.limits.items())
        _say(f"No pair keeps all requirements; every pair breaks: {told_of}.")
        _say(f"{found.stage1} with {found.stage2} keeps them with {limits}.")
    _say(f"{result.seconds:.3g} s")


def statement(result: ComparisonFound) -> str:
    """How many pairs are settled, and what that means."""
    return (
        f"{result.settled} of {len(result.devices)} pairs are settled: a KKT residual below 1e-6 and a second "
        "start that agrees, or a violation that is least to first order. The others are only the best points reached."
    )


def name(entry: ComparedPair) -> str:
    return f"{entry.stage1}, {entry.stage2}".replace("_", " ")


def told(entry: ComparedPair) -> Iterator[str]:
    """What holds an entry or is broken by it, and what it lacks to be settled."""
    amounts = [f"{one.name} by {one.amount:.3g} {one.unit}" for one in entry.violations]
    names = ", ".join(amounts or entry.binding)
    yield f"{'held by' if entry.feasible else 'breaks'} {names}" if names else "all kept"
    if entry.lacks:
        yield f"lacks {' and '.join(entry.lacks)}"


def _numbers(entry: ComparedPair | NarrowBox) -> tuple[str, str, str, str]:
    residual = getattr(entry, "kkt_residual", None)
    numbers = (f"{value:.5g}" for value in (entry.objective, entry.range_N, entry.variance_N2))
    objective, span, variance = numbers
    return objective, span, variance, "-" if residual is None else f"{residual:.0e}"


def _say(text: str) -> None:
    print(textwrap.fill(text, WIDTH, subsequent_indent="    "))
