"""Results of tolerances as tables of at most 80 columns."""

from __future__ import annotations

from planter.files.paths import last_part
from planter.terminal.console import Console
from planter.tolerance.results import RobustFound, ToleranceFound
from planter.tolerance.statistics import rank_shares

LARGEST = 3
"""Number of inputs in the table of an output."""


def print_tolerance(console: Console, result: ToleranceFound) -> None:
    """Print the bands, the inputs that matter most, and the robust design with the others."""
    chosen = "".join(f", {text} {name}" for name, text in result.choices.items())
    print(f"{result.machine}{chosen}: {len(result.inputs)} inputs vary, {result.rows} cycles\n")
    rows = [
        (name, band.nominal, band.mean, band.std, band.first_order_std, band.p5, band.p95)
        for name, band in result.outputs.items()
    ]
    console.table("Bands", ("output", "nominal", "mean", "std", "first order", "p5", "p95"), rows)
    shares = [
        (name if first else "", last_part(path), *(f"{x:.3f}" for x in (share.first, share.total, share.total_error)))
        for name, indices in result.sobol.items()
        for first, (path, share) in zip((True, *[False] * LARGEST), rank_shares(indices)[:LARGEST], strict=False)
        if share.total > 0
    ]
    if shares:
        console.table("Sobol' indices, largest first", ("output", "input", "first", "total", "+-"), shares)
    if result.robust is not None:
        _robust(console, result.robust)
    print(f"{result.seconds:.3g} s")


def _robust(console: Console, result: RobustFound) -> None:
    designs = (result.own, result.best_nominal, result.best_robust)
    head = ("", "own", "nominal optimum", "robust optimum")
    attributes = {"without tolerances": "nominal", "mean": "mean", "standard deviation": "std",
            f"mean + {result.sigmas:g} std": "robust"}  # fmt: skip
    rows = [(name, *(getattr(scored, key) for scored in designs)) for name, key in attributes.items()]
    console.table(f"Objective over {result.machines} machines, {result.samples} samples of a cycle", head, rows)
    parameters = [(name, *(scored.design[name] for scored in designs)) for name in result.design]
    console.table("Design", head, parameters)
