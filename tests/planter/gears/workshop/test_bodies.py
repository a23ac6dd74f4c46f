"""Solids and meshes read back: valid, closed, of the outline's area times the width, where the
outline is.
"""

import io
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from planter.errors import InputError
from planter.gears.workshop import arcs, solids
from planter.gears.workshop.drawing import Bore, Keyway
from planter.gears.workshop.solids import fit_spline
from tests.support.outlines import Lobes, lobes

WIDTH = 0.008
BORE = Bore(0.01, Keyway(0.003, 0.0014, 0.4))
EXACT = Lobes(0, 2 * np.pi)
VOLUME = (EXACT.area - BORE.edge.area) * WIDTH


def test_a_mesh_is_watertight_and_has_the_volume() -> None:
    outline = arcs.fit_arcs(lobes(), 1e-6).arcs
    body = trimesh.load(
        io.BytesIO(solids.format_stl(outline, [BORE.edge], WIDTH, 1e-6)), file_type="stl"
    )
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(VOLUME * 1e9, rel=1e-4)
    np.testing.assert_allclose(body.extents[2], WIDTH * 1e3, rtol=1e-7)


def test_a_mesh_with_a_triangle_less_is_not_watertight() -> None:
    body = trimesh.load(
        io.BytesIO(solids.format_stl(arcs.fit_arcs(lobes(), 1e-4).arcs, [], WIDTH, 1e-4)),
        file_type="stl",
    )
    body.update_faces(np.arange(len(body.faces)) > 0)
    assert not body.is_watertight


def test_splines_keep_to_their_pieces() -> None:
    for piece in (Lobes(0.1, 0.9).piece, Lobes(0.9, 2.2).piece):
        spline = fit_spline("piece", piece.at, 1e-8, piece.tangent)
        assert sum(spline.multiplicities) == len(spline.poles) + spline.degree + 1
        np.testing.assert_allclose(spline.poles[[0, -1]], [piece.start, piece.end], rtol=1e-13)


def test_a_solid_reads_back_valid_where_the_outline_is(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("OCP", reason="planter[step] is not installed: Open CASCADE, 477 MB")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader

    content = solids.format_prism("gear 'A'", lobes(), [BORE.edge], WIDTH)
    assert content == solids.format_prism("gear 'A'", lobes(), [BORE.edge], WIDTH)
    assert capfd.readouterr() == ("", "")
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
