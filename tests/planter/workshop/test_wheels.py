"""Toothed wheels as files: what each holds, and where an assembly puts them."""

import csv
import io
from dataclasses import dataclass

import numpy as np
import pytest
import trimesh

from planter.errors import InputError
from planter.kernels import Array
from planter.workshop.bores import Bore, Keyway
from planter.workshop.wheels import Wheel, assembly
from tests.support.outlines import Lobes, lobes, read_dxf

TOLERANCE = 1e-6


@dataclass(frozen=True)
class Tooth(Lobes):
    """A piece of the curve that says on which tooth it is."""

    tooth: int = 0
    side: int = 1


@dataclass(frozen=True)
class Outline:
    """Three lobes as a wheel of three teeth."""

    name: str = "gear 5"

    @property
    def pieces(self) -> list[Tooth]:
        return [Tooth(piece.start, piece.end, tooth=i // 4) for i, piece in enumerate(lobes())]

    def pitch(self, s: Array) -> Array:
        return 0.9 * Lobes(0, 2 * np.pi, depth=0.1).at(s)


WHEEL = Wheel("stage1-gear5", Outline(), TOLERANCE, Bore(0.01, Keyway(0.003, 0.0014)), np.pi / 3, (0.06, 0.01))


def test_a_wheel_leaves_drawing_preview_and_table() -> None:
    files = WHEEL.files(["a comment"])
    assert list(files) == ["stage1-gear5.dxf", "stage1-gear5.svg", "stage1-gear5.csv"]
    document, found = read_dxf(files["stage1-gear5.dxf"])
    assert not document.audit().errors
    assert {layer: len(lines) for layer, lines in found.items()} == {
        "TEETH": 1, "PITCH": 1, "BORE": 1, "KEYWAY": 1, "CENTRE": 2,
    }  # fmt: skip
    assert found["TEETH"][0].area == pytest.approx(Lobes(0, 1).area, rel=1e-5)
    lines = files["stage1-gear5.csv"].decode().splitlines()
    assert lines[0] == "# a comment"
    rows = list(csv.DictReader(lines[1:]))
    assert {(row["piece"], row["tooth"], row["side"]) for row in rows} == {("flank", str(i), "1") for i in range(3)}
    places = np.array([[float(row["x_mm"]), float(row["y_mm"])] for row in rows]) / 1e3
    assert Lobes(0, 1).off(places).max() < 1e-15


def test_an_assembly_turns_a_wheel_then_shifts_it() -> None:
    files = assembly([WHEEL, Wheel("a", Outline(), TOLERANCE)], "assembly", "both")
    _, found = read_dxf(files["assembly.dxf"])
    assert len(found["TEETH"]) == 2
    turned = (found["TEETH"][0].vertices - WHEEL.centre) @ [[np.cos(np.pi / 3), -np.sin(np.pi / 3)],
                                                            [np.sin(np.pi / 3), np.cos(np.pi / 3)]]  # fmt: skip
    assert Lobes(0, 1).off(turned).max() < 1e-6
    cross = found["CENTRE"][0].vertices
    np.testing.assert_allclose(cross.mean(axis=0), WHEEL.centre)
    np.testing.assert_allclose(cross[0, 1], cross[1, 1])


def test_a_mesh_has_the_bore() -> None:
    (content,) = WHEEL.stl(0.01).values()
    body = trimesh.load(io.BytesIO(content), file_type="stl")
    assert WHEEL.bore is not None
    assert body.is_watertight
    assert body.volume == pytest.approx((Lobes(0, 1).area - WHEEL.bore.edge.area) * 1e7, rel=1e-4)
    assert body.euler_number == 0


def test_a_bore_into_the_roots_is_refused_by_the_gear_s_name() -> None:
    with pytest.raises(InputError, match=r"gear 5: a bore of 48.2 mm is not allowed"):
        Wheel("a", Outline(), TOLERANCE, Bore(0.0482))
