"""Commands that write a machine for other programs: below `planter export`."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    MachineArgument,
    ModelName,
    ModelOption,
    MotionFormat,
    SamplesOption,
    SetOption,
    SpeedOption,
    describe_motion_formats,
    refuse_unused,
    text_option,
    writes_files,
)

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.mechanism.state_space.model import DynamicsModel

export = typer.Typer(
    help="Write a machine for other programs: C, FMI, tables.\n\n"
    "MACHINE is a machine file, the file of a mechanism of your own, or a built-in machine. Of "
    "what an angle drives, values with bounds are the design, the others the machine's data. What moves "
    "freely is written as x' = f(t, x, u, p) and y = g(t, x, u, p) with their derivatives.\n\n"
    "`planter derive FILE.py --target matlab|latex` writes a mechanism's equations for MATLAB, or "
    "as LaTeX.",
    invoke_without_command=True,
    rich_markup_mode=None,
)
app = typer.Typer()
app.add_typer(export, name="export")


FolderOption = Annotated[Path, text_option("folder for the files", "DIR")]


InputsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--input",
        metavar="NAME",
        help="of what moves freely: a value of the file that is an input, beside those of the "
        "statement (repeatable)",
    ),
]


StabiliseOption = Annotated[
    float,
    typer.Option(
        metavar="RATE",
        min=0,
        help="of what moves freely: rate [1/s] at which gaps and slips decay, for integrators that "
        "do not project on the constraints",
    ),
]


def _load_subject(
    source: str,
    model: ModelName,
    set_: Sequence[str] | None,
    speed_rpm: float | None,
    inputs: Sequence[str] | None = None,
    stabilise: float = 0.0,
) -> Machine | DynamicsModel:
    """Return a machine that an angle drives, or the model of a mechanism that moves freely.

    Raises InputError for an option without effect on it.
    """
    from planter.engine.machine import Machine
    from planter.errors import InputError
    from planter.mechanism.dynamics import Dynamics
    from planter.mechanism.simulate_command import open_source
    from planter.mechanism.state_space.model import DynamicsModel

    opened = open_source(source, set_, speed_rpm, model)
    if isinstance(opened, Machine):
        refuse_unused("since an angle drives the machine", "--input", "--stabilise")
        return opened
    refuse_unused(f"since {opened.name} moves freely", "--model", "--speed-rpm")
    dynamics = Dynamics(opened)
    if dynamics.impacts:
        raise InputError(
            f"{opened.source}: {', '.join(dynamics.impacts)}: rates jump there, which no "
            f"export does; state the contact by `compliant_contact`"
        )
    return DynamicsModel(dynamics, inputs or (), stabilise)


def _write_files(console: Console, out: Path, texts: Mapping[str, str | bytes]) -> None:
    from planter.exports.results import WrittenFiles
    from planter.report.files import write_all

    paths = write_all(out, texts)
    console.result(WrittenFiles(paths), lambda: print("\n".join(paths)))


@export.callback()
def print_export_help(context: typer.Context) -> None:
    """Print the help of the group if no command follows."""
    if context.invoked_subcommand is None:
        print(context.get_help())


@export.command("c")
@writes_files()
def write_c(
    machine: MachineArgument,
    out: FolderOption,
    model: ModelOption = ModelName.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    inputs: InputsOption = None,
    stabilise: StabiliseOption = 0.0,
    as_json: JsonOption = False,
) -> None:
    """Write motions, forces and the objective as C99, or free dynamics.

    The text needs no library, and holds the gradient of the objective too. Closed loops are
    followed over a turn; a status says where they do not close. The objective is that of the file,
    over samples of a turn; without one there are only motions and forces.

    For example: planter export c wang2017 --out c && cd c && cc -O3 *.c -lm -o wang2017 &&
    ./wang2017 turn > turn.csv
    """
    console = Console(as_json)
    with console.outcome():
        from planter.engine.machine import Machine
        from planter.exports import c99, dynamics

        subject = _load_subject(machine, model, set_, speed_rpm, inputs, stabilise)
        if isinstance(subject, Machine):
            _write_files(console, out, c99.build_source_files(subject))
        else:
            _write_files(console, out, dynamics.build_c_files(subject))


LANGUAGES = {
    "casadi": """Write free dynamics as CasADi functions.

x' = f(t, x, u, p), y = g(t, x, u, p), their derivatives by x, u, p, and the curvature of f, in
a file that a Python module beside it loads without planter: for optimal control.

For example: planter export casadi cartpole.toml --input F_N --out casadi
""",
    "jax": """Write free dynamics as a Python module for JAX.

x' = f(t, x, u, p) and y = g(t, x, u, p), for jax.jit, jax.vmap and jax.jacfwd; it needs JAX
alone.

For example: planter export jax cartpole.toml --input F_N --out jax
""",
    "rust": """Write free dynamics as Rust without its standard library.

x' = f(t, x, u, p), y = g(t, x, u, p) and their derivatives by x, u, p; it links libm.

For example: planter export rust cartpole.toml --out rust &&
rustc --crate-type rlib -O rust/cartpole.rs
""",
}
"""Help of the commands for each language."""


@writes_files()
def write_dynamics(
    context: typer.Context,
    machine: MachineArgument,
    out: FolderOption,
    inputs: InputsOption = None,
    stabilise: StabiliseOption = 0.0,
    set_: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write free dynamics in the language that the command is named after."""
    console = Console(as_json)
    with console.outcome():
        from planter.engine.machine import Machine
        from planter.errors import InputError
        from planter.exports import dynamics

        subject = _load_subject(machine, ModelName.exact, set_, None, inputs, stabilise)
        if isinstance(subject, Machine):
            raise InputError(f"{machine}: an angle drives it; this export is of free motion")
        _write_files(console, out, dynamics.BUILDERS[str(context.command.name)](subject))


for language, text in LANGUAGES.items():
    export.command(language, help=text)(write_dynamics)


MOTION_HELP = f"""Write motions and forces over time as tables.

They are for multibody programs and Simulink; dictionary.csv has units and meanings.
{describe_motion_formats()}

For example: planter export motion wang2017 --format adams --turns 2 --out adams
"""


@export.command(help=MOTION_HELP)
@writes_files()
def motion(
    machine: MachineArgument,
    out: FolderOption,
    format_: Annotated[
        MotionFormat, typer.Option("--format", help="target program")
    ] = MotionFormat.csv,
    turns: Annotated[int, typer.Option(help="number of revolutions of the drive")] = 1,
    samples: SamplesOption = None,
    model: ModelOption = ModelName.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write motions and forces over time as tables in a format of `MotionFormat`."""
    console = Console(as_json)
    with console.outcome():
        from planter.exports.motion_tables import FORMATS
        from planter.exports.quantities import build_motion
        from planter.exports.results import MotionWritten
        from planter.mechanism.simulate_command import open_machine
        from planter.report.files import write_all

        driven = open_machine(machine, set_, speed_rpm, model)
        motion_ = build_motion(driven, turns, samples)
        paths = write_all(out, FORMATS[format_](motion_))
        result = MotionWritten(
            paths, format_.value, len(motion_.columns), len(motion_.time), float(motion_.time[-1])
        )
        console.result(result, lambda: print("\n".join(paths)))


class Fmi(enum.StrEnum):
    """Versions of the functional mock-up interface."""

    fmi2 = "2.0"
    fmi3 = "3.0"


@export.command()
@writes_files()
def fmu(
    machine: MachineArgument,
    out: Annotated[Path, text_option("the unit's file, which ends in .fmu", "FILE")],
    fmi: Annotated[Fmi, typer.Option(help="version of the interface")] = Fmi.fmi2,
    model: ModelOption = ModelName.exact,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    inputs: InputsOption = None,
    stabilise: StabiliseOption = 0.0,
    as_json: JsonOption = False,
) -> None:
    """Write a unit for other programs (FMI).

    What an angle drives is a co-simulation unit. The drive's speed goes in; its angle, all motions
    and forces are outputs. The speed is given; loads do not slow the drive (one-way coupling).
    Design and machine data are tunable parameters.

    What moves freely is a unit for model exchange, which the other program integrates, and for
    co-simulation: its states, inputs, parameters and outputs, event indicators and directional
    derivatives.

    The unit holds its C sources, a library for Linux and, with planter[compiler] installed, one for
    Windows.

    For example: planter export fmu wang2017 --out wang2017.fmu
    """
    console = Console(as_json)
    with console.outcome():
        from planter.exports.fmu import print_unit, write_unit

        subject = _load_subject(machine, model, set_, speed_rpm, inputs, stabilise)
        result = write_unit(subject, out, fmi.value)
        console.result(result, lambda: print_unit(console, result))
