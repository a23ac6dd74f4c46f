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


def write_synthesis(out: Path, found: Synthesis, progress: Listener | None = None) -> None:
    """Writes summary.json, curves and coupler paths as CSV, figures and report.html, whole or not at all.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    provenance = files.provenance(found.file)
    heads = list(files.comments(found.file, "poses"))
    rendered = bundle.drawn(_synthesis_figures(found), progress)
    texts = {
        "summary.json": _summary(found.result, {"input": found.file.table(), "provenance": provenance}),
        **_csv(heads, dict(_synthesis_tables(found))),
        "report.html": page.synthesis_page(found, _svgs(rendered), provenance),
    }
    bundle.write(out, texts, rendered)


def _synthesis_tables(found: Synthesis) -> Iterator[tuple[str, dict[str, Array]]]:
    for name, curve in (("nearest", found.nearest.curve if found.nearest else None), ("points", found.of_paths)):
        if curve is not None:
            yield f"{name}_curve.csv", _points(curve)
    for linkage in found.linkages:
        numbers = f"{linkage.numbers[0]}_{linkage.numbers[1]}"
        for circuit in range(1, len(linkage.bar.reaches) + 1):
            yield f"coupler_{numbers}_circuit{circuit}.csv", _coupler(linkage.bar.path(circuit))


def _synthesis_figures(found: Synthesis) -> dict[str, Figure]:
    drawn: dict[str, Figure] = {"dyads": figures.dyads(found)}
    for linkage in found.linkages:
        drawn[f"linkage_{linkage.numbers[0]}_{linkage.numbers[1]}"] = figures.linkage(linkage, found.poses)
    if found.carrier is not None:
        drawn["angle_curve"] = figures.angle_curve(found)
    return drawn


def write_train(out: Path, found: Training, source: str, progress: Listener | None = None) -> None:
    """Writes summary.json, the turn and the pitch curves as CSV, figures and report.html, whole or not at all.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    provenance = _provenance(found, source)
    heads = [f"curve: {source}", f"curve_sha256: {provenance['curve_sha256']}"]
    drawn = {"ratios": train_figures.ratios(found), "pitch_curves": train_figures.pitch_curves(found)}
    if found.dyad is not None:
        drawn["tip_path"] = train_figures.tip_path(found)
    rendered = bundle.drawn(drawn, progress)
    texts = {
        "summary.json": _summary(found.result, {"provenance": provenance}),
        **_csv(heads, {"cycle.csv": _cycle(found), "pitch_curves.csv": _pitch(found)}),
        "report.html": page.train_page(found, _svgs(rendered), provenance),
    }
    bundle.write(out, texts, rendered)


def _summary(result: Record, more: Mapping[str, Any]) -> str:
    return files.summary_text({**result.table(), "assumptions": model.assumptions(), **more})


def _csv(heads: list[str], tables: Mapping[str, Mapping[str, Array]]) -> dict[str, str]:
    return {name: files.cycle_csv(name, heads, columns) for name, columns in tables.items()}


def _svgs(drawn: Mapping[str, bundle.Drawn]) -> dict[str, str]:
    return {name: figure.svg for name, figure in drawn.items()}


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


def _cycle(found: Training) -> dict[str, Array]:
    curve = found.train.curve
    theta = np.linspace(curve.carrier[0], curve.carrier[-1], _TABLE)
    gears = found.train.gears(theta)
    columns = {"carrier_deg": np.degrees(theta), "relative_deg": np.degrees(curve.at(theta))}
    columns |= {name: gears[name] for name in ("i", "i1", "i2")}
    if found.dyad is not None:
        tip = model.arm(theta, curve.at(theta) + theta, found.dyad.vector)
        columns |= {"tip_x_mm": tip[0] * 1e3, "tip_y_mm": tip[1] * 1e3}
    return columns


def _pitch(found: Training) -> dict[str, Array]:
    psi, radii = polar_curves(found.train)
    columns: dict[str, Array] = {}
    for k, gear in enumerate(GEARS):
        name = gear.replace(" ", "_")
        columns |= {f"{name}_polar_deg": np.degrees(psi[k]), f"{name}_radius_mm": radii[k] * 1e3}
    return columns


def _provenance(found: Training, source: str) -> dict[str, Any]:
    return dict(_told(found, source))


def _told(found: Training, source: str) -> Iterator[tuple[str, Any]]:
    """What the run can be repeated from: versions, options, a hash of the points."""
    curve = found.train.curve
    yield "planter", __version__
    yield from ((name, metadata.version(name)) for name in ("casadi", "numpy", "scipy"))
    yield "python", platform.python_version()
    yield "curve", source
    yield "curve_sha256", hashlib.sha256(np.array([curve.carrier, curve.relative]).tobytes()).hexdigest()
    yield "centre_distance_mm", found.train.distance * 1e3
    yield "crank_mm", None if found.crank is None else found.crank * 1e3
