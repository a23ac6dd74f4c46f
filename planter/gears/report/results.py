"""Everything that a set of gears leaves in a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from planter.gearing.teeth.making import Toothed
from planter.gears import parts
from planter.gears.parts import Part
from planter.gears.report import figures, page
from planter.gears.report.scene import scene
from planter.gears.results import GearsFound
from planter.gears.rubbing import Rubbing
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.folder import renews
from planter.view.block import Motion


@renews
def write(
    out: Path, found: GearsFound, pairs: Sequence[Toothed], made: Sequence[Part], rubbing: Rubbing | None,
    provenance: Mapping[str, Any], progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """Writes drawings, solids, tables, figures, report.html and summary.json; returns the result with their paths.

    Raises InputError for a folder that it cannot write, or where a solid needs what is not installed.
    """
    folder = files.output_folder(out)
    contents = dict(parts.files(made))
    if rubbing:
        comments = [f"machine: {found.machine}", "angles stand close to each other on both sides of every jump"]
        contents["friction.csv"] = files.cycle_csv("friction.csv", comments, rubbing.columns()).encode()
    drawn = bundle.drawn(figures.figures(pairs, [part.placed for part in made], rubbing), progress)
    told = replace(found, files=[str(folder / name) for name in contents])
    for name, content in contents.items():
        files.write_bytes(folder / name, content)
    place = files.output_folder(folder / "figures")
    for name, figure in drawn.items():
        files.write_text(place / f"{name}.svg", figure.svg)
        files.write_bytes(place / f"{name}.png", figure.png)
    svgs = {name: figure.svg for name, figure in drawn.items()}
    files.write_text(folder / "report.html", page.text(told, svgs, provenance, [Motion(scene(pair)) for pair in pairs]))
    files.write_summary(folder / "summary.json", {**told.table(), "provenance": dict(provenance)})
    return told
