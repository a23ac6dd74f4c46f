"""What `planter cam --out` leaves: drawing, preview, table, figures, page, and the solid where it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from planter.files.document import Document
from planter.report import bundle, files
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.workshop import preview
from planter.workshop.cams import figures
from planter.workshop.cams.lifting import Push
from planter.workshop.cams.part import Part, table
from planter.workshop.cams.results import Cam
from planter.workshop.drawing import dxf

CAPTIONS = {
    "contour": "Contour, pitch curve, and the roller at every 30 deg of the cam.",
    "limits": "Pressure angle; 1 - roller / radius of curvature of the pitch curve, at zero the roller would cut in.",
    "lifting": "Force between cam and roller over a turn; the roller lifts off where it vanishes first.",
}


@dataclass(frozen=True)
class Told:
    """What a page says of a cam besides its numbers: the machine with the meanings of its inputs, what is written
    beside the generated functions, the contact force if it is known, and the machine's own speed [rad/s]."""

    machine: Document
    meanings: Mapping[str, str]
    sidecar: Mapping[str, Any]
    push: Push | None
    own_speed: float

    @property
    def entries(self) -> Sequence[dict[str, str]]:
        """Name, unit and meaning of what the contour's functions tell."""
        found: Sequence[dict[str, str]] = self.sidecar["vectors"]["contour"]
        return found


@dataclass(frozen=True)
class Made:
    """A cam with what is told of it, and its solid, made when it is asked for."""

    part: Part
    told: Told
    solid: Callable[[], bytes]


def write(out: Path, made: Made, step: bool) -> Cam:
    """Writes all of it, whole or not at all, and returns the result with the names of the files.

    Raises InputError for a folder that it cannot write, and where Open CASCADE is missing for a solid.
    """
    files.output_folder(out)
    part, told = made.part, made.told
    drawn = bundle.drawn(_figures(part, told))
    provenance = files.provenance(told.machine)
    texts = {
        "contour.dxf": dxf(part.lines).decode(),
        "contour.svg": preview.svg(part.lines, f"Cam of {told.machine.name}"),
        "contour.csv": files.cycle_csv("contour.csv", _comments(part, told), table(part.profile, told.entries)),
        **({"cam.step": made.solid().decode()} if step else {}),
    }
    result = replace(part.result, files=[*texts, "summary.json", "report.html"])
    texts["summary.json"] = files.summary_text(
        {**result.table(), "input": told.machine.table(), "provenance": provenance}
    )
    sections = [*_results(result), *_rest(told, drawn, provenance)]
    texts["report.html"] = page(f"Cam of {told.machine.name}", sections, told.machine.description)
    bundle.write(out, texts, drawn)
    return result


def _figures(part: Part, told: Told) -> dict[str, Any]:
    found = {"contour": figures.contour(part), "limits": figures.limits(part)}
    if told.push is not None:
        lifted = part.result.lift_off
        speed = None if lifted is None else lifted.speed_rpm / lifted.own_speed_rpm * told.own_speed
        found["lifting"] = figures.lifting(told.push, told.own_speed, speed)
    return found


def _comments(part: Part, told: Told) -> Iterator[str]:
    roller = f"{part.result.kind} cam for a roller of a radius of {part.result.roller.radius_mm:g} mm"
    meanings = (f"{entry['name']}: {entry['meaning']}" for entry in told.entries)
    yield from files.comments(told.machine, "cam", (roller, *meanings))


def _results(result: Cam) -> Iterator[Section]:
    yield Section("Results", list(_keys(result)))


def _keys(result: Cam) -> Iterator[Block]:
    found = result.table()
    yield Keys({"kind": result.kind, "files": ", ".join(result.files)})
    for group in ("roller", "pressure_angle_deg", "lift_off", "contour"):
        if found[group] is not None:
            rows = [(label(key), value) for key, value in found[group].items()]
            yield Table(("quantity", "value"), rows, label(group))
    if result.lift_off is None:
        yield Text("The roller stays on at every speed that was tried, or no contact force was named.", "note")


def _rest(told: Told, drawn: Mapping[str, bundle.Drawn], provenance: Mapping[str, Any]) -> Iterator[Section]:
    yield Section("Figures", [FigureSvg(figure.svg, CAPTIONS[name]) for name, figure in drawn.items()])
    title = Text(f"{told.sidecar['title']} ({told.sidecar['source']}). It assumes:")
    yield Section("Model", [title, Items(told.sidecar["assumptions"])])
    yield Section("Inputs", list(inputs(told.machine, told.meanings)))
    yield provenance_section(provenance)
