"""The presentation of a measured path laid over that of a machine: distances, placement, figure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from planter.measured.findings import FramePlacement, PathFound
from planter.measured.path_comparison import PathComparison
from planter.measured.presentation import (
    MOST_DRAWN,
    build_fitted_section,
    list_correlation_sections,
    list_data_sections,
    list_fitted_figures,
    write_machine,
)
from planter.report import files, style
from planter.report.html import KeyFigure, Keys, Section
from planter.report.labels import tabulate_records
from planter.report.presentation import (
    MOST_KEY_FIGURES,
    ResultPresentation,
    list_warning_sections,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.document import Document
    from planter.kernels import Array

PATH_CAPTION = (
    "Measured points over the computed path, with lines to their nearest points on it, and the "
    "distances along the path, positive on its left."
)
MINUS = "\N{MINUS SIGN}"


def present_path(
    document: Document, compared: PathComparison, meanings: Mapping[str, str]
) -> ResultPresentation:
    """Return the presentation of a measured path: distances, placement, fitted inputs.

    `meanings` are those of the numbers of the file by path.
    """
    result = compared.result
    return ResultPresentation(
        title=f"{document.name}, path compared with measured points",
        conclusion=f"{result.statement}.",
        key_figures=_list_key_figures(result),
        record=result,
        sections=list(_list_sections(result)),
        document=document,
        meanings=meanings,
        figures=lambda: {"path": draw_path(compared)},
        captions={"path": PATH_CAPTION},
        tables=lambda: {"distances.csv": tabulate_distances(compared)},
        comments=files.list_comments(document, "machine"),
        texts=lambda: write_machine(compared.machine, result, f"{result.points} points of a path"),
    )


def _list_key_figures(result: PathFound) -> list[KeyFigure]:
    largest = f"{result.largest.distance_mm:.3g}".replace("-", MINUS)
    figures = [
        KeyFigure(f"{result.rms_mm:.3g}", "mm", "RMS distance from the path"),
        KeyFigure(largest, "mm", f"largest distance, at {result.largest.phi_deg:.4g} deg"),
    ]
    return [*figures, *list_fitted_figures(result.fitted)][:MOST_KEY_FIGURES]


def _list_sections(result: PathFound) -> Iterator[Section]:
    yield from list_warning_sections(result.warnings)
    x, y = result.quantity
    worst = result.largest
    distances = Keys(
        {
            "points": result.points,
            "rms / mm": result.rms_mm,
            "mean / mm": result.mean_mm,
            "largest / mm": worst.distance_mm,
            "largest at / deg": worst.phi_deg,
            "largest along the path at / mm": worst.arc_mm,
            "length of the path / mm": result.length_mm,
        }
    )
    yield Section(f"Distances from the path of {x}, {y}", [distances])
    placement: dict[str, str | Callable[[FramePlacement], str]] = {
        "rotation / deg": "rotation_deg",
        "x / mm": "x_mm",
        "y / mm": "y_mm",
        "fitted": lambda each: ", ".join(each.fitted) or "nothing",
    }
    table = tabulate_records([result.placement], placement)
    yield Section("Measured frame in that of the machine", [table])
    if (fit := result.fit) is not None:
        yield build_fitted_section(result.fitted, fit.noise)
        columns = {
            "outcome": "outcome",
            "p": "lack_of_fit.probability",
            "starts": "starts",
            "agree": "agreeing_starts",
            "rank": "rank",
        }
        yield Section("Fit", [tabulate_records([fit], columns)])
        yield from list_correlation_sections(fit)
    yield from list_data_sections(result.reading, result.treatment)


def tabulate_distances(compared: PathComparison) -> dict[str, Array]:
    """Return the points in the frame of the machine, their nearest points and their distances, in
    the order of the file.
    """
    distances = compared.distances
    return {
        "x_mm": distances.points[0],
        "y_mm": distances.points[1],
        "path_x_mm": distances.nearest[0],
        "path_y_mm": distances.nearest[1],
        "phi_deg": np.degrees(distances.angles),
        "arc_mm": distances.arcs,
        "distance_mm": distances.distances,
    }


@style.with_style
def draw_path(compared: PathComparison) -> Figure:
    """Draw measured points over the computed path, and their distances over the length of its
    arc.
    """
    distances, result = compared.distances, compared.result
    thin = slice(None, None, 1 + len(distances.distances) // MOST_DRAWN)
    points, nearest = distances.points[:, thin], distances.nearest[:, thin]
    figure = style.new_figure(6.4)
    top, bottom = figure.subplots(2, 1, height_ratios=[2.6, 1])
    computed, shade = style.curve_colour("exact", 0), style.curve_colour("printed", 1)
    top.plot(*compared.path, color=computed, label="computed path")
    joined = np.stack([points, nearest, np.full_like(points, np.nan)], axis=2).reshape(2, -1)
    top.plot(*joined, color=shade, linewidth=0.7)
    top.plot(*points, "o", color=shade, markersize=2.5, label="measured points")
    style.drawing_board(top)
    worst = result.largest
    top.plot(worst.x_mm, worst.y_mm, "o", color=shade, markersize=8, fillstyle="none")
    arcs = distances.arcs[thin]
    bottom.vlines(arcs, 0, distances.distances[thin], color=shade, linewidth=0.7)
    bottom.plot(arcs, distances.distances[thin], "o", color=shade, markersize=2.5)
    bottom.plot(
        worst.arc_mm,
        worst.distance_mm,
        "o",
        color=shade,
        markersize=8,
        fillstyle="none",
        label="largest distance",
    )
    bottom.axhline(0, color=computed, linewidth=1.0)
    bottom.set_xlim(0, result.length_mm)
    bottom.set_xlabel("length along the path / mm")
    bottom.set_ylabel("distance / mm")
    handles, labels = top.get_legend_handles_labels()
    further = bottom.get_legend_handles_labels()
    figure.legend(
        [*handles, *further[0]],
        [*labels, *further[1]],
        loc="outside upper right",
        ncols=3,
        frameon=False,
    )
    return figure
