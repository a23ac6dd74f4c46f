"""Tolerances as tables that a person likes to read, no wider than 80 columns."""

from __future__ import annotations

from planter.files.paths import last_part
from planter.terminal.console import Console
from planter.tolerance.results import RobustFound, ToleranceFound
from planter.tolerance.statistics import ranked

LARGEST = 3
"""Inputs that are told for each output."""


def tolerance(console: Console, result: ToleranceFound) -> None:
    """Bands, the inputs that matter most, the robust design beside the others."""
    chosen = "".join(f", {text} {name}" for name, text in result.choices.items())
    print(f"{result.machine}{chosen}: {len(result.inputs)} inputs vary, {result.rows} turns\n")
    rows = [
        (name, band.nominal, band.mean, band.std, band.first_order_std, band.p5, band.p95)
        for name, band in result.outputs.items()
    ]
    console.table("Bands", ("output", "nominal", "mean", "std", "first order", "p5", "p95"), rows)
    shares = [
        (name if first else "", last_part(one), *(f"{x:.3f}" for x in (share.first, share.total, share.total_error)))
        for name, found in result.sobol.items()
        for first, (one, share) in zip((True, *[False] * LARGEST), ranked(found)[:LARGEST], strict=False)
        if share.total > 0
    ]
    if shares:
        console.table("Sobol' indices, largest first", ("output", "input", "first", "total", "+-"), shares)
    if result.robust is not None:
        _robust(console, result.robust)
    print(f"{result.seconds:.3g} s")


def _robust(console: Console, found: RobustFound) -> None:
    designs = (found.own, found.best_nominal, found.best_robust)
    head = ("", "own", "nominal optimum", "robust optimum")
    said = {"without tolerances": "nominal", "mean": "mean", "standard deviation": "std",
            f"mean + {found.sigmas:g} std": "robust"}  # fmt: skip
    rows = [(name, *(getattr(one, key) for one in designs)) for name, key in said.items()]
    console.table(f"Objective over {found.machines} machines, {found.samples} samples of a cycle", head, rows)
    parameters = [(name, *(one.design[name] for one in designs)) for name in found.design]
    console.table("Design", head, parameters)
