"""`planter optimise`: the best design, and the best gear families."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter.errors import Interrupted
from planter.gears.commands import Module1Option, Module2Option, ModuleOption
from planter.mechanism.commands import SearchOptions, refuse_options, run_optimise
from planter.papers.planting.commands.options import (
    FIGURES,
    build_device,
    load_device_file,
    load_other,
    parse_tooth_counts,
    states_measures,
)
from planter.report.console import Console
from planter.report.options import (
    ClusterOption,
    HoldOption,
    JsonOption,
    LeastOption,
    MachineArgument,
    ModelName,
    ModelOption,
    OutOption,
    SeedOption,
    SetOption,
    SpeedOption,
    VaryOption,
    WorkersOption,
    figure_files,
    find_proof,
    interruptible_result,
    list_allowed,
    parse_changes,
    read_ranges,
    refuse_unused,
    text_option,
    writes_files,
)

if TYPE_CHECKING:
    from pathlib import Path

    from planter.papers.planting.file import PlantingMachine
    from planter.papers.planting.optimisation import Optimisation
    from planter.report.presentation import ResultPresentation

app = typer.Typer()


class Method(enum.StrEnum):
    """Methods of the search for the optimum."""

    auto = "auto"
    hybrid = "hybrid"
    ipopt = "ipopt"
    ga = "ga"


OPTIMISE = """Optimise the design within the bounds of its file.

A certificate gives the evidence that the design is optimal. With --module both stages get integer tooth numbers of a
standard module: the pitch curves then have the lengths pi m z, so that `planter gears` cuts them without scaling.
--teeth sets the tooth numbers; without it the best ones near the free optimum are searched for. With --all-pairs
every pair of gear families has the same wide bounds and the machine's requirements.

\b
    planter optimise wang2017
    planter optimise wang2017 --teeth 31,31 --module1 2 --module2 1.97 --out best
    planter optimise wang2017-wide --module 2 --method ipopt
    planter optimise wang2017-wide --all-pairs --out pairs
"""


def _list_families() -> Iterable[str]:
    from planter.gears.geometry import families

    return families.list_families()


ALL_PAIRS = "Pairs of gear families, with --all-pairs"
"""Section of options in the help."""
SINGLE_OPTIONS = (
    "--model",
    "--method",
    "--samples",
    "--front",
    "--least",
    "--hold",
    "--vary",
    "--prove",
    "--prove-seconds",
    "--module",
    "--module1",
    "--module2",
    "--teeth",
)
"""Options of the search for one optimum, which the comparison of pairs does not take."""
PAIR_STARTS = 3
"""Local searches for each pair of gear families."""


@app.command(help=OPTIMISE, cls=list_allowed(pair=_list_families))
@writes_files("summary.json", "report.html")
def optimise(
    machine: MachineArgument,
    model: ModelOption = ModelName.exact,
    method: Annotated[
        Method | None,
        typer.Option(
            help="genetic algorithm (ga), local searches (ipopt), or both (hybrid) [default: auto, "
            "local searches, and the genetic algorithm where these disagree]"
        ),
    ] = None,
    samples: Annotated[
        str | None,
        text_option(
            "true extremes and integrals of the cycle, or a number of samples [default: refined]",
            "N|refined",
        ),
    ] = None,
    seed: SeedOption = 0,
    starts: Annotated[
        int | None,
        typer.Option(min=1, help="number of local searches [default: 8; 3 with --all-pairs]"),
    ] = None,
    front: Annotated[
        bool, typer.Option("--front", help="also compute the Pareto front of range and variance")
    ] = False,
    least: LeastOption = None,
    hold: HoldOption = None,
    vary: VaryOption = None,
    prove: Annotated[
        bool,
        typer.Option(
            "--prove",
            help="also prove a bound on how much better any design within the bounds can be",
        ),
    ] = False,
    prove_seconds: Annotated[
        float, typer.Option(min=0, help="CPU time for the proof, the search excluded [s]")
    ] = 480,
    module: ModuleOption = None,
    module1: Module1Option = None,
    module2: Module2Option = None,
    teeth: Annotated[
        str | None,
        text_option(
            "teeth of the inner gears of stage 1 and of stage 2, with a module [default: the best "
            "whole numbers near "
            "the free optimum]",
            "Z1,Z2",
        ),
    ] = None,
    all_pairs: Annotated[
        bool,
        typer.Option(
            "--all-pairs",
            help="optimise every pair of gear families within the same wide bounds and rank them",
            rich_help_panel=ALL_PAIRS,
        ),
    ] = False,
    pair: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FAMILY+FAMILY",
            help="only this pair (repeatable), of families",
            rich_help_panel=ALL_PAIRS,
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="continue with the results in the folder of --out",
            rich_help_panel=ALL_PAIRS,
        ),
    ] = False,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    from planter.report.folder import check_files, drop_file, renew_files

    console = Console(as_json)
    with console.outcome(), renew_files(out):
        if all_pairs:
            refuse_unused("with --all-pairs", *SINGLE_OPTIONS)
            if out is not None:
                check_files(out, ["devices.csv", *figure_files("comparison")])
            content = load_device_file(machine, set_, speed_rpm)
            search = PairSearch(starts or PAIR_STARTS, seed, resume, pair, workers, cluster)
            _compare_pairs(console, content, search, out)
            return
        refuse_unused("without --all-pairs", "--pair", "--resume")
        if out is not None:
            check_files(out, ["optimum.toml"])
        from planter.engine.machine import load_driven_machine
        from planter.papers.planting import optimisation
        from planter.task import Means

        if not prove:
            refuse_unused("without --prove", "--prove-seconds")
        means, ranges = Means(workers, cluster), read_ranges("--vary", vary or ())
        other = load_other(machine, set_, speed_rpm)
        if other is None and (least or hold or ranges or states_measures(machine)):
            other = load_driven_machine(machine, parse_changes(set_), speed_rpm)
        if other is not None:
            sampling = None if samples is None else optimisation.parse_sampling(samples)
            seconds = prove_seconds if prove else None
            options = SearchOptions(
                None if method is None else method.value,
                front,
                sampling,
                seed,
                starts,
                seconds,
                means,
                ranges,
            )
            teeth_options = {
                "--teeth": teeth,
                "--module": module,
                "--module1": module1,
                "--module2": module2,
            }
            present = {option: value is not None for option, value in teeth_options.items()}
            refuse_options(other, {"--model": model is not ModelName.exact, **present})
            run_optimise(console, other, least, hold or (), options, out)
            return
        method = method or Method.auto
        if out is not None:
            check_files(
                out,
                [
                    "cycle.csv",
                    *figure_files(*FIGURES),
                ],
            )
        from planter.mechanism.presentation import CLOSEST_FILE
        from planter.papers.planting.design_presentation import present_optimum, write_partial
        from planter.papers.planting.requirements import InfeasibleRequirementsError
        from planter.papers.planting.tooth_count_search import optimise_with_tooth_counts

        spec = parse_tooth_counts(
            module, module1, module2, teeth, {"--front": front, "--prove": prove}
        )
        device = build_device(machine, model, set_, speed_rpm)

        def save(partial: dict[str, Any], interrupted: bool = False) -> None:
            if out is not None:
                write_partial(out, device, partial, interrupted)

        try:
            optimum = optimise_with_tooth_counts(
                device, spec, method.value, samples, seed, starts, console.progress, save, means
            )
        except Interrupted as stop:
            if stop.partial is not None:
                save(stop.partial, interrupted=True)
            raise
        except InfeasibleRequirementsError as error:
            save({**error.partial, "met": False})
            raise
        if out is not None:
            drop_file(out / CLOSEST_FILE)

        def present_and_write(optimum: Optimisation) -> ResultPresentation:
            presentation = present_optimum(optimum, device)
            if out is not None:
                presentation.write_data(out)
            return presentation

        with interruptible_result(optimum.result.table()):
            presentation = present_and_write(optimum)
            if front:
                optimum = optimisation.add_pareto_front(optimum, console.progress)
                presentation = present_and_write(optimum)
            if prove:
                from planter.papers.planting import proof

                earlier, keep = find_proof(out)
                optimum = proof.add_proof(
                    optimum, prove_seconds, console.progress, means, earlier, keep
                )
                presentation = present_and_write(optimum)
        presentation.show(console)
        if out is not None:
            with Console(as_json=False).outcome(), interruptible_result(optimum.result.table()):
                presentation.write(out, console.progress)


@dataclass(frozen=True)
class PairSearch:
    """Options of the comparison of pairs: local searches for each, seed, whether results in the
    folder are continued, pairs (None: all), processes, and the address of a cluster.
    """

    starts: int
    seed: int
    resume: bool
    pairs: list[str] | None
    workers: int | None
    cluster: str | None


def _compare_pairs(
    console: Console, machine: PlantingMachine, search: PairSearch, out: Path | None
) -> None:
    """Optimise pairs of gear families, print their ranks, and write them into a folder if one is
    named.
    """
    from planter.papers.planting.family_comparison import compare_families
    from planter.papers.planting.family_pairs import parse_pairs
    from planter.papers.planting.presentation import present_comparison

    result = compare_families(
        machine,
        search.starts,
        search.seed,
        out,
        search.resume,
        parse_pairs(search.pairs),
        console.progress,
        search.workers,
        search.cluster,
    )
    presentation = present_comparison(result, machine)
    if out is not None:
        with interruptible_result(result.table()):
            presentation.write(out, console.progress)
    presentation.show(console)
