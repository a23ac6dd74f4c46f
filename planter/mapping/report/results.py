"""The files that a synthesis and a gear train leave in a folder: summary, tables, figures and page."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.mapping import model
from planter.mapping.report import figures, page, train_figures
from planter.mapping.train import GEARS
from planter.mapping.training import polar_curves
from planter.progress import Listener
from planter.report import bundle, files
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.mapping.curve import AngleCurve
    from planter.mapping.linkage import Path as CouplerPath
    from planter.mapping.synthesis import Synthesis
    from planter.mapping.training import Training
    from planter.records import Record

_TABLE = 721
"""Rows of a table over a turn."""


def write_synthesis(out: Path, synthesis: Synthesis, progress: Listener | None = None) -> None:
    """Write summary.json, curves and coupler paths as CSV, figures and report.html, whole or not at all.

    Raises InputError if the folder cannot be written.
    """
    files.output_folder(out)
    provenance = files.provenance(synthesis.file)
    heads = list(files.comments(synthesis.file, "poses"))
    rendered = bundle.drawn(_synthesis_figures(synthesis), progress)
    texts = {
        "summary.json": _summary(synthesis.result, {"input": synthesis.file.table(), "provenance": provenance}),
        **_csv(heads, dict(_synthesis_tables(synthesis))),
        "report.html": page.synthesis_page(synthesis, _svgs(rendered), provenance),
    }
    bundle.write(out, texts, rendered)


def _synthesis_tables(synthesis: Synthesis) -> Iterator[tuple[str, dict[str, Array]]]:
    for name, curve in (
        ("nearest", synthesis.nearest.curve if synthesis.nearest else None),
        ("points", synthesis.path_curve),
    ):
        if curve is not None:
            yield f"{name}_curve.csv", _points(curve)
    for linkage in synthesis.linkages:
        numbers = f"{linkage.numbers[0]}_{linkage.numbers[1]}"
        for circuit in range(1, len(linkage.bar.reaches) + 1):
            yield f"coupler_{numbers}_circuit{circuit}.csv", _coupler(linkage.bar.path(circuit))


def _synthesis_figures(synthesis: Synthesis) -> dict[str, Figure]:
    plots: dict[str, Figure] = {"dyads": figures.dyads(synthesis)}
    for linkage in synthesis.linkages:
        plots[f"linkage_{linkage.numbers[0]}_{linkage.numbers[1]}"] = figures.linkage(linkage, synthesis.poses)
    if synthesis.carrier is not None:
        plots["angle_curve"] = figures.angle_curve(synthesis)
    return plots


def write_train(out: Path, training: Training, source: str, progress: Listener | None = None) -> None:
    """Write summary.json, the turn and the pitch curves as CSV, figures and report.html, whole or not at all.

    Raises InputError if the folder cannot be written.
    """
    files.output_folder(out)
    provenance = _provenance(training, source)
    heads = [f"curve: {source}", f"curve_sha256: {provenance['curve_sha256']}"]
    plots = {"ratios": train_figures.ratios(training), "pitch_curves": train_figures.pitch_curves(training)}
    if training.dyad is not None:
        plots["tip_path"] = train_figures.tip_path(training)
    rendered = bundle.drawn(plots, progress)
    texts = {
        "summary.json": _summary(training.result, {"provenance": provenance}),
        **_csv(heads, {"cycle.csv": _cycle(training), "pitch_curves.csv": _pitch(training)}),
        "report.html": page.train_page(training, _svgs(rendered), provenance),
    }
    bundle.write(out, texts, rendered)


def _summary(result: Record, more: Mapping[str, Any]) -> str:
    return files.summary_text({**result.table(), "assumptions": model.assumptions(), **more})


def _csv(heads: list[str], tables: Mapping[str, Mapping[str, Array]]) -> dict[str, str]:
    return {name: files.cycle_csv(name, heads, columns) for name, columns in tables.items()}


def _svgs(plots: Mapping[str, bundle.Drawn]) -> dict[str, str]:
    return {name: figure.svg for name, figure in plots.items()}


def _points(curve: AngleCurve) -> dict[str, Array]:
    """The points of a curve, as the train's command reads them."""
    return {"carrier_deg": np.degrees(curve.carrier), "relative_deg": np.degrees(curve.relative)}


def _coupler(path: CouplerPath) -> dict[str, Array]:
    return {
        "crank_deg": np.degrees(path.theta),
        "assembly": path.assembly,
        "phi_deg": np.degrees(path.phi),
        "tip_x_mm": path.tip[0] * 1e3,
        "tip_y_mm": path.tip[1] * 1e3,
        "transmission_deg": np.degrees(path.transmission),
    }


def _cycle(training: Training) -> dict[str, Array]:
    curve = training.train.curve
    theta = np.linspace(curve.carrier[0], curve.carrier[-1], _TABLE)
    gears = training.train.gears(theta)
    columns = {"carrier_deg": np.degrees(theta), "relative_deg": np.degrees(curve.at(theta))}
    columns |= {name: gears[name] for name in ("i", "i1", "i2")}
    if training.dyad is not None:
        tip = model.arm(theta, curve.at(theta) + theta, training.dyad.vector)
        columns |= {"tip_x_mm": tip[0] * 1e3, "tip_y_mm": tip[1] * 1e3}
    return columns


def _pitch(training: Training) -> dict[str, Array]:
    psi, radii = polar_curves(training.train)
    columns: dict[str, Array] = {}
    for k, gear in enumerate(GEARS):
        name = gear.replace(" ", "_")
        columns |= {f"{name}_polar_deg": np.degrees(psi[k]), f"{name}_radius_mm": radii[k] * 1e3}
    return columns


def _provenance(training: Training, source: str) -> dict[str, Any]:
    return dict(_list_sources(training, source))


def _list_sources(training: Training, source: str) -> Iterator[tuple[str, Any]]:
    """Yield what repeats the run: versions, options, a hash of the points."""
    curve = training.train.curve
    yield "planter", __version__
    yield from ((name, metadata.version(name)) for name in ("casadi", "numpy", "scipy"))
    yield "python", platform.python_version()
    yield "curve", source
    yield "curve_sha256", hashlib.sha256(np.array([curve.carrier, curve.relative]).tobytes()).hexdigest()
    yield "centre_distance_mm", training.train.distance * 1e3
    yield "crank_mm", None if training.crank is None else training.crank * 1e3
