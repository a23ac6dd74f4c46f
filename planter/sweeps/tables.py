"""Results of sweeps as tables of at most 80 columns."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping

from planter.sweeps.results import SweepFound, Varied
from planter.terminal.console import Console

WIDTH = 80


def print_sweep(console: Console, result: SweepFound) -> None:
    """Print rows and hash, then the range of each output."""
    how = f"{result.workers} workers" if result.workers else "no workers"
    again = f", {result.resumed} chunks reused" if result.resumed else ""
    print(f"{result.name}: {result.rows} rows in {result.seconds:.3g} s, {how}{again}")
    print(f"hash {result.hash}\n")
    rows = [(name, extent.min, extent.mean, extent.max, extent.missing) for name, extent in result.envelope.items()]
    console.table("Envelope", ("output", "min", "mean", "max", "missing"), rows)


def print_inputs(result: Varied) -> None:
    """Print the inputs, then the outputs."""
    print(f"{result.machine} can be swept over these inputs:\n")
    _list({name: f"one of {', '.join(texts)}" for name, texts in result.choices.items()} | result.inputs)
    print("\nfor these outputs:\n")
    _list(result.outputs)


def _list(meanings: Mapping[str, str]) -> None:
    for name, meaning in meanings.items():
        print(textwrap.fill(f"{name}: {meaning}", WIDTH, initial_indent="  ", subsequent_indent="      "))
