"""Teeth on hollow curves that run into fillets: racks that are offered for them pass, those beside
them do not.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from planter.errors import GeometryError
from planter.gears.geometry import cutting, polygons
from planter.gears.geometry.cutting import ToothedPair, cut_teeth
from planter.gears.geometry.pitch_curves import build_stage_pair
from planter.gears.geometry.stage import Stage
from tests.support import pairs
from tests.support.toothed import FREE

DEPTH = 0.0083885404
"""Depth in modules to which teeth on a hollow curve run into each other."""


def hollow(eccentricity: float, teeth: int, tip_radius: float = 1.0) -> ToothedPair:
    """A deformed eccentric circle that is hollow on either side."""
    parameters = np.array([0.031, eccentricity, 1.9])
    stage: Stage = pairs.stage_of("eccentric_circle", parameters)
    return cut_teeth(
        build_stage_pair(stage, parameters),
        replace(FREE, teeth=teeth, tip_radius=tip_radius),
        "pair",
        ("gear", "mate"),
    )


def test_suggested_racks_are_just_sufficient() -> None:
    curves = hollow(0.012, 31)
    with pytest.raises(
        GeometryError, match=r"overlap by .* modules, .* mm, at the polar angle .* would do$"
    ) as message:
        cutting.check_pair_penetration(curves)
    first, clearance, second = map(
        float, re.findall(r"(?:radius|clearance) of ([\d.]+)", str(message.value))
    )
    offered = [
        replace(FREE, tip_radius=first),
        replace(FREE, clearance=clearance, tip_radius=second),
    ]
    short = [
        replace(FREE, tip_radius=first + 0.01),
        replace(offered[1], clearance=clearance - 0.01),
    ]
    assert second == 0.37
    assert [cutting.passes_limits(curves, order) for order in (*offered, *short)] == [
        True,
        True,
        False,
        False,
    ]


def test_advised_rack_does_not_interfere_when_cut_again() -> None:
    """Four times as many chords and positions see no more than the limit: the advice does not rest
    on coarse ones.
    """
    curves = hollow(0.012, 31, tip_radius=0.17)
    fine = {kind: 4 * count for kind, count in polygons.FINE_CHORDS.items()}
    at = np.linspace(-2, 2, 801) * curves.mesh.pitch + curves.deepest.place
    depth = polygons.Overlay.from_mesh(curves.mesh, fine).depths(at).max()
    assert 0 < depth < cutting.MAX_PENETRATION * curves.sized.module
    assert depth == pytest.approx(curves.deepest.value, abs=2e-4 * curves.sized.module)


@pytest.mark.parametrize("module_mm", [0.1, 100.0])
def test_penetration_is_the_same_at_any_size(module_mm: float) -> None:
    parameters = np.array([0.031, 0.0115, 1.9])
    curves = build_stage_pair(pairs.stage_of("eccentric_circle", parameters), parameters)
    size = np.pi * 31 * module_mm * 1e-3 / curves.gear.length
    pair = cut_teeth(curves.scaled(size), replace(FREE, teeth=31), "pair", ("gear", "mate"))
    assert pair.sized.module == pytest.approx(module_mm * 1e-3, rel=1e-12)
    assert pair.deepest.value / pair.sized.module == pytest.approx(DEPTH, rel=1e-8)
    with pytest.raises(GeometryError, match=r"overlap by 0\.008\d+ modules"):
        cutting.check_penetration(pair.mesh, pair.deepest, "pair")


def test_missing_remedy_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutting, "MAX_CLEARANCE", 0.3)
    assert cutting.suggest_racks(hollow(0.015, 41)).startswith(
        "no smaller tip radius of the rack and no clearance"
    )
