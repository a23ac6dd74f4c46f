"""Commands that write a machine for other programs: below `planter export`."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from planter.planting.commands.options import MachineArgument, Model, ModelOption, SamplesOption, device_of
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, SetOption, SpeedOption

export = typer.Typer(
    help="A machine for other programs: source text, a unit for co-simulation, tables over time.",
    invoke_without_command=True,
    rich_markup_mode=None,
)
app = typer.Typer()
app.add_typer(export, name="export")

FolderOption = Annotated[Path, typer.Option("--out", metavar="DIR", help="folder for the files", show_default=False)]


@export.callback()
def common(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


@export.command()
@writes()
def c(
    machine: MachineArgument,
    out: FolderOption,
    model: ModelOption = Model.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """All motions and forces, the objective and its gradient in C99 that needs nothing else.

    planter export c wang2017 --out c && cd c && cc -O3 *.c -lm -o wang2017 && ./wang2017 turn > turn.csv
    """
    console = Console(as_json)
    with console.outcome():
        from planter.planting.export import c99 as texts

        device = device_of(machine, model, set_, speed_rpm)
        _written(console, out, texts.source_files(device))


@export.command()
@writes()
def cuda(
    machine: MachineArgument,
    out: FolderOption,
    model: ModelOption = Model.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """The objective of many designs in CUDA C++: a thread for each design and angle."""
    console = Console(as_json)
    with console.outcome():
        from planter.planting.export import cuda as texts

        device = device_of(machine, model, set_, speed_rpm)
        _written(console, out, texts.source_files(device))


class Format(enum.StrEnum):
    adams = "adams"
    solidworks = "solidworks"
    simulink = "simulink"
    csv = "csv"


@export.command()
@writes()
def motion(
    machine: MachineArgument,
    out: FolderOption,
    format_: Annotated[Format, typer.Option("--format", help="the program that is to read it")] = Format.csv,
    turns: Annotated[int, typer.Option(help="how many turns of the carrier")] = 1,
    samples: SamplesOption = None,
    model: ModelOption = Model.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """All motions and forces over time, for multibody programs and Simulink; dictionary.csv says units and meanings.

    adams: motion.cmd, which makes splines for AKISPL and CUBSPL (mm, N, N mm, deg, s). solidworks: a CSV file of time
    and value for each quantity, for motors and forces by data points. simulink: motion.mat for the block From File (SI,
    rad). csv: motion.csv.

    planter export motion wang2017 --format adams --turns 2 --out adams
    """
    console = Console(as_json)
    with console.outcome():
        from planter.interchange.tables.formats import FORMATS
        from planter.planting.export.motion import over_time
        from planter.planting.results.exported import MotionWritten
        from planter.report.files import write_all

        told = over_time(device_of(machine, model, set_, speed_rpm), turns, samples)
        files = FORMATS[format_](told)
        paths = write_all(out, files)
        found = MotionWritten(paths, format_.value, len(told.columns), len(told.time), float(told.time[-1]))
        console.result(found, lambda: print("\n".join(paths)))


class Fmi(enum.StrEnum):
    two = "2.0"
    three = "3.0"


@export.command()
@writes()
def fmu(
    machine: MachineArgument,
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="the unit's file, which ends in .fmu", show_default=False)
    ],
    fmi: Annotated[Fmi, typer.Option(help="version of the interface")] = Fmi.two,
    model: ModelOption = Model.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """A unit for co-simulation by FMI: the carrier's speed goes in, its angle, all motions and forces come out.

    The speed is prescribed: nothing acts back on it. Design and machine are tunable parameters. The unit holds its C
    sources, a library for Linux and, with planter[compiler] installed, one for Windows.

    planter export fmu wang2017 --out wang2017.fmu
    """
    console = Console(as_json)
    with console.outcome():
        from planter.planting import tables
        from planter.planting.export import fmu as unit

        found = unit.write(device_of(machine, model, set_, speed_rpm), out, fmi.value)
        console.result(found, lambda: tables.unit(console, found))


def _written(console: Console, folder: Path, texts: Mapping[str, str]) -> None:
    from planter.planting.results.exported import Written
    from planter.report.files import write_all

    paths = write_all(folder, texts)
    console.result(Written(paths), lambda: print("\n".join(paths)))
