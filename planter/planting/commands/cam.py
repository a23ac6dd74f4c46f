"""`planter cam`: the cam of a planting device, or of a mechanism of one's own, as a part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import typer

from planter.errors import InputError
from planter.planting.commands.options import device_of, load_other
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption, SpeedOption

app = typer.Typer()

MachineArgument = Annotated[
    str,
    typer.Argument(help="a machine file, a built-in machine, or a mechanism of your own", show_default=False),
]
RollerOption = Annotated[float, typer.Option(metavar="R", help="radius of the roller", show_default=False)]
YOption = Annotated[
    str | None,
    typer.Option(
        metavar="SUM",
        help="for a mechanism whose statement has no follower: where the roller's centre is from the cam's axis, "
        "along y: a sum of quantities of `planter simulate`, values of the file, and numbers in mm, such as y_0+s",
        show_default=False,
    ),
]
XOption = Annotated[
    str | None, typer.Option(metavar="SUM", help="with --y: the same along x [default: 0]", show_default=False)
]
ForceOption = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="for a mechanism: the follower's force, which lift-off ends", show_default=False),
]
BoreOption = Annotated[
    float | None, typer.Option(min=0.1, help="for a mechanism: bore of the disc", show_default=False)
]
WidthOption = Annotated[
    float, typer.Option(min=0.1, max=1000, help="width of the rim or disc, and minimum height of a rim")
]
ToleranceOption = Annotated[
    float, typer.Option(min=0.01, max=100, help="maximum deviation of the arcs from the contour")
]
EPILOG = (
    "For example: planter cam wang2017 --roller-mm 6 --step --out cam; "
    "planter cam cam_follower --roller-mm 8 --bore-mm 12 --out cam"
)


@app.command(epilog=EPILOG)
@writes("summary.json", "report.html", "contour.dxf", "contour.svg", "contour.csv")
def cam(
    machine: MachineArgument,
    roller_mm: RollerOption,
    y: YOption = None,
    x: XOption = None,
    force: ForceOption = None,
    bore_mm: BoreOption = None,
    width_mm: WidthOption = 10.0,
    tolerance_um: ToleranceOption = 1.0,
    step: Annotated[bool, typer.Option("--step", help="with --out: also the solid (needs planter[step])")] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Design the cam as a part, for a roller.

    The result has contour, pressure angle, undercut margin and speed of lift-off; --out writes DXF, CSV and STEP.

    Of a planting device it is the end-face cam, unrolled and in space; of a mechanism of your own the disc that turns
    with its angle.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.workshop import cam_report

        other = load_other(machine, set_, None)
        if other is not None:
            _check("needs --y", {"--x": x is not None and y is None})
            _check("does not apply to a mechanism of your own; --set changes its speed", {"--speed-rpm": speed_rpm})
        else:
            own = {"--y": y, "--x": x, "--force": force, "--bore-mm": bore_mm}
            _check("is for a mechanism of your own", {name: given is not None for name, given in own.items()})
        _check("needs --out DIR to write the solid to", {"--step": step and out is None})
        roller, width, tolerance = roller_mm * 1e-3, width_mm * 1e-3, tolerance_um * 1e-6
        if other is not None:
            from planter.mechanism import cam as disc
            from planter.mechanism.model import Model

            model, bore = Model(other), (bore_mm or 0.0) * 1e-3
            centre, push = ((x or "0", y), force) if y else disc.centre_of_follower(model, force)
            found = disc.made(model, roller, centre, push, tolerance, width, bore)
        else:
            from planter.planting import cam as end_face

            found = end_face.made(device_of(machine, "exact", set_, speed_rpm), roller, tolerance, width)
        result = found.part.result if out is None else cam_report.write_cam(out, found, step)
        console.result(result, lambda: cam_report.show_cam(console, result))


def _check(allowed: str, given: Mapping[str, object]) -> None:
    if wrong := [option for option, there in given.items() if there]:
        raise InputError(f"{', '.join(wrong)} {allowed}")
