"""Command of the clutch's engagement."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Annotated

import typer

from planter.clutch.commands.group import ClutchArgument, clutch
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption, changes

if TYPE_CHECKING:
    from planter.clutch.results.engagement import ContactEngagement, ModalEngagement


class Mode(enum.StrEnum):
    modal = "modal"
    contact = "contact"


@clutch.command()
@writes("summary.json", "report.html")
def engage(
    source: ClutchArgument,
    mode: Annotated[
        Mode, typer.Option(help="one mode of the shaft in closed form, or contact of the real profiles")
    ] = Mode.modal,
    shape: Annotated[
        str,
        typer.Option(metavar="NAME", help="bending shape of the shaft: the paper's, or a clamped one (clamped-...)"),
    ] = "quarter-sine",
    set_: SetOption = None,
    speed_rpm: Annotated[float | None, typer.Option(help="change the input speed for this call")] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute the loads while a clutch engages.

    By contact also its cut-off, and a dog clutch for comparison; this takes half a minute.

    In contact, `sensitivity` follows the largest loads over a factor of 10 in each input that the paper does not
    disclose. Shapes: quarter-sine, clamped-cosine, clamped-static, clamped-mode.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.clutch.engage import contact, modal, tables
        from planter.clutch.file import load

        file = load(source, changes(set_, {"engagement.input_speed_rpm": speed_rpm}))
        if mode is Mode.modal:
            result: ModalEngagement | ContactEngagement = modal.result(file, shape)
            curves = None
        else:
            found = contact.compare(file, shape, progress=console.progress)
            result, curves = found.result, found.runs
        if out is not None:
            from planter.clutch.report import engagement

            engagement.write(out, file, result, shape, curves)
        console.result(result, lambda: tables.show(console, result))
