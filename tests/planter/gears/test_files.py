"""Files of toothed gears, read back: closed and clean, where the exact outline is, of its area;
solids and meshes.
"""

import io
import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from planter.gear_geometry import cutting, pitch_curves
from planter.gear_geometry.cutting import ToothOrder
from planter.gears.parts import GearPart, PartSettings, PlacedGear
from planter.kernels import Array
from planter.planting import file
from planter.planting.model import Device
from planter.workshop.arcs import Arcs
from planter.workshop.drawing import Bore, Keyway
from tests.support.cli import answer, refusal
from tests.support.outlines import between, read_dxf, sampled

TOLERANCE, WIDTH, MM = 1e-6, 0.01, 1e3
FINE = np.linspace(0, 1, 801)
MADE = PartSettings(TOLERANCE, Bore(0.012, Keyway(0.004, 0.0018)), WIDTH, step=False, stl=True)


@pytest.fixture(scope="module")
def parts() -> list[GearPart]:
    device = Device(file.load("wang2017"))
    outlines = []
    for number, stage in enumerate(device.stages):
        curves = pitch_curves.build_stage_pair(stage, device.of_stage(number, device.design))
        gears = cutting.cut_teeth(
            curves, ToothOrder(teeth=31), f"stage {number}", (f"inner {number}", f"outer {number}")
        ).gears
        outlines += [GearPart(PlacedGear(gear, key=0.3), MADE) for gear in gears]
    return outlines


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
        "KEYWAY": 1,
        "CENTRE": 2,
    }
    (outline,) = drawing["TEETH"]
    assert outline.closed
    return outline


def off(part: GearPart, places: Array) -> float:
    """How far places (n, 2) are from the exact outline at most [m], across it where many places on
    it are nearest.
    """
    pieces = part.placed.gear.outline().pieces
    exact = np.vstack([piece.at(FINE) for piece in pieces])
    tangents = np.vstack([piece.tangent(FINE) for piece in pieces])
    distance, nearest = cKDTree(exact).query(places)
    across = np.column_stack([-tangents[nearest, 1], tangents[nearest, 0]])
    offsets: Array = np.minimum(np.abs(((places - exact[nearest]) * across).sum(axis=1)), distance)
    return float(offsets.max())


def strays(part: GearPart, outline: Arcs) -> float:
    """How far an outline of arcs and the exact one are apart, as seen from either [m]."""
    exact = np.vstack(
        [piece.at(np.linspace(0, 1, 6)) for piece in part.placed.gear.outline().pieces]
    )
    return max(off(part, sampled(outline, 9)), float(between(exact, outline).max()))


@pytest.mark.parametrize("number", range(4))
def test_drawing_is_closed_clean_and_within_tolerance(
    parts: list[GearPart], files: list[dict[str, bytes]], number: int
) -> None:
    part, outline = parts[number], read_part(parts[number], files[number])
    assert strays(part, outline) <= TOLERANCE
    assert outline.area == pytest.approx(part.placed.gear.area, rel=5e-6)
    assert len(outline.vertices) < 26 * part.placed.gear.z


def test_wrong_side_and_moved_vertex_are_detected(
    parts: list[GearPart], files: list[dict[str, bytes]]
) -> None:
    outline = read_part(parts[0], files[0])
    bulges, vertices = outline.bulges.copy(), outline.vertices.copy()
    bulges[int(np.argmin(bulges * np.hypot(*outline.chords.T)))] *= -1
    vertices[100] *= 1 + 5e-6 / np.hypot(*vertices[100])
    for tampered in (replace(outline, bulges=bulges), replace(outline, vertices=vertices)):
        assert strays(parts[0], tampered) > 2 * TOLERANCE


def test_a_mesh_is_watertight_and_has_the_volume(
    parts: list[GearPart], files: list[dict[str, bytes]]
) -> None:
    for part, contents in zip(parts, files, strict=True):
        body = trimesh.load(io.BytesIO(contents[f"{part.stem}.stl"]), file_type="stl")
        assert body.is_watertight
        assert part.bore is not None
        area = part.placed.gear.area - part.bore.edge.area
        assert body.volume == pytest.approx(area * WIDTH * MM**3, rel=1e-4)


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


def test_a_solid_reads_back_valid_and_where_the_outline_is(
    parts: list[GearPart], tmp_path: Path
) -> None:
    pytest.importorskip("OCP", reason="planter[step] is not installed: Open CASCADE, 477 MB")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader

    part = replace(parts[0], settings=replace(MADE, step=True, stl=False))
    (tmp_path / "gear.step").write_bytes(dict(part.files())[f"{part.stem}.step"])
    reader = STEPControl_Reader()
    reader.ReadFile(str(tmp_path / "gear.step"))
    reader.TransferRoots()
    shape, properties = reader.OneShape(), GProp_GProps()
    assert BRepCheck_Analyzer(shape).IsValid()
    BRepGProp.VolumeProperties_s(shape, properties)
    assert part.bore is not None
    area = part.placed.gear.area - part.bore.edge.area
    assert properties.Mass() == pytest.approx(area * WIDTH * MM**3, rel=1e-5)
    assert off(part, np.array(list(_edges(shape)))) < 2e-7


def _edges(shape) -> Iterator[tuple[float, float]]:  # type: ignore[no-untyped-def]
    """Places along the splines of a solid's lower face [m]."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_CurveType
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    seen = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
    while seen.More():
        curve = BRepAdaptor_Curve(TopoDS.Edge(seen.Current()))
        if curve.GetType() == GeomAbs_CurveType.GeomAbs_BSplineCurve:
            for u in np.linspace(curve.FirstParameter(), curve.LastParameter(), 11):
                point = curve.Value(float(u))
                yield point.X() / MM, point.Y() / MM
        seen.Next()


@pytest.mark.long
def test_gears_command_lists_files(tmp_path: Path) -> None:
    result = answer(
        "gears", "wang2017", "--teeth", "31,31", "--bore-mm", "12", "--out", str(tmp_path)
    )
    names = {Path(name).name for name in result["files"]}
    assert names >= {
        "assembly.dxf",
        "assembly.svg",
        "sun.dxf",
        "gear_5.svg",
        "gear_6_flanks.csv",
        "planet_gear.dxf",
    }
    assert all((tmp_path / name).is_file() for name in names)
    assert json.loads((tmp_path / "summary.json").read_text())["stages"] == result["stages"]
    document, lines = read_dxf((tmp_path / "assembly.dxf").read_bytes())
    assert not document.audit().errors
    assert len(lines["TEETH"]) == 4


def test_bore_into_roots_and_missing_extra_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    call = ("gears", "wang2017", "--teeth", "31,31")
    assert "a bore of 46 mm" in refusal(*call, "--bore-mm", "46")
    monkeypatch.setitem(sys.modules, "OCP.Message", None)
    message = refusal(*call, "--step", "--out", str(tmp_path))
    assert "pip install 'planter[step]'" in message
