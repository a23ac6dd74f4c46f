"""The command `planter gears`, and options that other commands have too."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from typing import Annotated, Any

import typer

from planter.errors import InputError
from planter.report.completion import complete_machines
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    OutOption,
    SetOption,
    SpeedOption,
    find_unused,
    parse_changes,
    text_option,
    writes_files,
)

app = typer.Typer()


class Keep(enum.StrEnum):
    """Property of the gears that stays as designed: their size or their module."""

    size = "size"
    module = "module"


class CuttingProcessOption(enum.StrEnum):
    """Process by which the gears are cut."""

    hob = "hob"
    shaper = "shaper"
    wire = "wire"


ModuleOption = Annotated[float | None, typer.Option(min=0.05, max=50, help="module [mm]")]
Module1Option = Annotated[
    float | None,
    typer.Option(min=0.05, max=50, help="module of stage 1 [mm]"),
]
Module2Option = Annotated[
    float | None,
    typer.Option(min=0.05, max=50, help="module of stage 2 [mm]"),
]

HELP = """Cut teeth on the pitch curves of a machine, or of a file.

Their mesh is solved and checked, and they are written as files for a workshop.

MACHINE is a planting device: both of its stages are cut; or a seedling pick-up: its sun and
intermediate gear have teeth where the arm moves, and locking arcs where it dwells. --curve takes
a CSV file with the columns polar_deg and radius_mm over a closed turn, or FILE:PREFIX for columns
PREFIX_polar_deg and PREFIX_radius_mm, as `planter design train` writes them; its mate is the
conjugate, with which --mate is compared.

For a planting device it also reports the effect of tooth friction: without friction, by the
paper's convention, and against the sliding, with the lost work.

Every flank is exact, and so are the numbers; --out writes a drawing (DXF with arcs), a preview
(SVG) and a table of each gear, the assembly, figures and a page; --step and --stl solids too.

\b
    planter gears wang2017 --module 2 --backlash-mm 0.05 --out gears
    planter gears wang2017 --teeth 31,31 --bore-mm 12 --step --out gears
    planter gears yu2023 --backlash-mm 0.05 --out gears
    planter gears --curve pitch_curves.csv:driver_1 --mate pitch_curves.csv:follower_1 --teeth 48
"""


@app.command(help=HELP)
@writes_files("summary.json", "report.html", "assembly.dxf", "assembly.svg")
def gears(
    machine: Annotated[
        str | None,
        typer.Argument(
            metavar="MACHINE",
            help="a machine file, or the name of a built-in machine",
            autocompletion=complete_machines,
        ),
    ] = None,
    curve: Annotated[str | None, text_option("pitch curve of a gear", "FILE[:PREFIX]")] = None,
    mate: Annotated[str | None, text_option("pitch curve of its mate", "FILE[:PREFIX]")] = None,
    turns: Annotated[
        str,
        text_option(
            "with --curve: turns of the gear for one of the mate, or 1:N for a mate that "
            "turns N times in one",
            "N|N:1|1:N",
        ),
    ] = "1",
    module: ModuleOption = None,
    module1: Module1Option = None,
    module2: Module2Option = None,
    teeth: Annotated[
        str | None,
        text_option(
            "tooth counts of a gear of stage 1 and of stage 2 [default: the "
            "integer nearest to the pitch curve's length over pi m]",
            "Z1,Z2",
        ),
    ] = None,
    keep: Annotated[
        Keep | None,
        typer.Option(
            help="retain the designed size and adapt the module, or keep the module and scale "
            "the pair [default: the size with --teeth, else the module]"
        ),
    ] = None,
    pressure_angle: Annotated[
        float | None,
        typer.Option(
            min=10,
            max=35,
            help="pressure angle of the rack [deg] [default: the machine's, else 20]",
        ),
    ] = None,
    addendum: Annotated[
        float | None,
        typer.Option(
            min=0.3,
            max=1.5,
            help="addendum of the rack in modules [default: the machine's, else 1]",
        ),
    ] = None,
    clearance: Annotated[
        float, typer.Option(min=0.02, max=0.6, help="clearance in modules")
    ] = 0.25,
    shift: Annotated[
        float | None,
        typer.Option(
            min=-1,
            max=1,
            help="profile shift of the first gear in modules, its mate's is the opposite [default: "
            "the machine's, else 0]",
        ),
    ] = None,
    tip_radius: Annotated[
        float,
        typer.Option(
            min=0.01,
            max=1,
            help="tip radius of the rack in modules; a smaller one cuts a deeper root",
        ),
    ] = 1.0,
    backlash_mm: Annotated[
        float, typer.Option(min=0, max=10, help="circumferential backlash, shared by both gears")
    ] = 0.0,
    centre_error_mm: Annotated[
        float,
        typer.Option(
            min=0,
            max=5,
            help="also report lost motion and contact ratio for axes farther apart by this",
        ),
    ] = 0.0,
    process: Annotated[
        CuttingProcessOption,
        typer.Option(help="manufacturing process; a hob cannot cut concave pitch curves"),
    ] = CuttingProcessOption.hob,
    allow_undercut: Annotated[
        bool, typer.Option("--allow-undercut", help="allow undercut flanks")
    ] = False,
    tolerance_um: Annotated[
        float, typer.Option(min=0.05, max=100, help="tolerance of the arcs")
    ] = 1.0,
    bore_mm: Annotated[
        float | None, typer.Option(min=0.5, max=1000, help="bore of every gear")
    ] = None,
    keyway_mm: Annotated[
        str | None, text_option("keyway in the bore [default: DIN 6885-1's]", "WIDTH,DEPTH|none")
    ] = None,
    width_mm: Annotated[float, typer.Option(min=0.1, max=1000, help="width of the gears")] = 12.0,
    step: Annotated[
        bool, typer.Option("--step", help="also solids in STEP (needs planter[step])")
    ] = False,
    stl: Annotated[bool, typer.Option("--stl", help="also solids in STL")] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    console = Console(as_json)
    with console.outcome():
        from planter.gears import gear_set, request
        from planter.gears.geometry.cutting import ToothOrder
        from planter.gears.presentation import present_gears

        if (machine is None) == (curve is None):
            raise InputError("give either MACHINE or --curve")
        _check("needs --out DIR", {"--step": step and not out, "--stl": stl and not out})
        of_files = ["--tolerance-um"] if out is None else []
        if unused := find_unused(*of_files, *([] if step or stl else ["--width-mm"])):
            console.say(
                f"no effect without the files that they shape (--out, --step, --stl): "
                f"{', '.join(unused)}"
            )
        settings = request.parse_part_settings(
            tolerance_um, bore_mm, keyway_mm, width_mm, step, stl
        )
        angle = None if pressure_angle is None else math.radians(pressure_angle)
        rack_options = {"pressure_angle": angle, "addendum": addendum, "shift": shift}
        explicit: dict[str, Any] = {
            name: value for name, value in rack_options.items() if value is not None
        }
        order = ToothOrder(
            clearance=clearance,
            tip_radius=tip_radius,
            play=backlash_mm * 1e-3,
            process=process,
            allow_undercut=allow_undercut,
            **explicit,
        )
        options = request.GearOptions(
            order,
            frozenset(explicit),
            request.parse_modules(module, module1, module2),
            request.parse_tooth_counts(teeth),
            keep,
            parse_changes(set_),
            speed_rpm,
        )
        if curve is not None:
            stages = {"--module1": module1, "--module2": module2}
            _check(
                "goes with MACHINE, not with --curve",
                {**stages, "--set": set_, "--speed-rpm": speed_rpm},
            )
            gear_pairs = gear_set.cut_curve(curve, mate, request.GearTurns.parse(turns), options)
        else:
            assert machine is not None
            _check("goes with --curve, not with MACHINE", {"--mate": mate, "--turns": turns != "1"})
            gear_pairs = gear_set.cut_machine(machine, options)
        farther = centre_error_mm * 1e-3
        result = gear_set.make_gears(gear_pairs, settings, farther, out, console.progress)
        present_gears(result).show(console)


def _check(allowed: str, values: Mapping[str, object]) -> None:
    """Raise InputError for the first option that is given although it must not be."""
    for option, value in values.items():
        if value:
            raise InputError(f"{option} {allowed}")
