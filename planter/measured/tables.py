"""A fit to measured data as tables that a person likes to read, no wider than 80 columns."""

from __future__ import annotations

import textwrap

from planter.measured.findings import MeasuredFound
from planter.terminal.console import Console

WIDTH = 80


def measured(console: Console, found: MeasuredFound) -> None:
    """What was found, how the data were treated, inputs with bands, both models, the prediction."""
    _say(f"{found.machine}: {found.statement}.")
    for line in found.treatment:
        _say(f"{line[0].upper()}{line[1:]}.")
    print()
    rows = [(e.name, e.value, e.low95, e.high95, e.unit, "open" if e.open else "") for e in found.fitted]
    console.table(
        f"Fitted (calibrated), with 95 % intervals for {found.noise.model} noise",
        ("input", "value", "from", "to", "unit", ""),
        rows,
    )
    models = [(name, one.outcome, one.rms, one.rms_of_noise, one.largest_residual, one.largest_residual_deg,
               f"{one.agreeing_starts} of {one.starts}") for name, one in found.models.items()]  # fmt: skip
    unit = found.unit
    head = ("model", "outcome", f"rms / {unit}", "/ noise", f"largest / {unit}", "at / deg", "agree")
    console.table("Residuals of the fits", head, models)
    first = found.models[found.model]
    if first.correlation is not None:
        names = [str(i) for i in range(1, len(first.fitted) + 1)]
        table = [(str(i), *row) for i, row in enumerate(first.correlation, 1)]
        console.table("Correlation of the inputs, in their order", ("", *names), table)
    if found.prediction is not None:
        left = ", ".join(f"{name} {value:.4g} {unit}" for name, value in found.prediction.rms.items())
        _say(f"Predicted at {found.prediction.speed_rpm:g} r/min ({found.prediction.points} points), left: {left}.")


def _say(text: str) -> None:
    print(textwrap.fill(text, WIDTH))
