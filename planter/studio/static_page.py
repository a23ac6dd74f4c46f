"""The studio's page of a machine as one HTML file with programs in WebAssembly:
`planter studio --static`.

The page loads no external resources. Its content security policy allows its script and style by
their hashes; 'wasm-unsafe-eval' lets the script compile the programs.
"""

from __future__ import annotations

import base64
import difflib
import gzip
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from planter.errors import ComputationError, InputError, PlanterError
from planter.kernels import Array
from planter.kernels.compiler import CompilerError
from planter.kernels.lane_graph import NotPrintableError
from planter.kernels.programs import Program, build_webassembly
from planter.report.animation import compact_script, pack_scene
from planter.report.files import write_bytes
from planter.report.folder import check_files
from planter.report.html import escape_markup, policy_source
from planter.report.picture import LONGEST, Frame, Picture
from planter.report.scene import Outline, Scene
from planter.report.subject import Control, Movable, Portable, Searching, Values, open_machine
from planter.version import __version__

MODULES = ("programs", "filled", "improve", "text", "line")
"""JavaScript modules of this package, each after those that it imports from."""
HOLE = "{}"
"""Placeholder of a moved number in a line of a file."""
SHARE = 0.381966011250105
"""Share of the way to a bound at which a number is tried, so that its digits occur nowhere else in
the file.
"""
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";$', re.MULTILINE)
_NAMED = re.compile(r"^export ((?:async )?(?:class|function|const) (\w+))", re.MULTILINE)
_DEFAULT = re.compile(r"^export default .*$", re.MULTILINE)


def write_page(source: str, file: Path) -> Path:
    """Write the page of a machine, a file or built-in name, to an HTML file, and return its path.

    Raises InputError if the file does not end in .html, if no page can compute the machine, or if
    the compiler is missing.
    """
    if file.suffix.lower() != ".html":
        raise InputError(f"--static {file}: the page is HTML; name a file that ends in .html")
    check_files(file.parent, [file.name])
    machine = open_machine(source)
    if not isinstance(machine, Movable):
        raise InputError(
            f"--static is not available for {source}: such a machine is computed in Python only"
        )
    try:
        text = build_page(machine)
    except NotPrintableError as reason:
        raise InputError(f"--static is not available for {source}: {reason}") from None
    except CompilerError as reason:
        raise InputError(f"--static {file} cannot be written: {reason}") from None
    write_bytes(file, text.encode())
    return file


def build_page(machine: Movable) -> str:
    """Return the page.

    Raises CompilerError if the programs cannot be compiled, and the errors of these programs.
    """
    rigid = machine.rigid
    models = {name: StaticPageModel(rigid, name) for name in machine.models}
    programs = [program for model in models.values() for program in model.portable.programs]
    module = gzip.compress(build_webassembly(programs), mtime=0)
    description = {
        "name": machine.name,
        "controls": [control.to_json() for control in rigid.controls],
        "goal": machine.describe_goal() if isinstance(machine, Searching) else "",
        "search": "Improve" if all(model.portable.gradient for model in models.values()) else None,
        "models": {name: model.json() for name, model in models.items()},
        "programs": {program.name: program.size for program in programs},
        "module": base64.b64encode(module).decode("ascii"),
        "file": file_template(machine, rigid.controls),
    }
    return _html(machine, description, models)


def _html(
    machine: Movable, description: Mapping[str, Any], models: Mapping[str, StaticPageModel]
) -> str:
    studio, view = "planter.studio", "planter.report"
    modules = {
        "view": _text(view, "view.js"),
        **{name: _text(studio, f"{name}.js") for name in ("tables", "fields", "exports")},
        **{name: _text(studio, f"static/{name}.js") for name in MODULES},
        "studio": _text(studio, "studio.js"),
    }
    script, style = (
        bundle_modules(modules),
        "\n".join([_text(view, "view.css"), _text(studio, "studio.css")]),
    )
    policy = (
        f"default-src 'none'; script-src {policy_source(script)} 'wasm-unsafe-eval'; style-src "
        f"{policy_source(style)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    body = _text(studio, "studio.html").partition("<body>")[2].partition("</body>")[0]
    notes = (note for model in models.values() for note in model.portable.notes)
    return Template(_text(studio, "static/page.html")).substitute(
        policy=policy,
        name=escape_markup(machine.name),
        style=style,
        script=script,
        body=body.strip(),
        machine=json.dumps(description, separators=(",", ":")).replace("<", "\\u003c"),
        version=__version__,
        notes=escape_markup(" ".join(dict.fromkeys(notes))),
        assumptions="".join(
            f"<h3>{name}</h3><p>{escape_markup('; '.join(model.portable.assumptions))}.</p>"
            for name, model in models.items()
        ),
    )


def _text(package: str, name: str) -> str:
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")


def bundle_modules(modules: Mapping[str, str]) -> str:
    """Return ES modules as one script; `modules` are texts by name, each after those that it
    imports from.
    """
    return "\n".join(
        [
            "const modules = {};",
            *(_scoped(name, compact_script(text)) for name, text in modules.items()),
        ]
    )


def _scoped(name: str, text: str) -> str:
    exported = ", ".join(export for _, export in _NAMED.findall(text))
    inner = _IMPORT.sub(r"const \1 = modules.\2;", _DEFAULT.sub("", _NAMED.sub(r"\1", text)))
    return f"modules.{name} = (() => {{\n{inner}\nreturn {{ {exported} }};\n}})();"


def file_template(machine: Movable, controls: Sequence[Control]) -> dict[str, Any]:
    """Return the lines of a machine's file, and edits by path of controls, which replace the lines
    `from` to `to`.

    Raises ComputationError if two numbers are in the same line.
    """
    values = {control.path: control.value for control in controls}
    lines = machine.handed(values).splitlines()
    edits = {control.path: _edits(machine, values, lines, control) for control in controls}
    replaced = [
        line
        for changes in edits.values()
        for edit in changes
        for line in range(edit["from"], edit["to"])
    ]
    if len(set(replaced)) < len(replaced):
        raise ComputationError(
            f"{machine.name}: a page without a server cannot write its file, line by line"
        )
    return {"lines": lines, "edits": edits}


def _edits(
    machine: Movable, values: dict[str, float], lines: list[str], control: Control
) -> list[dict[str, Any]]:
    bound = control.upper if control.upper > control.value else control.lower
    trial = control.value + SHARE * (bound - control.value)
    moved = machine.handed(values | {control.path: trial}).splitlines()
    return [
        {"from": i, "to": j, "lines": [line.replace(repr(trial), HOLE) for line in moved[k:m]]}
        for kind, i, j, k, m in difflib.SequenceMatcher(
            None, lines, moved, autojunk=False
        ).get_opcodes()
        if kind != "equal"
    ]


SAME = 1e-9
"""Tolerance of equal numbers, relative to the largest."""
Source = dict[str, Any]
"""A row: its start, count, lead, sign and added constant; or a single number: its index and added
constant.
"""


@dataclass(frozen=True)
class DrawingTemplate:
    """The sources of the moving parts of a drawing, ready for JSON.

    `channels` are paths in a record with their sources; `outlines` are lines of the picture by
    number, closed or not, with two rows or with two sources for each corner; `labels` are texts by
    number with the sources of x and y.
    """

    channels: list[tuple[list[str | int], Source]] = field(default_factory=list)
    outlines: list[dict[str, Any]] = field(default_factory=list)
    labels: list[tuple[int, Source | None, Source | None]] = field(default_factory=list)


class Recogniser:
    """The programs of a machine evaluated at some designs, and their scenes, which have the same
    lines.
    """

    def __init__(
        self, portable: Portable, designs: Sequence[Values], scenes: Sequence[Scene]
    ) -> None:
        self.scenes = scenes
        program = portable.seen
        results = [portable.at(values, program) for values in designs]
        self.rows: list[tuple[int, Array]] = []
        for vector, count in portable.rows.items():
            values = np.array([vectors[vector].reshape(count, -1) for vectors in results])
            start, size = program.offsets[vector], values.shape[2]
            self.rows += [(start + k * size, values[:, k]) for k in range(count)]
        start = program.offsets["singles"]
        singles = np.array([vectors["singles"] for vectors in results]).T
        self.singles = [(start + k, values) for k, values in enumerate(singles)]

    def plan(self) -> DrawingTemplate:
        """Return the sources of all moving parts.

        Raises ComputationError if a part has no source.
        """
        plan = DrawingTemplate()
        for path, values in self._channels():
            source = self._source(values, str(path))
            if source is not None:
                plan.channels.append((path, source))
        lines = [list_outlines(scene) for scene in self.scenes]
        for number, versions in enumerate(zip(*lines, strict=True)):
            if (outline := self._outline(number, versions)) is not None:
                plan.outlines.append(outline)
        for number, labels in enumerate(zip(*(scene.labels for scene in self.scenes), strict=True)):
            x, y = (
                self._source([np.asarray(getattr(label, axis)) for label in labels], labels[0].text)
                for axis in "xy"
            )
            plan.labels.append((number, x, y))
        return plan

    def _channels(self) -> Iterator[tuple[list[str | int], list[Array]]]:
        """Yield paths in a record with their values in each scene."""
        yield ["seconds"], [np.asarray(scene.seconds) for scene in self.scenes]
        yield ["places"], [scene.places for scene in self.scenes]
        if all(scene.travel is not None for scene in self.scenes):
            yield ["travel"], [np.asarray(scene.travel) for scene in self.scenes]
        parts = {
            "bodies": lambda scene: [
                (*body.at, body.turn, *body.scale) for body in scene.all_bodies()
            ],
            "points": lambda scene: [(point.x, point.y) for point in scene.points],
            "forces": lambda scene: [
                (force.at.x, force.at.y, force.x, force.y) for force in scene.forces
            ],
        }
        for key, part in parts.items():
            for k, versions in enumerate(zip(*map(part, self.scenes), strict=True)):
                for j, values in enumerate(zip(*versions, strict=True)):
                    yield [key, k, j], [np.asarray(value, dtype=float) for value in values]
        for k, curves in enumerate(zip(*(scene.curves for scene in self.scenes), strict=True)):
            yield ["curves", k, "values"], [curve.values for curve in curves]
            if curves[0].reference is not None:
                yield (
                    ["curves", k, "reference"],
                    [np.asarray(curve.reference, dtype=float) for curve in curves],
                )

    def _outline(self, number: int, versions: Sequence[Outline]) -> dict[str, Any] | None:
        points = np.array([outline.points for outline in versions])
        if not np.ptp(points, axis=0).any():
            return None
        entry: dict[str, Any] = {"number": number, "closed": versions[0].closed}
        x, y = (self._row(points[:, :, axis]) for axis in (0, 1))
        if x is not None and y is not None:
            return entry | {"rows": [x, y]}
        name = f"corner of the line {number}"
        corners = [
            [self._fixed(points[:, k, axis], name) for axis in (0, 1)]
            for k in range(points.shape[1])
        ]
        return entry | {"corners": corners}

    def _fixed(self, values: Array, name: str) -> Source:
        """Return the source of a single number, which may be constant."""
        source = self._source(list(values), name)
        return {"at": -1, "plus": float(values[0])} if source is None else source

    def _source(self, values: Sequence[Array], name: str) -> Source | None:
        """Return the source of values in each of the designs, or None if they are constant."""
        stacked = np.array(values)
        if np.ptp(stacked, axis=0).max() <= SAME * np.abs(stacked).max() and stacked.ndim == 1:
            return None
        source = self._row(stacked) if stacked.ndim == 2 else self._single(stacked)
        if source is None:
            raise ComputationError(
                f"{self.scenes[0].title}: a page without a server cannot follow its {name}"
            )
        return source

    def _single(self, values: Array) -> Source | None:
        scale = SAME * max(1.0, float(np.abs(values).max()))
        for at, candidate in self.singles:
            if np.ptp(values - candidate) <= scale:
                return {"at": at, "plus": _constant(values - candidate, scale)}
        return None

    def _row(self, values: Array) -> Source | None:
        scale = SAME * max(1.0, float(np.abs(values).max()))
        size = values.shape[1]
        for at, candidate in self.rows:
            if candidate.shape != values.shape:
                continue
            for ahead in (0, size // 2):
                for sign in (1, -1):
                    difference = values - sign * np.roll(candidate, -ahead, axis=1)
                    if np.ptp(difference) <= scale:
                        row = {"at": at, "count": size, "ahead": ahead, "sign": sign}
                        return row | {"plus": _constant(difference, scale)}
        return None


def _constant(difference: Array, scale: float) -> float:
    mean = float(np.mean(difference))
    return mean if abs(mean) > scale else 0.0


def list_outlines(scene: Scene) -> list[Outline]:
    """Return the lines of a picture in order: those of the ground, then those of the bodies."""
    return [*scene.ground, *(outline for body in scene.all_bodies() for outline in body.outlines)]


ALIKE, TRIES = 3, 24
"""Number of random designs at which numbers are recognised, and maximum number of attempts."""


class StaticPageModel:
    """A model of a machine for a static page."""

    def __init__(self, machine: Movable, name: str) -> None:
        self.machine, self.name = machine, name
        self.portable: Portable = machine.portable(name)

    def json(self) -> dict[str, Any]:
        """Return the JSON object for the script of the page."""
        designs, scenes = zip(*self._designs, strict=True)
        seen, first = self.portable.seen, scenes[0]
        picture = Picture(first)
        picture.frames = (self._frame, self._frame)
        plan = Recogniser(self.portable, designs, scenes).plan()
        return {
            "seen": {"name": seen.name, "inputs": self._inputs(seen)},
            "readings": self._readings(designs[0]),
            "picture": picture.text(),
            "template": {**pack_scene(first), "events": [], "data": ""},
            "plan": {**asdict(plan), "again": first.again, "longest": LONGEST},
            "descent": self._descent(),
        }

    def _inputs(self, program: Program) -> list[dict[str, Any]]:
        paths = {control.path for control in self.machine.controls}
        return [
            {
                "path": entry.path,
                "at": program.offsets[entry.vector] + entry.index,
                "factor": entry.factor,
            }
            for entry in self.portable.inputs
            if entry.path in paths
        ]

    def _readings(self, values: Values) -> list[dict[str, Any]]:
        """Return names, units and indices of the readings; the index is null if no program computes
        the reading.
        """
        start = self.portable.seen.offsets["singles"]
        indices = {name: start + index for index, name in enumerate(self.portable.singles)}
        readings = self.machine.readings(values, self.name)
        return [
            {"name": entry.name, "unit": entry.unit, "at": indices.get(entry.name)}
            for entry in readings
        ]

    def _descent(self) -> dict[str, Any] | None:
        program = self.portable.gradient
        if program is None:
            return None
        factors = {entry.path: entry.factor for entry in self.portable.inputs}
        return {
            "name": program.name,
            "inputs": self._inputs(program),
            "paths": list(self.portable.design),
            "factors": [factors[path] for path in self.portable.design],
            "objective": program.offsets["objective"],
            "gradient": program.offsets["gradient"],
        }

    @cached_property
    def _designs(self) -> list[tuple[Values, Scene]]:
        """Random designs whose drawings have the same lines as that of the first, with their
        scenes.
        """
        designs: list[tuple[Values, Scene]] = []
        for values, scene in self._random_designs():
            if not designs or _shape(scene) == _shape(designs[0][1]):
                designs.append((values, scene))
            if len(designs) == ALIKE:
                return designs
        raise ComputationError(
            f"{self.machine.name}: fewer than {ALIKE} of {TRIES} random designs have similar "
            f"drawings"
        )

    def _random_designs(self) -> Iterator[tuple[Values, Scene]]:
        rng, controls = np.random.default_rng(1), self.machine.controls
        for _ in range(TRIES):
            values = {
                control.path: float(rng.uniform(control.lower, control.upper))
                for control in controls
            }
            if (scene := self._scene(values)) is not None:
                yield values, scene

    def _scene(self, values: Values) -> Scene | None:
        try:
            return self.machine.scenes(values, self.name)[0]
        except PlanterError:
            return None

    @cached_property
    def _frame(self) -> Frame:
        """A fixed frame of the drawing, which encloses the scenes at the bounds of every single
        number.
        """
        controls = self.machine.controls
        initial = {control.path: control.value for control in controls}
        moved = [
            initial | {control.path: end}
            for control in controls
            for end in (control.lower, control.upper)
        ]
        scenes = [scene for values in moved if (scene := self._scene(values)) is not None]
        return _join(
            [
                Picture(scene).frames[0]
                for scene in (*scenes, *(scene for _, scene in self._designs))
            ]
        )


def _join(frames: Sequence[Frame]) -> Frame:
    """Return the smallest frame that encloses all frames."""
    left, bottom = min(frame.left for frame in frames), min(frame.bottom for frame in frames)
    right, top = (
        max(frame.left + frame.width for frame in frames),
        max(frame.bottom + frame.height for frame in frames),
    )
    return Frame(left, bottom, right - left, top - bottom)


def _shape(scene: Scene) -> list[int]:
    """Return the numbers of points of each line, and of bodies, points, chains, forces, curves and
    labels.
    """
    parts = (
        list(scene.all_bodies()),
        scene.points,
        scene.chains,
        scene.forces,
        scene.curves,
        scene.labels,
    )
    return [*(len(outline.points) for outline in list_outlines(scene)), *map(len, parts)]
