"""Pairs that dwell as results: what is found of them, and everything that they leave in a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from planter.errors import GeometryError
from planter.gearing.teeth.incomplete.gear import IncompleteGear
from planter.gearing.teeth.incomplete.locking import Intermittent
from planter.gearing.teeth.incomplete.proof import FREE, POSITIONS, Loose, Turn
from planter.gears import parts, results
from planter.gears.options import Teeth
from planter.gears.parts import Part, Parts, Placed
from planter.gears.report import figures
from planter.gears.results import GearsFound, IncompleteCut, LooseMotion, LooseTurn
from planter.kernels import Array
from planter.progress import Listener
from planter.report import bundle, files, style
from planter.report.folder import renews

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LARGEST = 1e-15
"""Area that rounding may let outlines share which touch [m2]."""
_MM = 1e3
_SHOWN = (("the dwell ends", 0.0), ("the middle of the dwell", None), ("the dwell begins", 1.0))


def make(
    found: Intermittent, machine: str, teeth: Teeth, made: Parts, provenance: Mapping[str, Any], out: Path | None,
    progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """What is found of a pair that dwells; files where a folder is given.

    Raises GeometryError where the outlines run into each other, InputError for a bore that runs into roots or a folder
    that cannot be written.
    """
    ready = parts.check(_placed(found), made)
    told = GearsFound(
        machine, teeth.pressure_angle, teeth.addendum, teeth.clearance, teeth.backlash_mm, teeth.centre_error_mm,
        teeth.process.value, [], None, told_of(found, machine, teeth.centre_error_mm / _MM), None, [],
    )  # fmt: skip
    return told if out is None else write(out, told, found, ready, provenance, progress)


def told_of(found: Intermittent, machine: str, farther: float = 0.0) -> results.Intermittent:
    """A pair, its outlines laid over each other all round the turn; `farther` is an error of the centre distance [m].

    Raises GeometryError where they overlap.
    """
    turn, rolling = Turn(found), found.rolling
    overlap, held = float(turn.rolling.max()), float(turn.held.max())
    if max(overlap, held) > LARGEST:
        where = "over the teeth" if overlap > held else "in the dwell"
        raise GeometryError(
            f"{machine}: the gears run into each other by {max(overlap, held) * _MM**2:.3g} mm2 {where}: a smaller "
            f"addendum or some play would help"
        )
    middle = np.argmin(np.abs(turn.loose.at - rolling.over[1] - rolling.dwell / 2))
    return results.Intermittent(
        z=found.gear.z,
        pitches=rolling.length / found.gear.rack.pitch,
        module_mm=found.gear.rack.module * _MM,
        centre_distance_mm=rolling.pair.distance * _MM,
        toothed_arc_mm=rolling.length * _MM,
        locking_radius_mm=found.radius * _MM,
        end_radii_mm=(rolling.ends[0] * _MM, rolling.ends[1] * _MM),
        horns_deg=_degrees(tuple(horn.reach for horn in found.phase.horns)),
        apart_mm=found.apart * _MM,
        dwell_deg=float(np.degrees(rolling.dwell)),
        gears=[_gear(one) for one in found.gears],
        undriven_deg=_degrees(turn.undriven),
        undriven_least_deg=_degrees(found.phase.least),
        unheld_deg=_degrees(turn.unheld),
        slack_deg=_degrees((turn.loose.behind[middle], turn.loose.ahead[middle])),
        loose=_loose(turn.loose),
        farther_loose=_loose(turn.farther(farther).loose) if farther else None,
        overlap_mm2=overlap * _MM**2,
        dwell_overlap_mm2=held * _MM**2,
        positions=POSITIONS,
    )


def _degrees(angles: Sequence[float]) -> tuple[float, float]:
    first, last = np.degrees(angles).tolist()
    return first, last


def _loose(found: Loose) -> LooseTurn:
    after, driven, before, dwell = (
        LooseMotion(*(_most(turns[found.part == part]) for turns in (found.behind, found.ahead))) for part in range(4)
    )
    return LooseTurn(after, driven, before, dwell)


def _most(turns: Array) -> float | None:
    """The largest of some turns in deg, None where nothing stops them."""
    most = float(turns.max())
    return None if most >= FREE else float(np.degrees(most))


def _gear(gear: IncompleteGear) -> IncompleteCut:
    margins = gear.row.flanks.margins
    worst = int(np.argmin(margins))
    return IncompleteCut(
        gear.name, gear.z, float(shapely.Polygon(gear.points).area) * _MM**2, float(margins[worst]),
        int(gear.row.flanks.tooth[worst]), len(gear.pieces), gear.joins * _MM,
    )  # fmt: skip


def _placed(found: Intermittent) -> list[Placed]:
    """Both gears where they are in the middle of the dwell."""
    where = found.rolling.held(np.array([0.5]))
    return [
        Placed(gear, float(angle), (float(x), float(y)))
        for gear, ((angle,), (x,), (y,)) in zip(found.gears, where, strict=True)
    ]


@renews
def write(
    out: Path, told: GearsFound, found: Intermittent, made: Sequence[Part], provenance: Mapping[str, Any],
    progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """Writes drawings, solids, tables, figures and summary.json; returns the result with their paths."""
    folder = files.output_folder(out)
    contents = dict(parts.files(made))
    for name, content in contents.items():
        files.write_bytes(folder / name, content)
    place = files.output_folder(folder / "figures")
    drawn = {"assembly": figures.assembly([part.placed for part in made]), "dwell": dwell(found)}
    for name, figure in bundle.drawn(drawn, progress).items():
        files.write_text(place / f"{name}.svg", figure.svg)
        files.write_bytes(place / f"{name}.png", figure.png)
    told = replace(told, files=[str(folder / name) for name in contents])
    files.write_summary(folder / "summary.json", {**told.table(), "provenance": dict(provenance)})
    return told


@style.drawn
def dwell(found: Intermittent) -> Figure:
    """Both gears about the line of centres where the dwell begins, in its middle, and where it ends."""
    figure = style.new_figure(4.2)
    rolling = found.rolling
    for axes, (title, share) in zip(figure.subplots(1, 3, sharey=True), reversed(_SHOWN), strict=True):
        where = rolling.held(np.array([0.5])) if share is None else rolling.places(np.array([share * rolling.length]))
        for gear, place, shade in zip(found.gears, where, (style.BLUE, style.VERMILION), strict=True):
            outline = np.vstack([gear.points, gear.points[:1]])
            line = outline @ np.array([1, 1j]) * np.exp(1j * place[0]) + place[1]
            axes.fill(_MM * line.real, _MM * line.imag, facecolor=shade, alpha=0.12, edgecolor="none")
            axes.plot(_MM * line.real, _MM * line.imag, color=shade, linewidth=0.8, label=gear.name)
        axes.set_aspect("equal")
        axes.set_xlim(_MM * found.radius - 12, _MM * found.radius + 12)
        axes.set_ylim(-_MM * found.radius, _MM * found.radius)
        axes.set_title(title)
    figure.axes[0].legend(loc="upper left", frameon=False)
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure
