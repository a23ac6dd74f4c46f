"""`planter sensitivity` and `cam`: analyses of a machine without a search."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.errors import InputError
from planter.mechanism.simulate_command import open_machine
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    LeastOption,
    MachineArgument,
    ModelName,
    ModelOption,
    OutOption,
    SamplesOption,
    SetOption,
    SpeedOption,
    text_option,
    writes_files,
)

app = typer.Typer()


@app.command()
@writes_files("summary.json", "report.html")
def sensitivity(
    machine: MachineArgument,
    model: ModelOption = ModelName.exact,
    samples: SamplesOption = None,
    least: LeastOption = None,
    all_values: Annotated[
        bool,
        typer.Option(
            "--all", help="for all values of the file, not only those of the design or with bounds"
        ),
    ] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find which design parameters the objective depends on.

    The result has its gradient, and combinations of parameters that have no effect.

    For your mechanism the objective is that of its file, or --least; by true extremes unless
    --samples says a number. A value without bounds counts by its size.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.mechanism.optimisation import compute_objective_sensitivity
        from planter.mechanism.presentation import present_sensitivity

        opened = open_machine(machine, set_, speed_rpm, model, may_move=True)
        result = compute_objective_sensitivity(opened, samples, least, all_values)
        present_sensitivity(result, opened).show(console, out)


CAM_EPILOG = (
    "For example: planter cam wang2017 --roller-mm 6 --step --out cam; "
    "planter cam cam_follower --roller-mm 8 --bore-mm 12 --out cam"
)


@app.command(epilog=CAM_EPILOG)
@writes_files("summary.json", "report.html", "contour.dxf", "contour.svg", "contour.csv")
def cam(
    machine: MachineArgument,
    roller_mm: Annotated[float, text_option("radius of the roller", "R")],
    y: Annotated[
        str | None,
        text_option(
            "for a mechanism whose statement has no follower: where the roller's centre is from "
            "the cam's axis, "
            "along y: a sum of quantities of `planter simulate`, values of the file, and numbers "
            "in mm, such as y_0+s",
            "SUM",
        ),
    ] = None,
    x: Annotated[str | None, text_option("with --y: the same along x [default: 0]", "SUM")] = None,
    force: Annotated[
        str | None,
        text_option("for a mechanism: the follower's force, which is zero at lift-off", "NAME"),
    ] = None,
    bore_mm: Annotated[
        float | None, typer.Option(min=0.1, help="for a mechanism: bore of the disc")
    ] = None,
    width_mm: Annotated[
        float,
        typer.Option(
            min=0.1, max=1000, help="width of the rim or disc, and minimum height of a rim"
        ),
    ] = 10.0,
    tolerance_um: Annotated[
        float,
        typer.Option(min=0.01, max=100, help="maximum deviation of the arcs from the contour"),
    ] = 1.0,
    step: Annotated[
        bool, typer.Option("--step", help="with --out: also the solid (needs planter[step])")
    ] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Design the cam as a part, for a roller.

    The result has contour, pressure angle, undercut margin and speed of lift-off; --out writes DXF,
    CSV and STEP.

    Of a planting device it is the end-face cam, unrolled and in space; of your mechanism the disc
    that turns with its angle.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.gears.workshop.cam_report import present_cam
        from planter.mechanism.extension import CamRequest, find_extension

        if x is not None and y is None:
            raise InputError("--x needs --y")
        if step and out is None:
            raise InputError("--step needs --out DIR to write the solid to")
        request = CamRequest(
            roller_mm * 1e-3,
            tolerance_um * 1e-6,
            width_mm * 1e-3,
            None if bore_mm is None else bore_mm * 1e-3,
            None if y is None else (x or "0", y),
            force,
        )
        opened = open_machine(machine, set_, speed_rpm)
        design = find_extension(opened).build_cam(request)
        present_cam(design, step, out is not None).show(console, out)
