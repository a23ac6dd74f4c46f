"""Bores and keyways: areas by closed forms, the standard's rows, walls."""

import numpy as np
import pytest

from planter.errors import InputError
from planter.workshop.arcs import build_circle
from planter.workshop.drawing import Bore, Keyway, check_wall, find_standard_keyway


@pytest.mark.parametrize("phase", [0.0, 2.3])
def test_edge_and_slot_make_up_the_bore(phase: float) -> None:
    bore = Bore(0.02, Keyway(0.006, 0.0028, phase))
    round_, slot = (line.arcs for line in bore.lines())
    assert slot.area > 0
    assert bore.edge.area == pytest.approx(round_.area + slot.area, rel=1e-13)
    half = np.arcsin(0.3)
    cap = 0.01**2 * (half - np.sin(half) * np.cos(half))
    assert slot.area == pytest.approx(0.006 * (0.0128 - 0.01 * np.cos(half)) - cap, rel=1e-12)
    far = bore.edge.vertices[np.hypot(*bore.edge.vertices.T) > 0.0101].mean(axis=0)
    assert np.arctan2(far[1], far[0]) == pytest.approx(np.arctan2(np.sin(phase), np.cos(phase)))


@pytest.mark.parametrize(("bore_mm", "keyway_mm"), [(8, (2, 1.0)), (17, (5, 2.3)), (17.5, (6, 2.8)), (40, (12, 3.3))])
def test_keyways_are_those_of_the_standard(bore_mm: float, keyway_mm: tuple[float, float]) -> None:
    assert find_standard_keyway(bore_mm / 1e3) == pytest.approx([mm / 1e3 for mm in keyway_mm])


@pytest.mark.parametrize("bore_mm", [6, 131])
def test_bores_without_a_standard_keyway_are_refused(bore_mm: float) -> None:
    with pytest.raises(
        InputError, match=rf"a bore of {bore_mm} mm has no keyway in DIN 6885-1: choose a bore over 6 mm"
    ):
        find_standard_keyway(bore_mm / 1e3)


def test_bore_leaves_a_wall() -> None:
    part = build_circle(0.012, (0.003, 0.0))
    assert check_wall(Bore(0.0178), part, "sun", 1e-5) == pytest.approx(1e-4, abs=2e-6)
    assert check_wall(Bore(0.016, Keyway(0.004, 0.002, 0.0)), part, "sun", 5e-4) == pytest.approx(1e-3, abs=2e-6)
    with pytest.raises(InputError, match=r"sun: a bore of 18.1 mm leaves .* smallest radius is 9 mm"):
        check_wall(Bore(0.0181), part, "sun", 1e-5)
    with pytest.raises(InputError, match=r"leaves a wall of 0.\d+ mm; at least 0.2 mm"):
        check_wall(Bore(0.0178), part, "sun", 2e-4)
    with pytest.raises(InputError, match=r"with its keyway 10.2 mm from the axis, leaves"):
        check_wall(Bore(0.016, Keyway(0.004, 0.002, np.pi)), part, "sun", 1e-5)
    with pytest.raises(InputError, match=r"keyway width = 9 mm"):
        Bore(0.009, Keyway(0.009, 0.001))
