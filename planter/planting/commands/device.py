"""Commands of the planting device."""

from __future__ import annotations

import enum
from typing import Annotated, Any

import typer

from planter.errors import Interrupted
from planter.gears.options import Module1Option, Module2Option, ModuleOption
from planter.mechanism.commands import (
    SearchOptions,
    refuse_options,
    run_optimise,
    run_sensitivity,
    run_simulate,
    run_validate,
)
from planter.planting.commands.options import (
    SamplesOption,
    WholeTeethOption,
    device_of,
    is_other,
    kept,
    load_other,
    whole_teeth,
)
from planter.report.writing import figure_files, writes
from planter.terminal.console import Console
from planter.terminal.options import (
    ClusterOption,
    HoldOption,
    JsonOption,
    LeastOption,
    MachineArgument,
    Model,
    ModelOption,
    OutOption,
    SeedOption,
    SetOption,
    SpeedOption,
    VaryOption,
    WorkersOption,
    changes,
    read_ranges,
)

FIGURES = ("joint_forces", "pitch_curves", "rotation", "support_force", "tip_path")
"""Figures of a device, by their names."""


class Method(enum.StrEnum):
    hybrid = "hybrid"
    ipopt = "ipopt"
    ga = "ga"


app = typer.Typer()

OPTIMISE = """Optimise the design within the bounds of its file.

A certificate gives the evidence that the design is optimal. With --module both stages get integer tooth numbers of a
standard module: the pitch curves then have the lengths pi m z, so that `planter gears` cuts them without scaling.
--teeth sets the tooth numbers; without it the best ones near the free optimum are searched for.

\b
    planter optimise wang2017
    planter optimise wang2017 --teeth 31,31 --module1 2 --module2 1.97 --out best
    planter optimise wang2017-wide --module 2 --method ipopt
"""


@writes("summary.json", "report.html")
def simulate(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    samples: SamplesOption = None,
    at: Annotated[
        list[float] | None, typer.Option(metavar="DEG", help="also report at this drive angle", show_default=False)
    ] = None,
    lift: Annotated[
        bool, typer.Option("--lift", help="relax assumptions one by one and report the effect of each (exact model)")
    ] = False,
    module_mm: Annotated[float, typer.Option(min=0.1, max=20, help="module of the teeth that --lift lets slide")] = 2.0,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute forces and motion of a machine over a cycle.

    For your own mechanism: every quantity, works, and a check of the laws of mechanics.
    """
    console = Console(as_json)
    with console.outcome():
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--model": model is not Model.exact, "--lift": lift})
            run_simulate(console, other, samples, at or (), out)
            return
        if out is not None:
            from planter.report.folder import check

            check(out, ["cycle.csv", *figure_files(*FIGURES)])
        from planter.planting import simulation, tables

        device = device_of(machine, model, set_, speed_rpm)
        found = simulation.simulate(device, samples, at or (), module_mm if lift else None)
        if out is not None:
            from planter.planting.report import results as report

            report.write_simulation(out, device, found)
        console.result(found.result, lambda: tables.simulation(console, found.result))


app.command()(simulate)
app.command("turn", help="Another name for `simulate`.")(simulate)


@app.command()
@writes("summary.json", "report.html")
def sensitivity(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    samples: SamplesOption = None,
    least: LeastOption = None,
    all_values: Annotated[
        bool, typer.Option("--all", help="for all values of the file, not only those of the design or with bounds")
    ] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find which design parameters the objective depends on.

    The result has its gradient, and combinations of parameters that have no effect.

    For a mechanism of your own the objective is that of its file, or --least; by true extremes unless --samples says
    a number. A value without bounds counts by its size.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.mechanism.tables import show_sensitivity

        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--model": model is not Model.exact})
            run_sensitivity(console, other, least, samples, all_values, out)
            return
        from planter.planting import simulation

        device = device_of(machine, model, set_, speed_rpm)
        result = simulation.sensitivity(device, samples, least, all_values)
        if out is not None:
            from planter.planting.report import results as report

            report.write_result(out, device, result)
        console.result(result, lambda: show_sensitivity(console, result))


@app.command(help=OPTIMISE)
@writes("summary.json", "optimum.toml", "report.html")
def optimise(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    method: Annotated[
        Method | None,
        typer.Option(
            help="genetic algorithm (ga), local searches (ipopt), or both [default: hybrid; ipopt for a mechanism of "
            "your own]",
            show_default=False,
        ),
    ] = None,
    samples: Annotated[
        str | None,
        typer.Option(
            metavar="N|refined",
            help="true extremes and integrals of the cycle, or a number of samples [default: refined]",
            show_default=False,
        ),
    ] = None,
    seed: SeedOption = 0,
    starts: Annotated[int | None, typer.Option(min=1, help="number of local searches", show_default=False)] = None,
    front: Annotated[bool, typer.Option("--front", help="also compute the Pareto front of range and variance")] = False,
    least: LeastOption = None,
    hold: HoldOption = None,
    vary: VaryOption = None,
    prove: Annotated[
        bool,
        typer.Option(
            "--prove", help="also prove a bound on how much better any design within the bounds can be, over samples"
        ),
    ] = False,
    prove_seconds: Annotated[float, typer.Option(min=0, help="time for the proof, the search excluded")] = 480,
    module: ModuleOption = None,
    module1: Module1Option = None,
    module2: Module2Option = None,
    teeth: WholeTeethOption = None,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    from planter.report.folder import check, renewing

    console = Console(as_json)
    with console.outcome(), renewing(out):
        from planter.engine.machine import load_machine
        from planter.parallel.task import Means
        from planter.planting import optimisation

        means, ranges = Means(workers, cluster), read_ranges("--vary", vary or ())
        if not (least or hold or ranges):
            other = load_other(machine, set_, speed_rpm)
        else:
            other = load_machine(machine, changes(set_), speed_rpm)
        if other is not None:
            besides = {"--model": model is not Model.exact,
                       "--teeth": teeth is not None, "--module": module is not None, "--module1": module1 is not None,
                       "--module2": module2 is not None}  # fmt: skip
            sampling = None if samples is None else optimisation.parse_sampling(samples)
            seconds = prove_seconds if prove else None
            options = SearchOptions(
                None if method is None else method.value, front, sampling, seed, starts, seconds, means, ranges
            )
            refuse_options(other, besides)
            run_optimise(console, other, least, hold or (), options, out)
            return
        method = method or Method.hybrid
        if out is not None:
            check(out, ["cycle.csv", *figure_files(*FIGURES, "convergence", *(["pareto"] if front else []))])
        from planter.planting import tables
        from planter.planting.report import results as report
        from planter.planting.whole import run

        whole = whole_teeth(module, module1, module2, teeth, {"--front": front, "--prove": prove})
        device = device_of(machine, model, set_, speed_rpm)

        def keep(so_far: dict[str, Any], interrupted: bool = False) -> None:
            if out is not None:
                report.write_partial(out, device, so_far, interrupted)

        try:
            found = run.optimise(device, whole, method.value, samples, seed, starts, console.progress, keep, means)
        except Interrupted as stop:
            if stop.partial is not None:
                keep(stop.partial, interrupted=True)
            raise
        with kept(found.result.table()):
            if out is not None:
                report.write_optimum(out, device, found)
            if front:
                found = optimisation.add_pareto_front(found, console.progress)
                if out is not None:
                    report.write_optimum(out, device, found)
            if prove:
                from planter.planting import proof

                found = proof.add_proof(found, prove_seconds, console.progress, means)
                if out is not None:
                    report.write_optimum(out, device, found)
        console.result(found.result, lambda: tables.optimisation(console, found.result))
        if out is not None:
            with Console(as_json=False).outcome(), kept(found.result.table()):
                report.draw_optimum(out, device, found)


@app.command()
def validate(
    machine: MachineArgument,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Check a machine file, and warn of unusual values.

    Values, gears, loops over the whole cycle and limits are checked.
    """
    console = Console(as_json)
    with console.outcome():
        if is_other(machine):
            run_validate(console, machine, changes(set_), speed_rpm)
            return
        device = device_of(machine, "exact", set_, speed_rpm)
        from planter.planting import simulation, tables

        result = simulation.validate(device)
        console.result(result, lambda: tables.validation(console, machine, result))
