"""Everything that a set of gears leaves in a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.gearing.teeth.incomplete.proof import Turn
from planter.gearing.teeth.making import Toothed
from planter.gears import parts
from planter.gears.parts import Part
from planter.gears.report import dwelling, figures, page
from planter.gears.report.scene import scene
from planter.gears.results import GearsFound
from planter.gears.rubbing import Rubbing
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.folder import renews
from planter.view.block import Motion
from planter.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@renews
def write(
    out: Path, found: GearsFound, pairs: Sequence[Toothed], made: Sequence[Part], rubbing: Rubbing | None,
    provenance: Mapping[str, Any], progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """Writes drawings, solids, tables, figures, report.html and summary.json; returns the result with their paths.

    Raises InputError for a folder that it cannot write, or where a solid needs what is not installed.
    """
    contents = dict(parts.files(made))
    if rubbing:
        comments = [f"machine: {found.machine}", "angles stand close to each other on both sides of every jump"]
        contents["friction.csv"] = files.cycle_csv("friction.csv", comments, rubbing.columns()).encode()
    drawn = figures.figures(pairs, [part.placed for part in made], rubbing)
    return _write(out, found, contents, drawn, [scene(pair) for pair in pairs], provenance, progress)


@renews
def write_dwelling(
    out: Path, found: GearsFound, turn: Turn, made: Sequence[Part], provenance: Mapping[str, Any],
    progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """The same of a pair that dwells. Raises as `write`."""
    drawn = dwelling.figures(turn, [part.placed for part in made])
    return _write(out, found, dict(parts.files(made)), drawn, [dwelling.scene(turn)], provenance, progress)


def _write(
    out: Path, found: GearsFound, contents: Mapping[str, bytes], drawn: Mapping[str, Figure], scenes: Sequence[Scene],
    provenance: Mapping[str, Any], progress: Listener | None,
) -> GearsFound:  # fmt: skip
    folder = files.output_folder(out)
    made = bundle.drawn(drawn, progress)
    told = replace(found, files=[str(folder / name) for name in contents])
    svgs = {name: figure.svg for name, figure in made.items()}
    texts = {
        "report.html": page.text(told, svgs, provenance, [Motion(one) for one in scenes]),
        "summary.json": files.summary_text({**told.table(), "provenance": dict(provenance)}),
    }
    bundle.write(out, {**contents, **texts}, made)
    return told
