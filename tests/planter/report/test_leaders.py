"""Names in drawings: leaders cross neither bodies nor each other, texts do not overlap, and every body
has one name; measured by the scene's own geometry in a browser.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, sync_playwright
from shapely import Geometry, LineString, Point, Polygon, box

from planter.report.animation import MotionBlock
from planter.report.html import Section, render_page
from planter.report.scene import Body, Scene
from planter.report.subject import open_machine
from tests.support import own
from tests.support.browser import browser
from tests.support.scenes import placed

LINKAGES = ("slider_crank", "crank_rocker", "cam_follower", "watt_six_bar", "planetary_train")
"""Templates of `planter new` in which every leader finds a free way."""
CROWDED = {"yu2023": 1, "wang2017": 2}
"""Crossings that are let pass in a drawing where bodies lie on each other."""
SHARES = (0.0, 0.17, 0.35, 0.5, 0.68, 0.85)
"""Shares of a cycle at which drawings are measured."""
GAP_PX, ROUNDING_PX = 22.0, 0.1
"""Least distance of names of bodies, and rounding of places."""
TOUCHING_MM = 0.5
"""Distance from its beginning within which a leader touches its own body."""
STATE = """(moment) => {
  const scrub = document.querySelector(".planter-view input[type=range]");
  scrub.value = moment;
  scrub.dispatchEvent(new Event("input"));
  const texts = [...document.querySelectorAll("svg.mechanism .names text")];
  return {
    leaders: [...document.querySelectorAll("svg.mechanism .leader")].map((line) => line.getAttribute("d")),
    names: texts.map((text) => text.textContent),
    boxes: texts.map((text) => text.getBBox()).map(({ x, y, width, height }) => [x, y, x + width, y + height]),
    heights: texts.map((text) => text.getBoundingClientRect()).map(({ top }) => top),
  };
}"""


@dataclass(frozen=True)
class Labelled:
    """What a page draws beside a scene at a moment."""

    scene: Scene
    moment: int
    leaders: dict[str, LineString]
    boxes: dict[str, Polygon]
    heights: list[float]

    @classmethod
    def read(cls, scene: Scene, moment: int, state: dict[str, Any]) -> Labelled:
        paths = [
            np.array(path[1:].split(), dtype=float).reshape(-1, 2) for path in state["leaders"]
        ]
        lines = [LineString(path * [1, -1]) for path in paths]
        leaders = dict(zip(state["names"], lines, strict=False))
        boxes = {
            name: box(*edges) for name, edges in zip(state["names"], state["boxes"], strict=True)
        }
        return cls(scene, moment, leaders, boxes, sorted(state["heights"][: len(lines)]))

    def crossings(self) -> list[tuple[str, str]]:
        """Return names of leaders with what they cross: bodies, or other leaders."""
        crossed = [
            (name, owner)
            for name, leader in self.leaders.items()
            for owner, line in self._bodies()
            if is_crossed(leader, line, owner == name)
        ]
        pairs = combinations(self.leaders.items(), 2)
        return crossed + [(name, other) for (name, a), (other, b) in pairs if a.intersects(b)]

    def overlaps(self) -> list[tuple[str, str]]:
        """Return names whose texts overlap."""
        pairs = combinations(self.boxes.items(), 2)
        return [(name, other) for (name, a), (other, b) in pairs if a.intersection(b).area > 0]

    def _bodies(self) -> Iterator[tuple[str, LineString]]:
        solid = replace_outlines(self.scene)
        for name, lines in placed(solid, self.moment).items():
            for line in lines:
                yield name.partition("#")[0], line
        for chain in self.scene.chains:
            corners = [self.scene.points[k] for k in chain.points]
            places = [
                [np.broadcast_to(v, self.scene.moments)[self.moment] for v in (p.x, p.y)]
                for p in corners
            ]
            yield chain.name, LineString(places + places[:1] if chain.closed else places)


def replace_outlines(scene: Scene) -> Scene:
    """Return a scene with the outlines of bodies that are seen as such, each body under its own name."""
    numbers = iter(range(1000))

    def solid(body: Body) -> Body:
        outlines = [
            line for line in body.outlines if line.look in ("body", "gear", "frame", "line")
        ]
        parts = [solid(part) for part in body.parts]
        return replace(body, name=f"{body.name}#{next(numbers)}", outlines=outlines, parts=parts)

    return replace(scene, bodies=[solid(body) for body in scene.bodies])


def is_crossed(leader: LineString, line: LineString, is_own: bool) -> bool:
    """Return whether a leader crosses a line; it may touch its own body where it begins, and leave an
    outline that encloses its beginning once.
    """
    common: Geometry = leader.intersection(line)
    if common.is_empty:
        return False
    start = Point(leader.coords[0])
    if is_own:
        return bool(common.hausdorff_distance(start) > TOUCHING_MM)
    is_enclosed = line.is_closed and Polygon(line).contains(start)
    return not (is_enclosed and common.geom_type == "Point")


@cache
def scene_of(name: str) -> Scene:
    built_in = name in CROWDED
    view = open_machine(name if built_in else str(own.generated(name) / f"{name}.toml"), {})
    values = {control.path: control.value for control in view.controls}
    return view.scenes(values, view.models[0])[0]


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    with (
        sync_playwright() as play,
        play.chromium.launch(executable_path=browser(), args=["--no-sandbox"]) as chromium,
    ):
        yield chromium.new_page(viewport={"width": 900, "height": 900})


def draw(page: Page, scene: Scene, folder: Path) -> list[Labelled]:
    file = folder / "scene.html"
    text = render_page("A machine", [Section("Motion", [MotionBlock(scene)])])
    file.write_text(text, encoding="utf-8")
    page.goto(file.as_uri())
    page.wait_for_selector("svg.mechanism .names")
    moments = [int(share * scene.moments) for share in SHARES]
    return [Labelled.read(scene, moment, page.evaluate(STATE, moment)) for moment in moments]


@pytest.mark.parametrize("name", [*LINKAGES, *CROWDED])
def test_leaders_cross_nothing(name: str, page: Page, tmp_path: Path) -> None:
    scene = scene_of(name)
    for drawing in draw(page, scene, tmp_path):
        assert len(drawing.crossings()) <= CROWDED.get(name, 0), drawing.crossings()
        assert drawing.overlaps() == []
        assert min(np.diff(drawing.heights)) > GAP_PX - ROUNDING_PX
        named = {body.name for body in replace_outlines(scene).all_bodies() if body.outlines}
        expected = {name.partition("#")[0] for name in named} | {
            chain.name for chain in scene.chains
        }
        assert expected <= drawing.leaders.keys()


def test_crossing_leaders_are_noticed(page: Page, tmp_path: Path) -> None:
    """Tampered: two leaders exchanged at their ends, one from the far side of its own body, and a text
    on another.
    """
    drawing = draw(page, scene_of("slider_crank"), tmp_path)[0]
    (name, first), (other, second) = list(drawing.leaders.items())[:2]
    exchanged = {
        name: LineString([first.coords[0], second.coords[-1]]),
        other: LineString([second.coords[0], first.coords[-1]]),
    }
    assert replace(drawing, leaders=exchanged).crossings()
    covered = replace(drawing, boxes=drawing.boxes | {name: drawing.boxes[other]})
    assert covered.overlaps() == [(name, other)]
    cam = draw(page, scene_of("cam_follower"), tmp_path)[0]
    x, y = cam.leaders["cam"].coords[0]
    through = LineString([(-x, -y), cam.leaders["cam"].coords[-1]])
    assert ("cam", "cam") in replace(cam, leaders={"cam": through}).crossings()


def test_traces_of_moving_points_with_couplers_first(page: Page, tmp_path: Path) -> None:
    draw(page, scene_of("crank_rocker"), tmp_path)
    choices = page.locator(".planter-view .choices label").all_inner_texts()
    names = [text.strip() for text in choices]
    paths = [name.removeprefix("path of ") for name in names if name.startswith("path of ")]
    assert paths[0] == "S"  # of the coupler
    assert sorted(paths[1:]) == ["A", "B", "R"]  # O and D are fixed
