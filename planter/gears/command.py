"""Gears from pairs of teeth: the result, and its files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.files.text import hash_file
from planter.gearing.teeth.making import Toothed, toothed
from planter.gears import parts, summary
from planter.gears.asked import Teeth, counts
from planter.gears.curves import load_pair, path_of
from planter.gears.options import Keep
from planter.gears.parts import Parts, Placed
from planter.gears.results import GearsFound, Scaled
from planter.gears.rubbing import Rubbing
from planter.progress import Listener
from planter.version import __version__


@dataclass(frozen=True)
class Gears:
    """A set of toothed pairs with its gears in their places, and where it comes from."""

    machine: str
    pairs: Sequence[Toothed]
    placed: Sequence[Placed]
    scaled: Scaled | None
    provenance: Mapping[str, Any]
    rubbing: Rubbing | None = None


def make(gears: Gears, teeth: Teeth, made: Parts, out: Path | None, progress: Listener | None = None) -> GearsFound:
    """What is found of a set of gears; files where a folder is given.

    Raises InputError for a bore that leaves too thin a rim or a folder that cannot be written, GeometryError for teeth
    that run into each other.
    """
    ready = parts.check(gears.placed, made)
    stages = [
        summary.stage(k + 1, pair, ready[2 * k : 2 * k + 2], 1e-3 * teeth.centre_error_mm)
        for k, pair in enumerate(gears.pairs)
    ]
    found = GearsFound(
        gears.machine, teeth.pressure_angle, teeth.addendum, teeth.clearance, teeth.backlash_mm,
        teeth.centre_error_mm, teeth.process.value, stages, gears.scaled, None,
        gears.rubbing.found if gears.rubbing else None, [],
    )  # fmt: skip
    if out is None:
        return found
    from planter.gears.report import results

    return results.write(out, found, gears.pairs, ready, gears.rubbing, gears.provenance, progress)


def of_curves(
    curve: str, mate: str | None, turns: int, teeth: Teeth, module_mm: float | None, count: str | None,
    keep: Keep | None,
) -> Gears:  # fmt: skip
    """The pair of a curve in a file. Raises InputError for teeth that do not go with the turns of the mate."""
    numbers = counts(count)
    if len(numbers) == 2 and numbers[1] != turns * numbers[0]:
        raise InputError(
            f"--teeth {count} is not allowed: the mate turns once in {turns} of the gear's turns, so that it must have "
            f"{turns * numbers[0]} teeth where the gear has {numbers[0]}"
        )
    order = teeth.order(numbers[0] if numbers else None, module_mm, keep)
    found = toothed(load_pair(curve, mate, turns), order, curve, ("gear", "mate"))
    return Gears(Path(curve).stem, [found], _in_mesh(found), None, _provenance(curve, mate))


def _in_mesh(found: Toothed) -> list[Placed]:
    """Both gears where they are while the start of the gear's curve is in contact."""
    return [
        Placed(gear, float(angle), (float(x), float(y)))
        for gear, ((angle,), (x,), (y,)) in zip(found.gears, found.mesh.places(np.zeros(1)), strict=True)
    ]


def _provenance(*sources: str | None) -> dict[str, Any]:
    told: dict[str, Any] = {"planter": __version__}
    for source in sources:
        if source is not None:
            told[f"{Path(source).name} sha256"] = hash_file(path_of(source))
    return told
