"""Drawings read back: closed outlines in mm, on their layers, clean, the same bytes each time."""

import numpy as np
import pytest
from ezdxf.entitydb import EntityDB

from planter.workshop import drawing
from planter.workshop.arcs import build_circle, fit_arcs
from planter.workshop.drawing import Bore, DrawingLine, Keyway
from tests.support.outlines import lobes, read_dxf

TOOTHED = fit_arcs(lobes(), 1e-6).arcs
LINES = (
    DrawingLine("TEETH", TOOTHED),
    *Bore(0.01, Keyway(0.003, 0.0014, 0.4)).lines(),
    *drawing.build_cross((0.0, 0.0), 0.04),
)


def test_a_drawing_reads_back_as_it_was() -> None:
    document, found = read_dxf(drawing.format_dxf(LINES))
    audit = document.audit()
    assert not audit.errors
    assert not audit.fixes
    assert (document.dxfversion, document.units, document.header["$MEASUREMENT"]) == ("AC1024", 4, 1)
    assert {layer: [arcs.closed for arcs in lines] for layer, lines in found.items()} == {
        "TEETH": [True], "BORE": [True], "KEYWAY": [True], "CENTRE": [False, False],
    }  # fmt: skip
    np.testing.assert_allclose(found["TEETH"][0].vertices, TOOTHED.vertices, rtol=1e-15, atol=1e-18)
    assert found["TEETH"][0].area == pytest.approx(TOOTHED.area, rel=1e-13)
    assert document.layers.get("CENTRE").dxf.linetype == "CENTER"


def test_same_curves_give_the_same_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    """In any order in which a set of texts is gone through, which is another in each process."""
    kinds = ["ACDBPLACEHOLDER", "LAYOUT", "LWPOLYLINE"]
    files = []
    for order in (kinds, kinds[::-1]):
        monkeypatch.setattr(EntityDB, "dxf_types_in_use", lambda _, order=order: order)
        files.append(drawing.format_dxf(LINES))
    assert files[0] == files[1]
    assert drawing.format_dxf(LINES) != drawing.format_dxf(LINES[1:])


def test_the_preview_has_the_arcs_of_the_drawing() -> None:
    hollow = DrawingLine("TEETH", TOOTHED)
    told = drawing.format_svg([hollow, DrawingLine("BORE", build_circle(0.005))], "a < b")
    assert "<title>a &lt; b</title>" in told
    data = drawing.format_path(TOOTHED)
    sweeps = [int(arc.split()[4]) for arc in data.removesuffix("Z").split("A")[1:]]
    np.testing.assert_array_equal(sweeps, TOOTHED.bulges < 0)
