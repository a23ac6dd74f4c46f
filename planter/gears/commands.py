"""The command `planter gears`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import typer

from planter.errors import InputError
from planter.gears.options import (
    AddendumOption,
    BacklashOption,
    BoreOption,
    CentreErrorOption,
    ClearanceOption,
    CuttingProcessOption,
    KeepOption,
    KeywayOption,
    Module1Option,
    Module2Option,
    ModuleOption,
    PressureAngleOption,
    ProcessOption,
    ShiftOption,
    StepOption,
    StlOption,
    TeethOption,
    TipRadiusOption,
    ToleranceOption,
    UndercutOption,
    WidthOption,
)
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    OutOption,
    SetOption,
    SpeedOption,
    find_unused,
    parse_changes,
    writes_files,
)

app = typer.Typer()

HELP = """Cut teeth on the pitch curves of a machine, or of a file.

Their mesh is solved and checked, and they are written as files for a workshop.

MACHINE is a planting device: both of its stages are cut; or a seedling pick-up: its sun and intermediate gear have
teeth where the arm moves, and locking arcs where it dwells. --curve takes a CSV file with the columns polar_deg and
radius_mm over a closed turn, or FILE:PREFIX for columns PREFIX_polar_deg and PREFIX_radius_mm, as `planter train`
writes them; its mate is the conjugate, with which --mate is compared.

For a planting device it also reports the effect of tooth friction: without friction, by the paper's convention, and
against the sliding, with the lost work.

Every flank is exact, and so are the numbers; --out writes a drawing (DXF with arcs), a preview (SVG) and a table of
each gear, the assembly, figures and a page; --step and --stl solids too.

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
            help="a machine file, or the name of a built-in machine", show_default=False
        ),
    ] = None,
    curve: Annotated[
        str | None,
        typer.Option(metavar="FILE[:PREFIX]", help="pitch curve of a gear", show_default=False),
    ] = None,
    mate: Annotated[
        str | None,
        typer.Option(metavar="FILE[:PREFIX]", help="pitch curve of its mate", show_default=False),
    ] = None,
    turns: Annotated[
        str,
        typer.Option(
            metavar="N|N:1|1:N",
            help="with --curve: turns of the gear for one of the mate, or 1:N for a mate that "
            "turns N times in one",
        ),
    ] = "1",
    module: ModuleOption = None,
    module1: Module1Option = None,
    module2: Module2Option = None,
    teeth: TeethOption = None,
    keep: KeepOption = None,
    pressure_angle: PressureAngleOption = None,
    addendum: AddendumOption = None,
    clearance: ClearanceOption = 0.25,
    shift: ShiftOption = None,
    tip_radius: TipRadiusOption = 1.0,
    backlash_mm: BacklashOption = 0.0,
    centre_error_mm: CentreErrorOption = 0.0,
    process: ProcessOption = CuttingProcessOption.hob,
    allow_undercut: UndercutOption = False,
    tolerance_um: ToleranceOption = 1.0,
    bore_mm: BoreOption = None,
    keyway_mm: KeywayOption = None,
    width_mm: WidthOption = 12.0,
    step: StepOption = False,
    stl: StlOption = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    console = Console(as_json)
    with console.outcome():
        from planter.gears import gear_set, request
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
        rack_options = {"pressure_angle": pressure_angle, "addendum": addendum, "shift": shift}
        explicit = {name: value for name, value in rack_options.items() if value is not None}
        rack = request.Teeth(
            clearance=clearance,
            tip_radius=tip_radius,
            backlash_mm=backlash_mm,
            centre_error_mm=centre_error_mm,
            process=process,
            allow_undercut=allow_undercut,
            **explicit,
        )
        if curve is not None:
            stages = {"--module1": module1, "--module2": module2}
            _check(
                "goes with MACHINE, not with --curve",
                {**stages, "--set": set_, "--speed-rpm": speed_rpm},
            )
            gear_pair = gear_set.build_curve_set(
                curve, mate, request.GearTurns.parse(turns), rack, module, teeth, keep
            )
            result = gear_set.make_gear_set(gear_pair, rack, settings, out, console.progress)
        else:
            assert machine is not None
            _check("goes with --curve, not with MACHINE", {"--mate": mate, "--turns": turns != "1"})
            modules, numbers = (
                request.parse_modules(module, module1, module2),
                request.parse_tooth_counts(teeth),
            )
            options = request.GearOptions(
                rack,
                settings,
                frozenset(explicit),
                modules,
                numbers,
                keep,
                parse_changes(set_),
                speed_rpm,
            )
            result = request.find_adapter(machine).make(machine, options, out, console.progress)
        present_gears(result).show(console)


def _check(allowed: str, values: Mapping[str, object]) -> None:
    """Raise InputError for the first option that is given although it must not be."""
    for option, value in values.items():
        if value:
            raise InputError(f"{option} {allowed}")
