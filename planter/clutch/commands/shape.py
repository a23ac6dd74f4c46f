"""Commands of the clutch's shape: geometry, sizing, fastest switching, and rotors in general."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from planter.clutch.commands.group import ClutchArgument, clutch
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SeedOption, SetOption, changes

if TYPE_CHECKING:
    from planter.clutch.file import Clutch


def clutch_of(source: str, set_: Sequence[str] | None) -> Clutch:
    from planter.clutch import file

    return file.load(source, changes(set_))


@clutch.command()
@writes(
    "summary.json", "poses.csv", "turning.gif", "report.html", figures=("linkage", "travel", "turning", "vertex_path")
)
def geometry(
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
        from planter.clutch import geometry as shape
        from planter.clutch import tables

        found = clutch_of(source, set_)
        result = shape.geometry(found)
        if out is not None:
            from planter.clutch.report import shape as report

            report.write_geometry(out, found, result)
        console.result(result, lambda: tables.geometry(console, result))


@clutch.command()
@writes("summary.json", "way.csv", "report.html", figures=("linkage", "turning", "vertex_path"))
def design(
    source: ClutchArgument,
    shaft_mm: Annotated[float | None, typer.Option(help="distance of the shaft's flats", show_default=False)] = None,
    travel_mm: Annotated[float | None, typer.Option(help="required travel of the sleeve", show_default=False)] = None,
    radius_mm: Annotated[float | None, typer.Option(help="available space across the axis", show_default=False)] = None,
    length_mm: Annotated[float | None, typer.Option(help="available space along the axis", show_default=False)] = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Size a clutch for a shaft, a space and a travel.

    Every inequality is checked, and active ones are named.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.clutch import design as sizing
        from planter.clutch import file, tables

        wanted = {
            "shaft.flat_to_flat_mm": shaft_mm,
            "wanted.wanted_travel_mm": travel_mm,
            "wanted.space_radius_mm": radius_mm,
            "wanted.space_length_mm": length_mm,
        }
        found = file.load(source, changes(set_, wanted))
        result = sizing.design(found)
        if out is not None:
            from planter.clutch.report import shape as report

            report.write_design(out, found, result)
        if not result.feasible:
            raise sizing.refusal(result)
        console.result(result, lambda: tables.design(console, result))


@clutch.command()
@writes("summary.json", "report.html")
def optimise(
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
    with console.outcome():
        from planter.clutch import optimise as search
        from planter.clutch import tables

        found = clutch_of(source, set_)
        result = search.optimise(found, seed, starts)
        if out is not None:
            from planter.clutch.report import shape as report

            report.write_optimisation(out, found, result)
        console.result(result, lambda: tables.optimisation(console, result))


@clutch.command()
@writes("summary.json", "turning.gif", "report.html", figures=("turning",))
def rotor(
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
        from planter.clutch import tables
        from planter.clutch.rotor import Rotor, summary

        found = Rotor(vertices, sides)
        result = summary(found)
        if out is not None:
            from planter.clutch.report import shape as report

            report.write_rotor(out, found, result)
        console.result(result, lambda: tables.rotor(console, result))
