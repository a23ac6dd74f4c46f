"""The picture of the house, drawn from its imports: `python -m tests.support.picture` writes docs/house.svg.

Rooms stand on floors, each one above all that it imports; on top what finds the others by their shape and imports
none of them. Of the arrows those are drawn that do not follow from others.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from html import escape

from tests.support.house import FOUNDATION, ROOT, House, standing

FINDS = {"cli"}
"""Rooms that find others by their shape."""
PICTURE = ROOT / "docs" / "house.svg"
WIDTH, HEIGHT = 118, 40
GAP, RISE, EDGE, TITLE = 14, 46, 24, 34
INK, PAPER, ROOM, LINE = "#1b2733", "#ffffff", "#eef2f6", "#7b8da0"
FONT = "font-family='DejaVu Sans, Arial, sans-serif'"


@dataclass(frozen=True)
class Box:
    """A room's place on the sheet: left upper corner."""

    x: float
    y: float

    @property
    def middle(self) -> float:
        return self.x + WIDTH / 2


def reduced(house: House) -> list[tuple[str, str]]:
    """The arrows that no chain of other arrows replaces; those to the foundation, which all rest on, are left out."""

    def below(room: str) -> set[str]:
        return house.rooms[room].union(*(below(other) for other in house.rooms[room]))

    return [
        (room, other)
        for room, other in house.arrows
        if other != FOUNDATION and not any(other in below(via) for via in house.rooms[room] - {other})
    ]


def storeys(house: House) -> list[list[str]]:
    """Rooms by floor, the highest first."""
    floors = house.floors
    floors |= {room: max(floors.values()) + 1 for room in floors.keys() & FINDS}
    return [sorted(r for r in floors if floors[r] == level) for level in range(max(floors.values()), -1, -1)]


def said(house: House, room: str) -> str:
    """What a room says of itself: the first clause of its docstring."""
    place = ROOT / house.package / ("" if room == FOUNDATION else room) / "__init__.py"
    return (ast.get_docstring(ast.parse(place.read_text(encoding="utf-8"))) or "").partition("\n")[0]


def drawn(house: House, left: float, width: float) -> tuple[list[str], float]:
    """A house as SVG elements within a width, and its height."""
    rows = storeys(house)
    boxes: dict[str, Box] = {}
    for level, row in enumerate(rows):
        room_for = len(row) * WIDTH + (len(row) - 1) * GAP
        start = left + (width - room_for) / 2
        boxes |= {
            room: Box(start + i * (WIDTH + GAP), EDGE + TITLE + level * (HEIGHT + RISE)) for i, room in enumerate(row)
        }
    lines = [_arrow(boxes[a], boxes[b]) for a, b in reduced(house)]
    rooms = [_room(box, room, said(house, room)) for room, box in boxes.items()]
    title = f"<text x='{left + width / 2}' y='{EDGE + 12}' text-anchor='middle' font-size='15'>{house.package}/</text>"
    return [title, *lines, *rooms], EDGE + TITLE + len(rows) * (HEIGHT + RISE) - RISE + EDGE


def _arrow(start: Box, end: Box) -> str:
    y, below = start.y + HEIGHT, end.y
    bend = (below - y) / 2
    path = f"M{start.middle} {y} C{start.middle} {y + bend} {end.middle} {below - bend} {end.middle} {below - 5}"
    return f"<path d='{path}' fill='none' stroke='{LINE}' stroke-width='1.1' marker-end='url(#tip)'/>"


def _room(box: Box, name: str, text: str) -> str:
    return (
        f"<g><title>{escape(text)}</title>"
        f"<rect x='{box.x}' y='{box.y}' width='{WIDTH}' height='{HEIGHT}' rx='6' fill='{ROOM}' stroke='{LINE}'/>"
        f"<text x='{box.middle}' y='{box.y + HEIGHT / 2 + 5}' text-anchor='middle' font-size='13.5'>{name}</text></g>"
    )


def picture() -> str:
    """Both houses side by side."""
    houses = [standing(package) for package in ("derive", "planter")]
    widths = [max(len(row) for row in storeys(house)) * (WIDTH + GAP) + 2 * EDGE for house in houses]
    parts: list[str] = []
    left, height = 0.0, 0.0
    for house, width in zip(houses, widths, strict=True):
        elements, tall = drawn(house, left, width)
        parts += elements
        left, height = left + width, max(height, tall)
    head = (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {left} {height}' width='{left}' height='{height}' "
        f"{FONT} fill='{INK}'>\n<defs><marker id='tip' viewBox='0 0 8 8' refX='6' refY='4' markerWidth='7' "
        f"markerHeight='7' orient='auto'><path d='M0 0 L8 4 L0 8 z' fill='{LINE}'/></marker></defs>\n"
        f"<rect width='{left}' height='{height}' fill='{PAPER}'/>\n"
    )
    return head + "\n".join(parts) + "\n</svg>\n"


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
