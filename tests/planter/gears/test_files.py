"""Files of toothed gears, read back: closed and clean, where the exact outline is, of its area."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from planter.gears.geometry import cutting, pitch_curves
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.parts import GearPart, PartSettings, PlacedGear
from planter.gears.workshop.arcs import Arcs
from planter.gears.workshop.drawing import Bore, Keyway
from planter.kernels import Array
from planter.papers.planting import file
from planter.papers.planting.model import Device
from tests.support.outlines import between, read_dxf, sampled

TOLERANCE, WIDTH, MM = 1e-6, 0.01, 1e3
FINE = np.linspace(0, 1, 801)
MADE = PartSettings(TOLERANCE, Bore(0.012, Keyway(0.004, 0.0018)), WIDTH, step=False, stl=False)


@pytest.fixture(scope="module")
def parts() -> list[GearPart]:
    device = Device(file.load("wang2017"))
    curves = pitch_curves.build_stage_pair(device.stages[1], device.of_stage(1, device.design))
    pair = cutting.cut_teeth(curves, ToothOrder(teeth=31), "stage", ("inner", "outer"))
    return [GearPart(PlacedGear(gear, key=0.3), MADE) for gear in pair.gears]


@pytest.fixture(scope="module")
def files(parts: list[GearPart]) -> list[dict[str, bytes]]:
    return [dict(part.files()) for part in parts]


def read_part(part: GearPart, contents: dict[str, bytes]) -> Arcs:
    """The outline of a gear's drawing, read back."""
    document, drawing = read_dxf(contents[f"{part.stem}.dxf"])
    audit = document.audit()
    assert not audit.errors + audit.fixes
    assert {layer: len(lines) for layer, lines in drawing.items()} == {
        "TEETH": 1,
        "PITCH": 1,
        "BORE": 1,
        "CENTRE": 2,
    }
    (outline,) = drawing["TEETH"]
    assert outline.closed
    return outline


def off(part: GearPart, places: Array) -> float:
    """How far places (n, 2) are from the exact outline at most [m], across it where many places on
    it are nearest.
    """
    pieces = part.placed.gear.outline()
    exact = np.vstack([piece.at(FINE) for piece in pieces])
    tangents = np.vstack([piece.tangent(FINE) for piece in pieces])
    distance, nearest = cKDTree(exact).query(places)
    across = np.column_stack([-tangents[nearest, 1], tangents[nearest, 0]])
    offsets: Array = np.minimum(np.abs(((places - exact[nearest]) * across).sum(axis=1)), distance)
    return float(offsets.max())


def strays(part: GearPart, outline: Arcs) -> float:
    """How far an outline of arcs and the exact one are apart, as seen from either [m]."""
    exact = np.vstack([piece.at(np.linspace(0, 1, 6)) for piece in part.placed.gear.outline()])
    return max(off(part, sampled(outline, 9)), float(between(exact, outline).max()))


@pytest.mark.parametrize("number", range(2))
def test_drawing_is_closed_clean_and_within_tolerance(
    parts: list[GearPart], files: list[dict[str, bytes]], number: int
) -> None:
    part, outline = parts[number], read_part(parts[number], files[number])
    assert strays(part, outline) <= TOLERANCE
    assert outline.area == pytest.approx(part.placed.gear.area, rel=5e-6)
    assert len(outline.vertices) < 26 * part.placed.gear.z


def test_a_table_holds_places_of_the_outline(
    parts: list[GearPart], files: list[dict[str, bytes]]
) -> None:
    text = files[1][f"{parts[1].stem}_flanks.csv"].decode()
    head, *rows = (line.split(",") for line in text.splitlines() if not line.startswith("#"))
    x, y = head.index("x_mm"), head.index("y_mm")
    places = np.array([[float(row[x]), float(row[y])] for row in rows]) / MM
    assert off(parts[1], places) < 1e-9
    assert {row[head.index("piece")] for row in rows} == {"tip", "flank", "fillet", "root"}
    assert {int(row[head.index("tooth")]) for row in rows} == set(range(31))
