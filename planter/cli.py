"""The command line: arguments in, results out. Heavy parts are loaded by the command that needs them."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter import __version__
from planter import machine as machines
from planter.console import Console
from planter.errors import InputError, Interrupted

if TYPE_CHECKING:
    from planter.device import Device

app = typer.Typer(
    name="planter",
    help="Planting-machine mechanisms, from the printed equation to the optimum.",
    invoke_without_command=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class Model(enum.StrEnum):
    exact = "exact"
    printed = "printed"


class Method(enum.StrEnum):
    hybrid = "hybrid"
    ipopt = "ipopt"
    ga = "ga"


MachineArgument = Annotated[
    str, typer.Argument(help="a machine file, or the name of a built-in machine", show_default=False)
]
ModelOption = Annotated[Model, typer.Option(help="first principles, or the paper's equations as printed")]
JsonOption = Annotated[bool, typer.Option("--json", help="print one JSON object instead of tables")]
OutOption = Annotated[Path | None, typer.Option(help="folder for result files", show_default=False)]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="change a value for this call", show_default=False),
]
SpeedOption = Annotated[float | None, typer.Option(help="change the carrier speed for this call", show_default=False)]


def _version(wanted: bool) -> None:
    if wanted:
        print(f"planter {__version__}")
        raise typer.Exit


@app.callback()
def common(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    """Planting-machine mechanisms, from the printed equation to the optimum."""
    if context.invoked_subcommand is None:
        print(context.get_help())


def overrides(settings: Sequence[str] | None, speed_rpm: float | None) -> dict[str, float]:
    """Values to change, from `--set name=value` and `--speed-rpm`."""
    found: dict[str, float] = {}
    for setting in settings or ():
        name, equals, text = setting.partition("=")
        try:
            found[name.strip()] = float(text)
        except ValueError:
            allowed = "it must be NAME=VALUE with a number" if equals else "it must be NAME=VALUE"
            raise InputError(f"--set {setting} is not allowed: {allowed}") from None
    if speed_rpm is not None:
        found["operation.speed_rpm"] = speed_rpm
    return found


def device_of(source: str, model: str, settings: Sequence[str] | None, speed_rpm: float | None) -> Device:
    from planter.device import Device

    return Device(machines.load(source, overrides(settings, speed_rpm)), "exact" if model == "exact" else "printed")


@app.command()
def simulate(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    samples: Annotated[
        int | None, typer.Option(help="angles of the cycle [default: the machine file's]", show_default=False)
    ] = None,
    at: Annotated[
        list[float] | None, typer.Option(metavar="DEG", help="also report at this carrier angle", show_default=False)
    ] = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Forces and motion of a machine's own design over a cycle."""
    console = Console(as_json)
    with console.outcome():
        from planter import simulate as simulation
        from planter import tables

        device = device_of(machine, model, set_, speed_rpm)
        found = simulation.simulate(device, samples, at or ())
        if out is not None:
            from planter.report import results as report

            report.write_simulation(out, device, found)
        console.result(found.result, lambda: tables.simulation(console, found.result))


@app.command()
def sensitivity(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    samples: Annotated[
        int | None, typer.Option(help="angles of the cycle [default: the machine file's]", show_default=False)
    ] = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Gradient of the objective, and which design parameters the support force does not feel."""
    console = Console(as_json)
    with console.outcome():
        from planter import simulate as simulation
        from planter import tables

        device = device_of(machine, model, set_, speed_rpm)
        result = simulation.sensitivity(device, samples)
        if out is not None:
            from planter.report import results as report

            report.write_result(out, device, result)
        console.result(result, lambda: tables.sensitivity(console, result))


@app.command()
def optimise(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    method: Annotated[
        Method, typer.Option(help="genetic algorithm, IPOPT from several starts, or both")
    ] = Method.hybrid,
    samples: Annotated[
        str | None,
        typer.Option(
            metavar="N|refined",
            help="angles of the cycle, or true extremes and integrals [default: the machine file's]",
            show_default=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="seed of everything random")] = 0,
    starts: Annotated[int | None, typer.Option(min=1, help="starts of IPOPT", show_default=False)] = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Optimise the design within the machine file's bounds, and say how sure the optimum is."""
    console = Console(as_json)
    with console.outcome():
        from planter import optimisation, tables

        device = device_of(machine, model, set_, speed_rpm)
        try:
            found = optimisation.optimise(
                device, method.value, samples, seed, starts, lambda p: console.progress(str(p), p.done, p.total)
            )
        except Interrupted as stop:
            if out is not None and stop.partial is not None:
                from planter.report import results as report

                report.write_partial(out, device, stop.partial)
            raise
        if out is not None:
            from planter.report import results as report

            report.write_optimisation(out, device, found)
        console.result(found.result, lambda: tables.optimisation(console, found.result))


@app.command()
def calibrate(
    machine: MachineArgument,
    target: Annotated[str, typer.Option(help="what to fit to", show_default=False)],
    model: ModelOption = Model.printed,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Fit what a paper does not disclose to the force that it reports, and say how little that settles."""
    console = Console(as_json)
    with console.outcome():
        from planter import calibrate as calibration
        from planter import tables
        from planter.report import results as report

        device = device_of(machine, model, set_, speed_rpm)
        other = device_of(machine, next(m for m in Model if m != model), set_, speed_rpm)
        result = calibration.calibrate(device, other, target)
        if out is not None:
            report.write_result(out, device, result)
        console.result(result, lambda: tables.calibration(console, result))


@app.command()
def validate(
    machine: MachineArgument,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Check a machine file, its gears included, and do nothing else."""
    console = Console(as_json)
    with console.outcome():
        device = device_of(machine, "exact", set_, speed_rpm)
        result: dict[str, Any] = {"machine": device.machine.name, "valid": True, "design": list(device.names)}
        console.result(result, lambda: print(f"{machine}: valid, design parameters {', '.join(device.names)}"))


@app.command()
def example(
    name: Annotated[str | None, typer.Argument(help="a built-in machine", show_default=False)] = None,
    as_json: JsonOption = False,
) -> None:
    """List the built-in machines, or print one to start from."""
    console = Console(as_json)
    with console.outcome():
        if name is None:
            known = machines.built_in()
            console.result({"examples": known}, lambda: print("\n".join(known)))
        else:
            text = machines.example_text(name)
            console.result({"name": name, "text": text}, lambda: print(text, end=""))


@app.command()
def audit(
    paper: Annotated[
        str | None, typer.Argument(help="one of the papers, by its short name", show_default=False)
    ] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Verdicts on the printed equations, laws and numbers of the papers."""
    console = Console(as_json)
    with console.outcome():
        from planter import audit as trial
        from planter.audit import page, tables

        result = trial.audit(paper)
        if out is not None:
            page.write(out, result)
        console.result(result, lambda: tables.show(console, result))


def main() -> None:
    """Entry point: a call that cannot be understood ends in one sentence and exit code 2."""
    import sys

    try:
        code = app(standalone_mode=False)
    except Exception as error:
        if not hasattr(error, "format_message"):  # what the command-line library raises for bad arguments has one
            raise
        print(f"planter: {error.format_message()}", file=sys.stderr)
        code = InputError.exit_code
    sys.exit(code)
