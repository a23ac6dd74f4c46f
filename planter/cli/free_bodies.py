"""The presentation of free-body diagrams: a figure and a table of the loads of every body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planter.cli.results import BodyLoadFound, FreeBodiesFound, FreeBodyFound
from planter.errors import InputError
from planter.files.examples import load_part
from planter.report.free_body import BodyLoad, FreeBodies, FreeBody
from planter.report.html import Block, KeyFigure, Section, Table, Text
from planter.report.labels import clean_zero, count_things
from planter.report.presentation import PlacedFigure, ResultPresentation
from planter.report.sheet import draw_figure

HEAD = ("load", "by", "at", "x / mm", "y / mm", "Fx / N", "Fy / N", "Fz / N", "Mz / (N m)")
DALEMBERT = (
    "Weights and inertia forces (d'Alembert) are among the loads, so that those of a body are in "
    "equilibrium. Axes are those of the world."
)
SMALL = 1e-12
"""Share of the largest load of a body below which a component is rounding."""


def cut_bodies(source: str, changes: Mapping[str, float], angle_deg: float) -> FreeBodies:
    """Return the bodies of a machine, cut free at an angle of its drive.

    Raises InputError if its kind has no bodies, and as its package does.
    """
    module = load_part(source, "labelled")
    if module is None or not hasattr(module, "cut_bodies"):
        raise InputError(f"--bodies: {source}: this kind of machine is not stated by its bodies")
    bodies: FreeBodies = module.cut_bodies(source, changes, angle_deg)
    return bodies


def present_bodies(cut: FreeBodies, is_written: bool) -> ResultPresentation:
    """Return the presentation of free bodies: a diagram, a table and the sums of each."""
    sheets = {body.name: cut.draw_sheet(body) for body in cut.bodies}
    drawings = [
        f"figures/{sheet.name}.{kind}" for sheet in sheets.values() for kind in ("svg", "png")
    ]
    files = ["report.html", "summary.json", *drawings]
    largest = max(cut.bodies, key=lambda body: body.largest_force)
    error = max(_find_error(body) for body in cut.bodies)
    loads = sum(len(body.loads) for body in cut.bodies)
    return ResultPresentation(
        title=f"Bodies of {cut.machine}, cut free at {cut.angle_deg:g} deg",
        conclusion=f"{count_things(len(cut.bodies), 'body', 'bodies')} with "
        f"{count_things(loads, 'load')}; the largest force is {largest.largest_force:.4g} N, on "
        f"{largest.name}. The loads of each body add up to zero within {error:.1g} of its largest.",
        key_figures=[
            KeyFigure(f"{body.largest_force:.4g}", "N", f"largest force on {body.name}")
            for body in sorted(cut.bodies, key=lambda body: -body.largest_force)[:3]
        ],
        record=_record(cut, files if is_written else []),
        sections=list(_list_sections(cut, {name: sheet.name for name, sheet in sheets.items()})),
        figures=lambda: {sheet.name: draw_figure(sheet) for sheet in sheets.values()},
        captions={sheet.name: sheet.title for sheet in sheets.values()},
    )


def _find_error(body: FreeBody) -> float:
    """Return the size of the sums of the loads of a body as a share of the largest."""
    shares = (
        (abs(body.force_sum).max(), body.largest_force),
        (abs(body.moment_sum).max(), body.largest_moment),
    )
    return max(float(total) / size for total, size in shares if size)


def _list_sections(cut: FreeBodies, figures: Mapping[str, str]) -> Iterator[Section]:
    for body in cut.bodies:
        rows = [*(_list_cells(body, load) for load in body.loads), _list_sums(body)]
        blocks: list[Block] = [PlacedFigure(figures[body.name]), Table(HEAD, rows)]
        yield Section(f"{body.name[:1].upper()}{body.name[1:]}", blocks)
    yield Section("What is drawn", [Text(DALEMBERT, "note")], detail=True)


def _list_cells(body: FreeBody, load: BodyLoad) -> tuple[str | float | None, ...]:
    x, y, _ = (1e3 * load.place).tolist()
    forces = [_round(value, body.largest_force) for value in load.force.tolist()]
    moment = _round(float(load.moment[2]), body.largest_moment)
    return (load.name, load.by or None, load.point, x, y, *forces, moment)


def _list_sums(body: FreeBody) -> tuple[str | float | None, ...]:
    forces = [_round(value, body.largest_force) for value in body.force_sum.tolist()]
    moment = _round(float(body.moment_sum[2]), body.largest_moment)
    return ("sum, moments about the first point", None, None, None, None, *forces, moment)


def _round(value: float, size: float) -> float:
    """Return a component to five digits, or zero if it is rounding."""
    return clean_zero(0.0 if abs(value) <= SMALL * size else float(f"{value:.5g}"))


def _record(cut: FreeBodies, files: list[str]) -> FreeBodiesFound:
    bodies = [
        FreeBodyFound(
            name=body.name,
            loads=[
                BodyLoadFound(
                    load.name,
                    load.by or None,
                    load.point,
                    (1e3 * load.place).tolist(),
                    load.force.tolist(),
                    load.moment.tolist(),
                )
                for load in body.loads
            ],
            force_sum_N=body.force_sum.tolist(),
            moment_sum_Nm=body.moment_sum.tolist(),
        )
        for body in cut.bodies
    ]
    return FreeBodiesFound(cut.machine, cut.angle_deg, bodies, files)
