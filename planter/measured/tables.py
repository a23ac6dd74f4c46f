"""Results of a fit to measured data as tables of at most 80 columns."""

from __future__ import annotations

import textwrap

from planter.measured.findings import MeasuredFound
from planter.terminal.console import Console

WIDTH = 80


def measured(console: Console, result: MeasuredFound) -> None:
    """Print the statement, the treatment of the data, the inputs with intervals, the models, the prediction."""
    _say(f"{result.machine}: {result.statement}.")
    for line in result.treatment:
        _say(f"{line[0].upper()}{line[1:]}.")
    print()
    rows = [(e.name, e.value, e.low95, e.high95, e.unit, "open" if e.open else "") for e in result.fitted]
    console.table(
        f"Fitted (calibrated), with 95 % intervals for {result.noise.model} noise",
        ("input", "value", "from", "to", "unit", ""),
        rows,
    )
    models = [(name, fit.outcome, fit.rms, fit.rms_of_noise, fit.largest_residual, fit.largest_residual_deg,
               f"{fit.agreeing_starts} of {fit.starts}") for name, fit in result.models.items()]  # fmt: skip
    unit = result.unit
    head = ("model", "outcome", f"rms / {unit}", "/ noise", f"largest / {unit}", "at / deg", "agree")
    console.table("Residuals of the fits", head, models)
    first = result.models[result.model]
    if first.correlation is not None:
        names = [str(i) for i in range(1, len(first.fitted) + 1)]
        table = [(str(i), *row) for i, row in enumerate(first.correlation, 1)]
        console.table("Correlation of the inputs, in their order", ("", *names), table)
    if result.prediction is not None:
        prediction = result.prediction
        residuals = ", ".join(f"{name} {value:.4g} {unit}" for name, value in prediction.rms.items())
        _say(f"Predicted at {prediction.speed_rpm:g} r/min ({prediction.points} points), RMS residuals: {residuals}.")


def _say(text: str) -> None:
    print(textwrap.fill(text, WIDTH))
