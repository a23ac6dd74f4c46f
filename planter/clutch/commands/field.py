"""Commands of the clutch's field test: its evaluation, and plans for new ones."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.clutch.commands.group import clutch
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption

NamesOption = list[str] | None


@clutch.command(name="field")
@writes("summary.json", "report.html")
def evaluate_field(
    data: Annotated[str, typer.Argument(help="a CSV file of runs, or the name of a built-in one")] = "shi2021-field",
    response: Annotated[
        NamesOption, typer.Option(metavar="NAME", help="this column is a response", show_default=False)
    ] = None,
    blank: Annotated[
        NamesOption,
        typer.Option(metavar="NAME", help="this column of the array has no factor (error)", show_default=False),
    ] = None,
    ignore: Annotated[NamesOption, typer.Option(metavar="NAME", help="ignore this column", show_default=False)] = None,
    goal: Annotated[
        NamesOption,
        typer.Option(
            metavar="NAME=GOAL",
            help="goal of a response: larger, smaller, zero, or a number for a target value; one for each "
            "response [default: zero, for the paper's own table alone]",
            show_default=False,
        ),
    ] = None,
    comparison: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="CSV file clutch,speed_m_s,measure,mean,sd,n of clutches to compare [default: paper's, for its runs]",
            show_default=False,
        ),
    ] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Evaluate a field test: effects, variance, best levels.

    The result has range analysis, analysis of variance, predictions and comparisons of clutches.

    The header says what a column is: `run` counts the runs; `blank`, `empty` or `error` is a column of the array that
    no factor is assigned to; `Y`, `Y1`, `Y2_cm`, ... are responses; every other column is a factor, whose levels are
    all numbers or all words. Comments above the header, `# factor A: axial angle / deg = 10, 15, 20` and
    `# response Y1: lag / cm`, carry meanings into figures and report.

    Best are the levels whose prediction comes closest to the goal of a response; for all responses together, those
    with the best mean rank. A table of your own needs a goal for each response: --goal Y1=larger --goal Y2=smaller.

    Levels in the results are those of the file. Designs that are not orthogonal have no range analysis (null), and
    their sums of squares are of type II: each factor over all others.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.clutch.field import Columns, evaluate, goals, tables

        columns = Columns(tuple(response or ()), tuple(blank or ()), tuple(ignore or ()))
        found = evaluate(data, columns, comparison, goals.asked(goal or ()))
        if out is not None:
            from planter.clutch.field import page

            page.write(out, found, console.progress)
        console.result(found.result, lambda: tables.show(console, found.result))


@clutch.command(name="plan")
@writes("plan.csv")
def plan_field(
    array: Annotated[str, typer.Argument(help="L4, L8, L9, L18, L25 or L27", show_default=False)],
    factor: Annotated[
        NamesOption,
        typer.Option(metavar="NAME=LEVEL,...", help="a factor and its levels [default: A, B, ...]", show_default=False),
    ] = None,
    response: Annotated[
        NamesOption, typer.Option(metavar="NAME", help="a column to be measured [default: Y1]", show_default=False)
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="shuffle the runs by this seed", show_default=False)] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Plan a field test on an orthogonal array.

    The plan is a CSV file to fill in, which `planter clutch field` reads back.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.clutch.field import plans

        wanted = [plans.Wanted.of(text) for text in factor or ()]
        planned = plans.plan(array, wanted, response or ["Y1"], seed)
        if out is not None:
            from planter.report import files

            files.write_text(files.output_folder(out) / "plan.csv", planned.text)
        console.result(planned, lambda: print(planned.text, end=""))
