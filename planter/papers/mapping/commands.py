"""Commands of the design by kinematic mapping: from poses to dyads, from an angle curve to a gear
train.
"""

from __future__ import annotations

import math
from typing import Annotated

import typer

from planter.errors import InputError
from planter.report.completion import complete_sources
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    OutOption,
    SetOption,
    parse_changes,
    refuse_unused,
    writes_files,
)

PosesArgument = Annotated[
    str,
    typer.Argument(
        metavar="POSES",
        help="a file of poses (TOML), or the name of a built-in one",
        autocompletion=complete_sources("mapping"),
    ),
]
CurveArgument = Annotated[
    str,
    typer.Argument(
        metavar="CURVE",
        help="a CSV of angles (carrier_deg,relative_deg), or the name of a built-in one",
        autocompletion=complete_sources("mapping", ".csv"),
    ),
]
CarrierOption = Annotated[int, typer.Option(min=1, help="dyad of the carrier, counted by radius")]
LARGEST_MM = 1e6


app = typer.Typer()


@app.command()
@writes_files("summary.json", "report.html")
def synthesise(
    poses: PosesArgument,
    carrier: CarrierOption = 1,
    least_slope: Annotated[
        float, typer.Option(help="minimum slope of the monotone angle curve")
    ] = 0.1,
    largest_slope: Annotated[
        float, typer.Option(help="maximum slope of the monotone angle curve")
    ] = 10.0,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find linkages that carry an arm through given poses.

    The result lists dyads, four-bar linkages and the angle curve of the arm.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.mapping.file import load_poses
        from planter.papers.mapping.presentation import present_synthesis
        from planter.papers.mapping.synthesis import synthesise as synthesis

        if not 0 < least_slope < 1:
            raise InputError(f"--least-slope {least_slope:g}: the value must be between 0 and 1")
        if not 1 < largest_slope <= 1e3:
            raise InputError(
                f"--largest-slope {largest_slope:g}: the value must be above 1 and at most 1000"
            )
        solution = synthesis(
            load_poses(poses, parse_changes(set_)), carrier, (least_slope, largest_slope)
        )
        present_synthesis(solution).show(console, out)


@app.command()
@writes_files("summary.json", "cycle.csv", "pitch_curves.csv", "report.html")
def train(
    curve: CurveArgument,
    centre_distance_mm: Annotated[
        float, typer.Option(help="centre distance of both stages")
    ] = 70.0,
    crank_mm: Annotated[float | None, typer.Option(help="length of the carrier")] = None,
    poses: Annotated[
        str | None, typer.Option(help="poses to compare the path of the tip with")
    ] = None,
    carrier: CarrierOption = 1,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find the gear train that turns an arm by an angle curve.

    It has two stages of non-circular gears. The curve is one closed turn: over 360 deg of the
    carrier the arm's rotation against it falls by 360 deg, or rises, and never stands still. The
    command warns about very small radii, near-cusps and concave pitch curves.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.mapping.curve import load_curve
        from planter.papers.mapping.file import load_poses
        from planter.papers.mapping.presentation import present_train
        from planter.papers.mapping.train import build_training

        if poses is None:
            refuse_unused("without --poses", "--carrier")
        distance = _length("--centre-distance-mm", centre_distance_mm)
        crank = None if crank_mm is None else _length("--crank-mm", crank_mm)
        if crank is not None and crank > 2 * distance:
            raise InputError(
                f"--crank-mm {crank_mm:g}: the value must be at most twice the centre distance, "
                f"{2 * centre_distance_mm:g} mm"
            )
        file = None if poses is None else load_poses(poses)
        training = build_training(load_curve(curve), distance, crank, file, carrier)
        present_train(training, curve).show(console, out)


def _length(option: str, value_mm: float) -> float:
    """Return a length [m]. Raises InputError if it is not positive and at most LARGEST_MM."""
    if not (math.isfinite(value_mm) and 0 < value_mm <= LARGEST_MM):
        raise InputError(
            f"{option} {value_mm:g}: the value must be above 0 and at most {LARGEST_MM:g}"
        )
    return value_mm * 1e-3
