"""Sizing: the design keeps what it promises, names what binds, and says no where nothing fits."""

import math

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.papers.clutch import file
from planter.papers.clutch.model import CrankLinkage
from planter.papers.clutch.rotor import Rotor
from planter.papers.clutch.sizing import build_refusal, compute_sizes, size_clutch

SIZED_TO = {
    "fillet that the tooth tips clear",
    "tooth tips go round the shaft",
    "tooth roots clear the shaft's corners",
    "travel of the sleeve",
    "least axial angle for a travel",
}


def sizes(**changes: float) -> dict:
    return size_clutch(file.load_clutch("shi2021", changes))


@pytest.mark.parametrize(
    "changes",
    [{}, {"flat_to_flat_mm": 26, "space_radius_mm": 30}, {"wanted_travel_mm": 3}, {"wall_mm": 3}],
)
def test_least_sizes_hold_every_inequality_of_the_clutch(changes):
    sizing = sizes(**changes)
    eight = sizing.conditions[:8]
    assert all(c.holds for c in eight)
    assert set(sizing.binds) >= SIZED_TO


def test_sizes_are_those_of_the_laws():
    sizing = sizes()
    s, flats = sizing.sizes, 20.0
    assert s.tip_mm == pytest.approx(flats / (2 * math.sin(math.radians(72))), rel=1e-13)
    assert s.fillet_mm == pytest.approx(Rotor(5, 6, flats).ellipse["fillet"], rel=1e-12)
    corner = (flats / 2 - s.fillet_mm) / math.cos(math.pi / 6) + s.fillet_mm
    assert s.root_mm == pytest.approx(corner, rel=1e-13)
    assert s.right_radius_mm == pytest.approx(s.root_mm + 1, rel=1e-13)
    assert s.left_radius_mm == pytest.approx(s.outline_mm, rel=1e-12)
    taper = math.tan(math.radians(s.axial_angle_deg))
    assert s.left_radius_mm - s.right_radius_mm == pytest.approx(10 * taper, rel=1e-12)
    assert s.outline_mm - s.width_mm / 2 == pytest.approx(4.2 * taper, rel=1e-12)


def test_a_smaller_hexagon_would_not_do():
    """Shrinking the hexagon at the same travel leaves less than the wall outside the tooth
    roots.
    """
    clutch = file.load_clutch("shi2021")
    values = compute_sizes(clutch)
    side = 0.99 * values["a"]
    outline, apothem = (
        side * math.sqrt(3) / (2 * math.sin(math.radians(72))),
        side * math.sqrt(3) / 2,
    )
    thin_end = outline - values["d"] * (outline - apothem) / values["c"]
    assert thin_end < values["b2"] + 0.001
    assert sizes().sizes.hexagon_side_mm == pytest.approx(values["a"] * 1e3, rel=1e-14)


def test_the_linkage_makes_the_travel_in_the_lift():
    linkage_sizes = sizes().linkage
    linkage = CrankLinkage(
        linkage_sizes.crank_mm * 1e-3, linkage_sizes.rod_mm * 1e-3, linkage_sizes.distance_mm * 1e-3
    )
    assert np.degrees(linkage.rotation(0.0042)) == pytest.approx(
        linkage_sizes.crank_rotation_deg, abs=1e-9
    )
    assert linkage_sizes.crank_rotation_deg == pytest.approx((10 - 5) * 46 / 14, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "worst"),
    [
        ({"space_radius_mm": 14}, "corners of the hexagonal hole within the space"),
        ({"space_length_mm": 12}, "body and way of the sleeve within the space"),
        ({"normal_force_N": 1}, "normal force of body and sleeve"),
        ({"tooth_force_N": 30}, "tooth force of crank gear and rack"),
        ({"limits.length_mm": 41}, "length of the linkage"),
        ({"rack_least_mm": 50}, "radius of the rack"),
        ({"teeth_least": 17}, "teeth of the crank gear"),
        ({"sleeve.friction": 20}, "largest axial angle at which the sleeve slides"),
        ({"spring_preload_N": 70}, "sleeve slides along the taper"),
    ],
)
def test_violated_design_conditions_are_named(changes, worst):
    sizing = sizes(**changes)
    assert not sizing.feasible
    assert worst in sizing.violated
    assert sizing.violated[0] in build_refusal(sizing).message
    assert build_refusal(sizing).exit_code == 1


def test_exhausted_length_limit_binds():
    used = next(c for c in sizes().conditions if c.source == "limits.length_mm")
    limit = 48 - used.margin
    assert "length of the linkage" in sizes(**{"limits.length_mm": limit}).binds


def test_no_hexagon_at_all():
    with pytest.raises(ComputationError, match="body must be shorter or the travel longer"):
        sizes(**{"sleeve.length_mm": 100, "wanted_travel_mm": 2})
