"""The disc cam of a mechanism of one's own: closed forms of the example, the command."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from planter.gears.workshop.cam import find_lift_off
from planter.mechanism import cam
from planter.mechanism.model import Model
from tests.support import own
from tests.support.cli import answer, refusal

NAME = "cam_follower"


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(own.machine(NAME))


def test_curvature_and_pressure_angle_of_harmonic_lift(model: Model) -> None:
    phi = np.linspace(0, 2 * np.pi, 50)
    profile = cam.build_profile(model, 0.008, "0", "y_0 + s").course(phi)
    h, y = 0.014, 0.038 + 0.014 * (1 - np.cos(phi)) / 2
    dy, ddy = h * np.sin(phi) / 2, h * np.cos(phi) / 2
    curvature = (y**2 + 2 * dy**2 - y * ddy) / np.hypot(y, dy) ** 3
    np.testing.assert_allclose(profile["kappa"], -curvature, rtol=1e-7)
    np.testing.assert_allclose(np.tan(profile["pressure"]), np.abs(dy) / y, atol=1e-9)
    np.testing.assert_allclose(np.hypot(profile["pitch_x"], profile["pitch_y"]), y, rtol=1e-12)


def test_slopes_pass_through_closed_loops() -> None:
    phi = np.linspace(0.0, 6.2, 60)
    columns = cam.build_profile(Model(own.machine("slider_crank")), 0.008, "0", "s").course(phi)
    r, rod, e = 0.05, 0.2, 0.01
    root = np.sqrt(rod**2 - (e - r * np.sin(phi)) ** 2)
    s, slope = (
        r * np.cos(phi) + root,
        -r * np.sin(phi) + (e - r * np.sin(phi)) * r * np.cos(phi) / root,
    )
    np.testing.assert_allclose(np.hypot(columns["pitch_x"], columns["pitch_y"]), s, rtol=1e-12)
    np.testing.assert_allclose(np.tan(columns["pressure"]), np.abs(slope) / s, atol=1e-12)


def test_pressure_angle_of_table_is_that_of_its_spline() -> None:
    rows = np.loadtxt(own.EXAMPLES / "tabulated_cam.csv", delimiter=",", skiprows=2)
    lift = CubicSpline(np.radians(rows[:, 0]), rows[:, 1] * 1e-3, bc_type="periodic")
    phi = np.linspace(0.0, 6.2, 60)
    profile = cam.build_profile(
        Model(own.machine("tabulated_cam")), 0.008, "N_cam_centre_x", "N_cam_centre_y"
    )
    slope = np.abs(lift(phi, 1)) / (0.038 + lift(phi))
    np.testing.assert_allclose(np.tan(profile.course(phi)["pressure"]), slope, atol=1e-9)


def test_an_offset_line_is_another_cam(model: Model) -> None:
    straight, offset_cam, same = (
        cam.build_profile(model, 0.008, x, y)
        for x, y in (("0", "y_0+s"), ("5", "38+s"), ("0", "38+s"))
    )
    angles = np.linspace(0, 6, 9)
    np.testing.assert_allclose(
        straight.course(angles)["contact_x"], same.course(angles)["contact_x"], rtol=1e-12
    )
    assert (
        np.abs(straight.course(angles)["contact_x"] - offset_cam.course(angles)["contact_x"]).max()
        > 1e-3
    )


def test_it_lifts_off_where_the_spring_and_gravity_give_in(model: Model) -> None:
    lift_off = find_lift_off(cam.find_contact_force(model, "N_cam"), model.speed)
    assert lift_off is not None
    top = 22 + 1800 * 0.014 + 0.65 * 9.81
    assert lift_off.speed_rpm * np.pi / 30 == pytest.approx(np.sqrt(top / (0.65 * 0.007)), rel=1e-9)
    assert lift_off.angle_deg == pytest.approx(180, abs=1e-2)


def test_roller_centre_equals_stated_follower() -> None:
    place = str(own.generated(NAME) / f"{NAME}.toml")
    stated, message = (
        answer("cam", place, "--roller-mm", "8", *more)
        for more in ((), ("--y", "y_0+s", "--force", "N_cam"))
    )
    angles = [result.pop("pressure_angle_deg") for result in (stated, message)]
    assert stated == message
    assert angles[0]["max"] == pytest.approx(angles[1]["max"], rel=1e-12)
    assert angles[0]["at_deg"] == pytest.approx(
        angles[1]["at_deg"], abs=1e-5
    )  # of a search without slopes
    crank = own.generated("slider_crank") / "slider_crank.toml"
    assert "no follower of a cam" in refusal("cam", str(crank), "--roller-mm", "8")


def test_the_command_writes_a_disc(tmp_path: Path) -> None:
    place = str(own.generated(NAME) / f"{NAME}.toml")
    options = (
        "--roller-mm",
        "8",
        "--y",
        "y_0+s",
        "--force",
        "N_cam",
        "--bore-mm",
        "12",
        "--out",
        str(tmp_path),
    )
    result = answer("cam", place, *options)
    assert result["kind"] == "disc"
    assert result["lift_off"]["speed_rpm"] == pytest.approx(1036.22, rel=1e-5)
    assert all((tmp_path / name).is_file() for name in result["files"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--y", "y_0+lift"), "--y = lift: there are s, N_cam_centre_x"),
        (("--y", "y_0+s", "--force", "N_cm"), "--force = N_cm: did you mean N_cam?"),
        (("--x", "1"), "--x needs --y"),
        (("--force", "guide"), "--force = guide: there are N_cam"),
        (("--y", "y_0+s", "--bore-mm", "70"), "cam_follower: a bore of 70 mm leaves a wall"),
        (("--y", "y_0+s", "--bore-mm", "58"), "leaves a wall of"),
        (("--y", "s"), "undercuts the contour"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(options: tuple[str, ...], message: str) -> None:
    assert message in refusal(
        "cam", str(own.generated(NAME) / f"{NAME}.toml"), "--roller-mm", "8", *options
    )
