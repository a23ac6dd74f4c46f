"""A page without a server, and what stands in it for its script."""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.report.scene import Scene
from tests.support.wasm import Running

TWELVE = 1e-12
"""Of the largest number of a series, of a reading's own size, of the largest slope."""
Values = Mapping[str, float]


@dataclass(frozen=True)
class Told:
    """A page and what stands in it for its script."""

    file: Path

    @cached_property
    def html(self) -> str:
        return self.file.read_text(encoding="utf-8")

    @cached_property
    def machine(self) -> dict[str, Any]:
        match = re.search(
            r'<script type="application/json" id="machine">(.*?)</script>', self.html, re.DOTALL
        )
        assert match
        machine: dict[str, Any] = json.loads(match[1])
        return machine

    @cached_property
    def module(self) -> bytes:
        return gzip.decompress(base64.b64decode(self.machine["module"]))

    @cached_property
    def running(self) -> Running:
        return Running(self.module)

    def numbers(
        self, model: str, part: str, values: Values, running: Running | None = None
    ) -> Array:
        """All numbers of a model's program, `seen` or `descent`, as the page's script runs it."""
        program = self.machine["models"][model][part]
        inputs = {item["at"]: values[item["path"]] * item["factor"] for item in program["inputs"]}
        results = (running or self.running).run(
            program["name"], self.machine["programs"][program["name"]], inputs
        )
        assert results is not None
        return results

    def readings(
        self, model: str, values: Values, running: Running | None = None
    ) -> dict[str, float]:
        numbers = self.numbers(model, "seen", values, running)
        return {
            output["name"]: numbers[output["at"]]
            for output in self.machine["models"][model]["readings"]
        }

    def designs(self, count: int) -> list[dict[str, float]]:
        """The page's own numbers, then some by lot within their ends."""
        rng, controls = np.random.default_rng(7), self.machine["controls"]
        values = {control["path"]: control["value"] for control in controls}
        return [
            values,
            *(
                {c["path"]: float(rng.uniform(c["lower"], c["upper"])) for c in controls}
                for _ in range(count)
            ),
        ]


def written(folder: Path, machine: str) -> Told:
    """A page as the command writes it."""
    from planter.studio.static_page import write_page

    return Told(write_page(machine, folder / "page.html"))


def assert_drawn(plan: Mapping[str, Any], numbers: Array, scene: Scene) -> None:
    """Every series, place, outline and label of a plan is the scene's."""
    lines = [*scene.ground, *(line for body in scene.all_bodies() for line in body.outlines)]
    for place, source in plan["channels"]:
        assert_same(taken(numbers, source), series(scene, place))
    for line in plan["outlines"]:
        page = (
            np.array([taken(numbers, row) for row in line["rows"]]).T
            if "rows" in line
            else np.array(
                [[taken(numbers, source) for source in corner] for corner in line["corners"]]
            )
        )
        assert_same(page, lines[line["number"]].points)
    for number, x, y in plan["labels"]:
        label = scene.labels[number]
        assert_same(np.array([taken(numbers, x), taken(numbers, y)]), np.array([label.x, label.y]))


def taken(numbers: Array, source: Mapping[str, Any]) -> Any:
    if "count" not in source:
        return source["plus"] + (0.0 if source["at"] < 0 else numbers[source["at"]])
    row = numbers[source["at"] : source["at"] + source["count"]]
    return source["plus"] + source["sign"] * np.roll(row, -source["ahead"])


def series(scene: Any, place: Sequence[Any]) -> Array:
    key, *rest = place
    if not rest:
        return np.asarray(getattr(scene, key))
    if key == "curves":
        return np.asarray(getattr(scene.curves[rest[0]], rest[1]))
    if key == "bodies":
        body = list(scene.all_bodies())[rest[0]]
        return np.asarray((*body.at, body.turn, *body.scale)[rest[1]])
    if key == "points":
        point = scene.points[rest[0]]
        return np.asarray((point.x, point.y)[rest[1]])
    force = scene.forces[rest[0]]
    return np.asarray((force.at.x, force.at.y, force.x, force.y)[rest[1]])


def assert_same(actual: Any, expected: Array) -> None:
    assert np.abs(actual - expected).max() <= TWELVE * max(np.abs(expected).max(), 1.0)
