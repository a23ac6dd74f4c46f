"""Contours of cams: eccentric circles, rollers that are led along, lift-off of a mass on a
spring.
"""

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from shapely import Point, Polygon

from planter.errors import GeometryError, InputError
from planter.gears.workshop import arcs
from planter.gears.workshop.cam import Profile, check_roller, find_lift_off
from planter.kernels import Array, formulas

ROLLER, PITCH, OFFSET = 0.009, 0.03, 0.008
BREAKS = tuple(np.linspace(0, 2 * np.pi, 9).tolist())


def eccentric(roller: float) -> Callable[[Array], Mapping[str, Array]]:
    """A roller led along a line through the axis by a circle that turns about a point beside its
    centre.
    """

    def course(phi: Array) -> Mapping[str, Array]:
        c, s, e = np.cos(phi), np.sin(phi), OFFSET
        root = np.sqrt(PITCH**2 - (e * s) ** 2)
        y = e * c + root
        dy = -e * s - e**2 * s * c / root
        ddy = -e * c - e**2 * (c**2 - s**2) / root - e**4 * (s * c) ** 2 / root**3
        none = np.zeros(len(phi))
        centre = np.array([none, y, none, dy, none, ddy])
        return formulas.load("disc_cam")(
            "disc", phi=phi, centre=centre, way=centre[2:4], reach=-roller
        )

    return course


def profile(roller: float = ROLLER) -> Profile:
    return Profile("eccentric", roller, eccentric(roller), BREAKS, True, ("pitch_x", "pitch_y"))


def test_contour_of_eccentric_circle_is_a_circle() -> None:
    cam_profile = profile()
    outline = arcs.fit_arcs(cam_profile.pieces, 1e-6)
    centre = np.array([0.0, OFFSET])
    np.testing.assert_allclose(
        np.hypot(*(outline.points(1e-6) - centre).T), PITCH - ROLLER, rtol=1e-9
    )
    assert len(outline.vertices) <= 2 * len(BREAKS)
    assert outline.area == pytest.approx(np.pi * (PITCH - ROLLER) ** 2, rel=1e-9)
    assert cam_profile.check_clearance().value == pytest.approx(1 - ROLLER / PITCH, rel=1e-9)
    for piece in cam_profile.pieces:
        np.testing.assert_allclose(
            piece.curvature(np.array([0.3])), 1 / (PITCH - ROLLER), rtol=1e-9
        )


def test_cam_pressure_angle_agrees_with_centres() -> None:
    pressure = profile().find_largest("pressure")
    assert pressure.value == pytest.approx(np.arcsin(OFFSET / PITCH), rel=1e-9)
    assert pressure.place % np.pi == pytest.approx(np.pi / 2, abs=1e-6)


def test_undercutting_roller_is_refused_with_angle() -> None:
    profile(0.999 * PITCH).check_clearance()
    with pytest.raises(
        GeometryError, match=r"a roller of a radius of 30.03 mm .* has a radius of 30 mm"
    ):
        profile(1.001 * PITCH).check_clearance()
    with pytest.raises(InputError, match=r"--roller-mm = -1"):
        check_roller(-1e-3)


def test_a_roller_touches_the_disc_wherever_it_is() -> None:
    cam_profile = profile()
    disc = Polygon(arcs.fit_arcs(cam_profile.pieces, 1e-7).points(1e-8))
    places = cam_profile.course(np.linspace(0, 2 * np.pi, 101))
    gaps = [
        disc.distance(Point(x, y)) - ROLLER
        for x, y in zip(*(places[p] for p in cam_profile.pitch), strict=True)
    ]
    assert np.abs(gaps).max() < 2e-7


@pytest.mark.parametrize("weight", [0.0, 5.0])
def test_a_mass_on_a_spring_lifts_off_where_inertia_outweighs_it(weight: float) -> None:
    mass, lift, preload = 0.4, 0.01, 30.0

    def push(angles: Array, speed: float) -> Array:
        force: Array = preload + weight - mass * speed**2 * lift * np.sin(angles)
        return force

    lift_off = find_lift_off(push, 3.0)
    assert lift_off is not None
    assert lift_off.speed_rpm * np.pi / 30 == pytest.approx(
        np.sqrt((preload + weight) / mass / lift), rel=1e-9
    )
    assert lift_off.angle_deg == pytest.approx(90, abs=1e-2)


def test_lift_off_of_permanent_and_missing_contact() -> None:
    assert find_lift_off(lambda angles, speed: 1 + speed**2 + 0 * angles, 3.0) is None
    loose = find_lift_off(lambda angles, speed: -1 + 0 * angles, 3.0)
    assert loose is not None
    assert loose.speed_rpm == 0
