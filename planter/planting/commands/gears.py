"""The command that makes gears with teeth."""

from __future__ import annotations

from typing import Annotated

import typer

from planter import rooms
from planter.errors import InputError
from planter.gears.options import (
    AddendumOption,
    BacklashOption,
    BoreOption,
    CentreErrorOption,
    ClearanceOption,
    KeepOption,
    KeywayOption,
    Module1Option,
    Module2Option,
    ModuleOption,
    PressureAngleOption,
    Process,
    ProcessOption,
    ShiftOption,
    StepOption,
    StlOption,
    Teeth,
    TeethOption,
    TipRadiusOption,
    ToleranceOption,
    UndercutOption,
    WidthOption,
)
from planter.planting.commands.options import SpeedOption, device_of
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption

app = typer.Typer()

HELP = """Teeth on the pitch curves of a machine, or of a curve in a file: proved to mesh, in files for a workshop.

MACHINE is a planting device: both of its stages are cut; or a seedling pick-up: its sun and intermediate gear have
teeth where the arm moves, and locking arcs where it dwells. --curve takes a CSV file with the columns polar_deg and
radius_mm over a closed turn, or FILE:PREFIX for columns PREFIX_polar_deg and PREFIX_radius_mm, as `planter train`
writes them; its mate is the conjugate, against which --mate is held.

Every flank is exact, and so are the numbers; --out writes a drawing (DXF with arcs), a preview (SVG) and a table of
each gear, the assembly, figures and a page; --step and --stl solids too.

\b
    planter gears wang2017 --module 2 --backlash-mm 0.05 --out gears
    planter gears wang2017 --teeth 31,31 --bore-mm 12 --step --out gears
    planter gears yu2023 --backlash-mm 0.05 --out gears
    planter gears --curve pitch_curves.csv:driver_1 --mate pitch_curves.csv:follower_1 --teeth 48
"""


@app.command(help=HELP)
def gears(
    machine: Annotated[
        str | None, typer.Argument(help="a machine file, or the name of a built-in machine", show_default=False)
    ] = None,
    curve: Annotated[
        str | None, typer.Option(metavar="FILE[:PREFIX]", help="pitch curve of a gear", show_default=False)
    ] = None,
    mate: Annotated[
        str | None, typer.Option(metavar="FILE[:PREFIX]", help="pitch curve of its mate", show_default=False)
    ] = None,
    turns: Annotated[int, typer.Option(min=1, max=20, help="turns of the gear for one of the mate, with --curve")] = 1,
    module: ModuleOption = None,
    module1: Module1Option = None,
    module2: Module2Option = None,
    teeth: TeethOption = None,
    keep: KeepOption = None,
    pressure_angle: PressureAngleOption = 20.0,
    addendum: AddendumOption = 1.0,
    clearance: ClearanceOption = 0.25,
    shift: ShiftOption = 0.0,
    tip_radius: TipRadiusOption = 1.0,
    backlash_mm: BacklashOption = 0.0,
    centre_error_mm: CentreErrorOption = 0.0,
    process: ProcessOption = Process.hob,
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
        from planter.gears import command, options, tables

        if (machine is None) == (curve is None):
            raise InputError("one of MACHINE and --curve must be given")
        if curve is None and (mate is not None or turns != 1):
            raise InputError("--mate and --turns go with --curve")
        made = options.parts(tolerance_um, bore_mm, keyway_mm, width_mm, step, stl)
        rack = Teeth(
            pressure_angle,
            addendum,
            clearance,
            shift,
            tip_radius,
            backlash_mm,
            centre_error_mm,
            process,
            allow_undercut,
        )
        if curve is not None:
            if module1 is not None or module2 is not None:
                raise InputError("--module1 and --module2 go with MACHINE: a curve has --module")
            found = command.of_curves(curve, mate, turns, rack, module, teeth, keep)
            result = command.make(found, rack, made, out, console.progress)
        else:
            assert machine is not None
            modules, numbers = options.modules(module, module1, module2), options.counts(teeth)
            other = next((room for room in rooms.brought("toothed") if room.takes(machine)), None)
            if other is not None:
                result = other.make(machine, rack, modules, numbers, keep, set_, made, out, console.progress)
            else:
                from planter.planting import gears as cut

                device = device_of(machine, "exact", set_, speed_rpm)
                found = cut.gears(device, rack, modules, numbers, keep)
                result = command.make(found, rack, made, out, console.progress)
        console.result(result, lambda: tables.show(console, result))
