"""Drawings, solids and meshes read back, bores and keyways."""

from __future__ import annotations

import io
import re
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import trimesh
from ezdxf.entitydb import EntityDB

from planter.errors import InputError
from planter.gears.workshop import arcs, drawing, solids
from planter.gears.workshop.arcs import build_circle, fit_arcs
from planter.gears.workshop.drawing import (
    Bore,
    DrawingLine,
    Keyway,
    check_wall,
    find_standard_keyway,
)
from planter.gears.workshop.solids import fit_spline
from planter.version import __version__
from tests.support.outlines import Lobes, lobes, read_dxf

TOOTHED = fit_arcs(lobes(), 1e-6)
LINES = (
    DrawingLine("TEETH", TOOTHED),
    *Bore(0.01, Keyway(0.003, 0.0014, 0.4)).lines(),
    *drawing.build_cross((0.0, 0.0), 0.04),
)


def test_written_drawing_reads_back() -> None:
    document, entities = read_dxf(drawing.format_dxf(LINES))
    audit = document.audit()
    assert not audit.errors
    assert not audit.fixes
    assert (document.dxfversion, document.units, document.header["$MEASUREMENT"]) == (
        "AC1024",
        4,
        1,
    )
    assert {layer: [arcs.closed for arcs in lines] for layer, lines in entities.items()} == {
        "TEETH": [True],
        "BORE": [True],
        "CENTRE": [False, False],
    }
    np.testing.assert_allclose(
        entities["TEETH"][0].vertices, TOOTHED.vertices, rtol=1e-15, atol=1e-18
    )
    assert entities["TEETH"][0].area == pytest.approx(TOOTHED.area, rel=1e-13)
    assert document.layers.get("CENTRE").dxf.linetype == "CENTER"


def test_same_curves_give_the_same_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The order of a set of texts, which differs between processes, does not matter."""
    kinds = ["ACDBPLACEHOLDER", "LAYOUT", "LWPOLYLINE"]
    files = []
    for order in (kinds, kinds[::-1]):
        monkeypatch.setattr(EntityDB, "dxf_types_in_use", lambda _, order=order: order)
        files.append(drawing.format_dxf(LINES))
    assert files[0] == files[1]
    assert drawing.format_dxf(LINES) != drawing.format_dxf(LINES[1:])


def test_preview_has_the_arcs_of_the_drawing() -> None:
    hollow = DrawingLine("TEETH", TOOTHED)
    preview = drawing.format_svg([hollow, DrawingLine("BORE", build_circle(0.005))], "a < b")
    assert "<title>a &lt; b</title>" in preview
    data = drawing.format_path(TOOTHED)
    sweeps = [int(arc.split()[4]) for arc in data.removesuffix("Z").split("A")[1:]]
    np.testing.assert_array_equal(sweeps, TOOTHED.bulges < 0)


@pytest.mark.parametrize("phase", [0.0, 2.3])
def test_edge_area_is_sum_of_bore_and_slot(phase: float) -> None:
    bore = Bore(0.02, Keyway(0.006, 0.0028, phase))
    (line,) = bore.lines()  # one contour, which a cutter follows
    assert line.layer == "BORE"
    half = np.arcsin(0.3)
    cap = 0.01**2 * (half - np.sin(half) * np.cos(half))
    slot = 0.006 * (0.0128 - 0.01 * np.cos(half)) - cap
    assert line.arcs.area == pytest.approx(np.pi * 0.01**2 + slot, rel=1e-12)
    assert line.arcs.area > Bore(0.02).edge.area + 0.99 * slot
    far = bore.edge.vertices[np.hypot(*bore.edge.vertices.T) > 0.0101].mean(axis=0)
    assert np.arctan2(far[1], far[0]) == pytest.approx(np.arctan2(np.sin(phase), np.cos(phase)))


@pytest.mark.parametrize(
    ("bore_mm", "keyway_mm"), [(8, (2, 1.0)), (17, (5, 2.3)), (17.5, (6, 2.8)), (40, (12, 3.3))]
)
def test_keyways_agree_with_the_standard(bore_mm: float, keyway_mm: tuple[float, float]) -> None:
    assert find_standard_keyway(bore_mm / 1e3) == pytest.approx([mm / 1e3 for mm in keyway_mm])


@pytest.mark.parametrize("bore_mm", [6, 131])
def test_bores_without_a_standard_keyway_are_refused(bore_mm: float) -> None:
    with pytest.raises(
        InputError,
        match=rf"a bore of {bore_mm} mm has no keyway in DIN 6885-1: choose a bore over 6 mm",
    ):
        find_standard_keyway(bore_mm / 1e3)


def test_bore_leaves_a_wall() -> None:
    part = build_circle(0.012, (0.003, 0.0))
    assert check_wall(Bore(0.0178), part, "sun", 1e-5) == pytest.approx(1e-4, abs=2e-6)
    assert check_wall(Bore(0.016, Keyway(0.004, 0.002, 0.0)), part, "sun", 5e-4) == pytest.approx(
        1e-3, abs=2e-6
    )
    for bore, wall, message in (
        (Bore(0.0181), 1e-5, r"sun: a bore of 18.1 mm leaves .* smallest radius is 9 mm"),
        (Bore(0.0178), 2e-4, r"leaves a wall of 0.\d+ mm; at least 0.2 mm"),
        (
            Bore(0.016, Keyway(0.004, 0.002, np.pi)),
            1e-5,
            r"with its keyway 10.2 mm from the axis, leaves",
        ),
    ):
        with pytest.raises(InputError, match=message):
            check_wall(bore, part, "sun", wall)
    with pytest.raises(InputError, match=r"keyway width = 9 mm"):
        Bore(0.009, Keyway(0.009, 0.001))


WIDTH = 0.008
BORE = Bore(0.01, Keyway(0.003, 0.0014, 0.4))
EXACT = Lobes(0, 2 * np.pi)
VOLUME = (EXACT.area - BORE.edge.area) * WIDTH


def test_a_mesh_is_watertight_and_has_the_volume() -> None:
    outline = arcs.fit_arcs(lobes(), 1e-6)
    body = trimesh.load(
        io.BytesIO(solids.format_stl(outline, [BORE.edge], WIDTH, 1e-6)), file_type="stl"
    )
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(VOLUME * 1e9, rel=1e-4)
    np.testing.assert_allclose(body.extents[2], WIDTH * 1e3, rtol=1e-7)


def test_a_mesh_with_a_triangle_less_is_not_watertight() -> None:
    body = trimesh.load(
        io.BytesIO(solids.format_stl(arcs.fit_arcs(lobes(), 1e-4), [], WIDTH, 1e-4)),
        file_type="stl",
    )
    body.update_faces(np.arange(len(body.faces)) > 0)
    assert not body.is_watertight


def test_splines_keep_to_their_pieces() -> None:
    for piece in (Lobes(0.1, 0.9).piece, Lobes(0.9, 2.2).piece):
        spline = fit_spline("piece", piece.at, 1e-8, piece.tangent)
        np.testing.assert_allclose(spline.c[[0, -1]], [piece.start, piece.end], rtol=1e-13)
        shares = np.linspace(0, 1, 41)
        off = EXACT.off(spline(spline.t[-1] * shares))
        assert off.max() < 2e-8


def test_a_solid_reads_back_valid_where_the_outline_is(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(solids.CLOCK, "86400")
    pytest.importorskip("OCP", reason="planter[step] is not installed: Open CASCADE, 477 MB")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader

    content = solids.format_prism("gear 'A'", lobes(), [BORE.edge], WIDTH)
    assert content == solids.format_prism("gear 'A'", lobes(), [BORE.edge], WIDTH)
    assert capfd.readouterr() == ("", "")
    check_header(content, "gear  A ", "1970-01-02T00:00:00")
    (tmp_path / "gear.step").write_bytes(content)
    reader = STEPControl_Reader()
    reader.ReadFile(str(tmp_path / "gear.step"))
    reader.TransferRoots()
    shape, properties = reader.OneShape(), GProp_GProps()
    assert BRepCheck_Analyzer(shape).IsValid()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-9)
    assert properties.Mass() == pytest.approx(VOLUME * 1e9, rel=1e-5)
    outer, splines = _splines(shape)
    assert splines == 2 * len(lobes())
    assert EXACT.off(outer / 1e3).max() < 2e-7


def check_header(content: bytes, name: str, date: str) -> None:
    """Assert that a STEP file names its part, the date, and planter."""
    (head,) = re.findall(rb"FILE_NAME\(.*?\);", content, re.DOTALL)
    assert head.startswith(f"FILE_NAME('{name}','{date}',".encode())
    assert f"'planter {__version__}'".encode() in head


SAMPLE = b"""HEADER;
FILE_NAME('Open CASCADE Shape Model','2026-01-01T00:00:00',('Author'),(
    'Open CASCADE'),'Open CASCADE STEP processor 7.8','Open CASCADE 7.8'
  ,'Unknown');
#7 = PRODUCT('Open CASCADE 7.8 1','Open CASCADE 7.8 1','',(#8));
"""


def test_step_header_has_planter_and_the_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(solids.CLOCK, "0")
    content = solids.head_step(SAMPLE, "sun")
    check_header(content, "sun", "1970-01-01T00:00:00")
    assert b"PRODUCT('sun','sun','',(#8));" in content
    monkeypatch.delenv(solids.CLOCK)
    (date,) = re.findall(rb"'(\d{4}-[^']*)'", solids.head_step(SAMPLE, "sun"))
    past = datetime.now(UTC) - datetime.fromisoformat(date.decode()).replace(tzinfo=UTC)
    assert abs(past.total_seconds()) < 60
    monkeypatch.setenv(solids.CLOCK, "soon")
    with pytest.raises(InputError, match="SOURCE_DATE_EPOCH = soon"):
        solids.head_step(SAMPLE, "sun")


def _splines(shape):  # type: ignore[no-untyped-def]
    """Places along the spline edges of a shape [mm], and how many edges there are."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_CurveType
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    places, seen = [], TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
    count = 0
    while seen.More():
        curve = BRepAdaptor_Curve(TopoDS.Edge(seen.Current()))
        if curve.GetType() == GeomAbs_CurveType.GeomAbs_BSplineCurve:
            count += 1
            for u in np.linspace(curve.FirstParameter(), curve.LastParameter(), 101):
                point = curve.Value(float(u))
                places.append((point.X(), point.Y()))
        seen.Next()
    return np.array(places), count // 2


def test_missing_kernel_error_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OCP.Message", None)
    with pytest.raises(InputError, match=r"not installed: pip install 'planter\[step\]'"):
        solids.format_prism("gear", lobes(), [], WIDTH)
