"""Commands of the clutch: `planter design clutch NAME` for engagement, field tests and shape."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError, PlanterError
from planter.report.completion import complete_sources
from planter.report.console import Console
from planter.report.folder import renew_files
from planter.report.options import (
    JsonOption,
    OutOption,
    SeedOption,
    SetOption,
    SpeedOption,
    parse_changes,
    text_option,
    writes_files,
)

if TYPE_CHECKING:
    from planter.papers.clutch.file import ClutchFile
    from planter.papers.clutch.results import ContactEngagement, ModalEngagement


HELP = "Compute the Reuleaux-pentagon clutch and its field test."
clutch = typer.Typer(help=HELP, invoke_without_command=True, rich_markup_mode=None)
app = typer.Typer()
app.add_typer(clutch, name="clutch")

ClutchArgument = Annotated[
    str,
    typer.Argument(
        metavar="CLUTCH",
        help="a clutch file, or the name of a built-in one",
        autocompletion=complete_sources("clutch"),
    ),
]


NamesOption = list[str] | None


class EngagementMode(enum.StrEnum):
    """Model of an engagement."""

    modal = "modal"
    contact = "contact"


@clutch.callback()
def print_help(context: typer.Context) -> None:
    """Print the help if no command follows."""
    if context.invoked_subcommand is None:
        print(context.get_help())


@clutch.command(name="engage")
@writes_files("summary.json", "report.html")
def engage_clutch(
    source: ClutchArgument,
    mode: Annotated[
        EngagementMode,
        typer.Option(help="one mode of the shaft in closed form, or contact of the real profiles"),
    ] = EngagementMode.modal,
    shape: Annotated[
        str,
        text_option(
            "bending shape of the shaft: the paper's, or a clamped one (clamped-...)", "NAME"
        ),
    ] = "quarter-sine",
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute the loads while a clutch engages.

    By contact also its cut-off, and a dog clutch for comparison; this takes half a minute.

    In contact, `sensitivity` follows the largest loads over a factor of 10 in each input that the
    paper does not disclose. Shapes: quarter-sine, clamped-cosine, clamped-static, clamped-mode.
    """
    console = Console(as_json)
    with console.outcome(), renew_files(out):
        from planter.papers.clutch import contact, modal_engagement
        from planter.papers.clutch.file import load_clutch
        from planter.papers.clutch.presentation import present_engagement
        from planter.report.files import write_unfinished

        file = load_clutch(source, parse_changes(set_, {"engagement.input_speed_rpm": speed_rpm}))
        if mode is EngagementMode.modal:
            result: ModalEngagement | ContactEngagement = modal_engagement.evaluate_engagement(
                file, shape
            )
            curves = None
        else:
            keep = None if out is None else partial(write_unfinished, out, file)
            result, curves = contact.compare_clutches(
                file, shape, progress=console.progress, keep=keep
            )
        present_engagement(file, result, shape, curves).show(console, out)


@clutch.command(name="field")
@writes_files("summary.json", "report.html")
def evaluate_field(
    data: Annotated[
        str,
        typer.Argument(
            metavar="RUNS",
            help="a CSV file of runs, or the name of a built-in one",
            autocompletion=complete_sources("clutch", ".csv"),
        ),
    ] = "shi2021-field",
    goal: Annotated[
        NamesOption,
        text_option(
            "goal of a response: larger, smaller, zero, or a number for a target value "
            "[default: zero, for the paper's own table alone]",
            "NAME=GOAL",
        ),
    ] = None,
    comparison: Annotated[
        str | None,
        text_option(
            "CSV file clutch,speed_m_s,measure,mean,sd,n of clutches to compare [default: "
            "paper's, for its runs]",
            "FILE",
        ),
    ] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Evaluate a field test: ranges, variance, best levels.

    Columns of the file: `run` counts the runs; `blank`, `empty` or `error` is a column of the array
    that no factor is assigned to; `Y`, `Y1`, `Y2_cm`, ... are responses; every other column is a
    factor. Levels must form an orthogonal array, as those of `planter design clutch plan`.

    Best are the levels whose prediction comes closest to the goal of a response; for all responses
    together, those with the best mean rank: --goal Y1=larger --goal Y2=smaller.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.clutch.field import evaluate_field
        from planter.papers.clutch.presentation import present_field_test

        goals = parse_pairs("--goal", goal or ())
        present_field_test(evaluate_field(data, goals, comparison)).show(console, out)


def parse_pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Return values by name from texts NAME=VALUE. Raises InputError for others, or two of a name."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.rpartition("="))
        if not (equals and name and value) or name in values:
            raise InputError(f"{option} {text}: it must be NAME=VALUE, once for each NAME")
        values[name] = value
    return values


@clutch.command(name="plan")
@writes_files("plan.csv")
def plan_field(
    array: Annotated[str, typer.Argument(metavar="ARRAY", help="L4, L8, L9, L25 or L27")],
    factor: Annotated[
        NamesOption,
        text_option("a factor and its levels (repeatable) [default: A, B, ...]", "NAME=LEVEL,..."),
    ] = None,
    response: Annotated[
        NamesOption, text_option("a column to be measured (repeatable) [default: Y1]", "NAME")
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="random seed, which shuffles the runs"),
    ] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Plan a field test on an orthogonal array.

    The plan is a CSV file to fill in, which `planter design clutch field` reads back.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.clutch import field

        planned = field.plan_field(array, factor or (), response or (), seed)
        if out is not None:
            from planter.report import files

            files.write_text(files.output_folder(out) / "plan.csv", planned.text)
        console.result(planned, lambda: print(planned.text, end=""))


@clutch.command(name="geometry")
@writes_files(
    "summary.json",
    "poses.csv",
    "report.html",
    figures=("linkage", "travel", "turning", "vertex_path"),
)
def show_geometry(
    source: ClutchArgument,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute polygon, hexagon, teeth and linkage of a clutch.

    Numbers that its paper prints are listed for comparison.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.clutch import model as shape
        from planter.papers.clutch.presentation import present_geometry

        clutch_file = _load_file(source, set_)
        result = shape.compute_geometry(clutch_file)
        present_geometry(clutch_file, result).show(console, out)


@clutch.command(name="design")
@writes_files(
    "summary.json", "way.csv", "report.html", figures=("linkage", "turning", "vertex_path")
)
def size_clutch(
    source: ClutchArgument,
    shaft_mm: Annotated[float | None, typer.Option(help="distance of the shaft's flats")] = None,
    travel_mm: Annotated[float | None, typer.Option(help="required travel of the sleeve")] = None,
    radius_mm: Annotated[float | None, typer.Option(help="available space across the axis")] = None,
    length_mm: Annotated[float | None, typer.Option(help="available space along the axis")] = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Size a clutch for a shaft, a space and a travel.

    Every inequality is checked, and active ones are named.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.clutch import file, sizing
        from planter.papers.clutch.presentation import present_design

        targets = {
            "shaft.flat_to_flat_mm": shaft_mm,
            "wanted.wanted_travel_mm": travel_mm,
            "wanted.space_radius_mm": radius_mm,
            "wanted.space_length_mm": length_mm,
        }
        clutch_file = file.load_clutch(source, parse_changes(set_, targets))
        result = sizing.size_clutch(clutch_file)
        presentation = present_design(clutch_file, result)
        if not result.feasible:
            if out is not None:
                presentation.write(out)
            raise sizing.build_refusal(result)
        presentation.show(console, out)


@clutch.command(name="optimise")
@writes_files("summary.json", "report.html")
def optimise_clutch(
    source: ClutchArgument,
    seed: SeedOption = 0,
    starts: Annotated[int, typer.Option(min=1, max=1000, help="number of local searches")] = 8,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Minimise the travel time of a clutch.

    Axial angle, gear ratio and linkage vary within what forces and space allow.
    """
    console = Console(as_json)
    with console.outcome(), renew_files(out):
        from planter.papers.clutch import sizing
        from planter.papers.clutch.presentation import present_optimisation
        from planter.report.files import write_unfinished

        clutch_file = _load_file(source, set_)
        try:
            result = sizing.optimise_clutch(clutch_file, seed, starts)
        except PlanterError as error:
            if out is not None and error.partial is not None:
                write_unfinished(out, clutch_file, error.partial)
            raise
        present_optimisation(clutch_file, result).show(console, out)


@clutch.command(name="rotor")
@writes_files("summary.json", "report.html", figures=("turning",))
def summarise_rotor(
    vertices: Annotated[int, typer.Option(help="vertices of the Reuleaux polygon, odd")] = 5,
    sides: Annotated[int, typer.Option(help="sides of the regular polygon")] = 6,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Turn an odd Reuleaux polygon in a regular polygon.

    Lengths are in widths of the Reuleaux polygon.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.clutch.presentation import present_rotor
        from planter.papers.clutch.rotor import Rotor, summarise_rotor

        pair = Rotor(vertices, sides)
        result = summarise_rotor(pair)
        present_rotor(pair, result).show(console, out)


def _load_file(source: str, set_: Sequence[str] | None) -> ClutchFile:
    from planter.papers.clutch import file

    return file.load_clutch(source, parse_changes(set_))
