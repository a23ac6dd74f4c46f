"""Commands of sweeps and tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from planter.errors import InputError
from planter.report.completion import complete_files
from planter.report.console import Console
from planter.report.options import (
    ClusterOption,
    HoldOption,
    JsonOption,
    LeastOption,
    MachineArgument,
    OutOption,
    SeedOption,
    SetOption,
    VaryOption,
    WorkersOption,
    parse_changes,
    read_ranges,
    refuse_unused,
    text_option,
    writes_files,
)

app = typer.Typer()

SWEEP_HELP = """Evaluate a machine over ranges of its inputs.

The result has a table of rows, the envelope of every output, and maps.

PLAN is a TOML file:

\b
    machine = "wang2017"            # a file or a built-in name, or a list of them
    scheme = "grid"                 # grid, sobol or latin
    outputs = ["support_range_N", "M_L_max_Nm"]
    [inputs]
    model = ["exact", "printed"]
    speed_rpm = { from = 35, to = 45, steps = 11 }
    "mass.planet_kg" = [1.1, 1.2, 1.3]

The schemes sobol and latin need `points`, and may have a `seed`; their ranges have no steps. `[[map]]` tables with
x, y and output choose the maps that are drawn. --list MACHINE lists all inputs and outputs.

Rows are computed in chunks of 10000. With --out finished chunks are saved: run the same command again to resume.
Results are the same for any number of workers. From 20000 rows on, all cores are used.

\b
    planter new sweep plan.toml
    planter sweep plan.toml --out run
    planter sweep plan.toml --cluster tcp://host:8786
"""


@app.command(help=SWEEP_HELP)
@writes_files("summary.json", "rows.csv", "rows.parquet", "report.html")
def sweep(
    plan: Annotated[
        Path | None,
        typer.Argument(
            metavar="PLAN", help="a plan (TOML)", autocompletion=complete_files(".toml")
        ),
    ] = None,
    listed: Annotated[
        str | None,
        typer.Option("--list", metavar="MACHINE", help="list the inputs and outputs of a machine"),
    ] = None,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    console = Console(as_json)
    with console.outcome():
        from planter.rows.points import load_plan
        from planter.rows.sweep import PARQUET_HINT, has_parquet
        from planter.rows.sweep_presentation import compute_sweep, list_inputs, present_inputs
        from planter.task import Means

        if (plan is None) == (listed is None):
            raise InputError("name either a PLAN or --list MACHINE")
        if listed is not None:
            refuse_unused("with --list", "--workers", "--cluster", "--out")
            present_inputs(list_inputs(listed)).show(console)
            return
        assert plan is not None
        presentation = compute_sweep(
            load_plan(plan), out, Means(workers, cluster), console.progress
        )
        if out is not None and not has_parquet():
            console.say(PARQUET_HINT)
        presentation.show(console)


TOLERANCE_HELP = """Compute how tolerances spread a machine's results.

The result has bands, the inputs that matter, what half of each tolerance buys, and a robust design. Bands are those of
machines with random values within the tolerances (Monte Carlo). Sobol' indices give the share of an output's variance
that each input causes. First-order bands from exact gradients are given for comparison. The robust design minimises
mean + SIGMAS x standard deviation of the objective. Without --tolerances default ones are assumed. FILE is TOML:

\b
    [tolerances]
    "mass.*" = { percent = 2 }                        # normal, ends at 3 sigma
    "planet_xy_mm[0]" = { plus_minus = 0.5, distribution = "triangular" }
    speed_rpm = { from = 35, to = 45 }                # uniform
    "deviation.*" = { plus_minus = 0.05 }             # centre distances

Names are those of --set, or patterns; of several that match, the last counts. `planter sweep --list MACHINE`
lists all inputs and outputs. With --out finished work is saved: run the same command again to resume.

\b
    planter new tolerances tolerances.toml
    planter tolerance wang2017 --out run
    planter tolerance wang2017 --tolerances tolerances.toml --sigmas 2
    planter tolerance slider_crank.toml --tolerances t.toml --least "rms M_in" --vary values.r_mm=40:60
    planter tolerance wang2017 --output support_range_N --samples 1000000 --indices 0 --no-robust
"""


@app.command(help=TOLERANCE_HELP)
@writes_files("summary.json", "tolerances.toml", "report.html")
def tolerance(
    machine: MachineArgument,
    tolerances: Annotated[Path | None, text_option("tolerances (TOML)", "FILE")] = None,
    output: Annotated[
        list[str] | None,
        text_option('output to analyse, or a measure such as "jump F_Ox" (repeatable)', "NAME"),
    ] = None,
    choose: Annotated[
        list[str] | None,
        text_option("value of an input with texts, such as model=printed", "NAME=TEXT"),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(
            min=100,
            max=100_000_000,
            help="number of random machines [default: 100000; 2000 of what moves freely]",
        ),
    ] = None,
    indices: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=2**20,
            help="number of points of the Sobol' indices, a power of 2; 0: no indices [default: "
            "2048; 128 of what moves freely]",
        ),
    ] = None,
    halved: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=100_000,
            help="number of machines to see what half of each tolerance would buy; 0: do not "
            "[default: 512; 64 of what moves freely]",
        ),
    ] = None,
    robust: Annotated[
        bool, typer.Option("--robust/--no-robust", help="also find the robust design")
    ] = True,
    least: LeastOption = None,
    hold: HoldOption = None,
    vary: VaryOption = None,
    sigmas: Annotated[
        float, typer.Option(min=0, max=10, help="number of standard deviations added to the mean")
    ] = 3,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    seed: SeedOption = 0,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    console = Console(as_json)
    with console.outcome():
        from planter.report.folder import renew_files
        from planter.rows.adapter import ResolvedMachine
        from planter.rows.robust import Settings
        from planter.rows.tolerance_analysis import (
            ToleranceRequest,
            Tolerances,
            analyse_tolerances,
            default_tolerances,
            list_counts,
        )
        from planter.rows.tolerance_presentation import present_tolerance
        from planter.task import Means

        if not robust:
            refuse_unused("with --no-robust", "--sigmas")
        resolved = ResolvedMachine(machine, parse_changes(set_))
        defaults, machines = list_counts(resolved)
        ranges, holds = read_ranges("--vary", vary or ()), tuple(hold or ())
        settings = Settings(sigmas, machines, seed=seed, sum_text=least, holds=holds, ranges=ranges)
        if settings.is_stated and not robust:
            raise InputError("--least, --hold and --vary set the robust design; remove --no-robust")
        counts = dict(zip(("rows", "base", "halved"), (samples, indices, halved), strict=True))
        stated = {name: count for name, count in counts.items() if count is not None}
        request = ToleranceRequest(
            output or (), seed=seed, robust=settings if robust else None, **defaults | stated
        )
        limits = default_tolerances(resolved) if tolerances is None else Tolerances.load(tolerances)
        source = str(tolerances) if tolerances is not None else f"{machine}: default tolerances"
        with renew_files(out):
            choices = _parse_choices(resolved.adapter.choices, choose or ())
            analysis = analyse_tolerances(
                resolved,
                choices,
                limits,
                source,
                request,
                out,
                Means(workers, cluster),
                console.progress,
            )
            presentation = present_tolerance(analysis)
            if out is not None:
                presentation.write(out, console.progress)
        presentation.show(console)


def _parse_choices(allowed: Mapping[str, Sequence[str]], options: Sequence[str]) -> dict[str, str]:
    """Return the values of inputs with texts, by default the first allowed one.

    Raises InputError for other values.
    """
    choices = {name: texts[0] for name, texts in allowed.items()}
    for option in options:
        name, _, text = option.partition("=")
        if text not in allowed.get(name, ()):
            hint = " or ".join(
                f"{name}={text}" for name, texts in allowed.items() for text in texts
            )
            raise InputError(f"--choose {option}: {f'it must be {hint}' if hint else 'remove it'}")
        choices[name] = text
    return choices
