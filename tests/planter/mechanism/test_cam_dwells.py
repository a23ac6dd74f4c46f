"""Pressure angles of cams with dwells against closed forms: all flank laws, followers, senses of
turning, a table.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import sympy as sp

from derive.papers.planting import flanks
from planter.errors import ComputationError
from planter.kernels import Array
from planter.mechanism import cam
from planter.mechanism.model import Model
from tests.support import own
from tests.support.cli import answer
from tests.support.sampled import sampled

RISE, UPPER, FALL = 100.0, 160.0, 280.0
"""Ends of rise, upper dwell and return [deg]; the lower dwell ends the turn."""
DISTANCE, ARM, START, SWING = 0.12, 0.1, np.radians(150.0), np.radians(25.0)
"""Distance of the shafts, rocker [m], its angle at rest and its swing [rad]."""
BASE, OFFSET, LIFT = 0.04, 0.011, 0.016
"""Height of a slide's roller at rest, its distance from the axis, its lift [m]."""
FINE = np.linspace(0.0, 2 * np.pi, 20_001)

HEAD = """
from sympy import Piecewise, Rational, cos, pi
from derive import Mechanism, Y, quantities, wrap
from derive.papers.planting import flanks
q = quantities('''
    phi | rad | angle
    omega | r/min | speed | 120
    d | mm | distance of the shafts | 120
    L | mm | rocker | 100
    psi_0 | deg | rocker at rest | 150
    h | deg | swing | 25
    y_0 | mm | slide at rest | 40
    e | mm | offset | 11
    l | mm | lift | 16
''')
m = Mechanism("own", q, angle=q.phi, speed=q.omega)
t = wrap(q.phi, 2 * pi)
B1, B2, B3 = (pi * Rational(b, 180) for b in (100, 160, 280))
share = flanks.derive_flank_law("TITLE")[0]
up, down = share.subs(flanks.x, t / B1), share.subs(flanks.x, (t - B2) / (B3 - B2))
law = Piecewise((up, t < B1), (1, t < B2), (1 - down, t < B3), (0, True))
"""
ROCKER = """
psi = m.coordinate("psi", "rad", "rocker", equals=q.psi_0 - q.h * law)
D = m.point("D", m.O, BASE_FRAME, q.d)
rocker = m.frame("rocker", psi, parent=BASE_FRAME)
P = m.point("P", D, rocker, q.L)
arm = m.body("arm", rocker)
m.pin("D", arm, BASE_BODY, D)
m.follower("N_cam", arm, cam, P, m.O, across=m.vector(m.world, z=-1))
"""
SLIDE = """
s = m.coordinate("s", "m", "lift", equals=q.l * law)
P = m.point("P", m.O, m.world, q.e, q.y_0 + s)
slide = m.body("slide", m.world)
m.slide("guide", slide, m.ground, P, along=Y)
m.follower("N_cam", slide, cam, P, m.O, across=m.vector(m.world, z=-1))
"""
TURNING = """
cam = m.body("cam", m.frame("cam", SENSE * q.phi))
m.pin("O", cam, m.ground, m.O)
m.motor("M_in", cam, m.ground, m.O)
"""
CARRIED = """
carrier = m.body("carrier", m.frame("carrier", q.phi))
m.pin("O", carrier, m.ground, m.O)
m.motor("M_in", carrier, m.ground, m.O)
cam = m.ground
"""
END = "SYSTEM = m.system()\n"


@cache
def build_model(title: str, kind: str, sense: int) -> Model:
    """A cam with two dwells: its law, "rocker", "slide" or "carried" (a fixed cam, rocker on a
    carrier), and sense.
    """
    frame, body = ("carrier.frame", "carrier") if kind == "carried" else ("m.world", "m.ground")
    stand = CARRIED if kind == "carried" else TURNING.replace("SENSE", str(sense))
    follower = SLIDE if kind == "slide" else ROCKER
    text = HEAD.replace("TITLE", title) + stand + follower + END
    return Model(own.machine(text.replace("BASE_FRAME", frame).replace("BASE_BODY", body), "own"))


@cache
def build_law(title: str) -> Callable[[Array], tuple[Array, Array]]:
    """Share of the lift and its slope at angles of a turn, from the law's own function of the
    position in a flank.
    """
    shares = [sp.lambdify(flanks.x, expr, "numpy") for expr in flanks.derive_flank_law(title)[:2]]
    b1, b2, b3 = np.radians([RISE, UPPER, FALL])

    def evaluate(phi: Array) -> tuple[Array, Array]:
        t = phi % (2 * np.pi)
        up, down = np.clip(t / b1, 0, 1), np.clip((t - b2) / (b3 - b2), 0, 1)
        share, slope = (np.vectorize(function, otypes=[float]) for function in shares)
        is_up, is_down = t < b1, (t >= b2) & (t < b3)
        values = np.select(
            [is_up, t < b2, is_down], [share(up), np.ones(len(t)), 1 - share(down)], 0.0
        )
        return values, np.select([is_up, is_down], [slope(up) / b1, -slope(down) / (b3 - b2)], 0.0)

    return evaluate


def expected_pressure(title: str, kind: str, sense: int, phi: Array) -> Array:
    """Angle between the normal of the path on the cam and the motion that the guide leaves the
    centre [rad].
    """
    share, slope = build_law(title)(phi)
    if kind == "slide":
        return np.arctan2(np.abs(LIFT * slope - sense * OFFSET), BASE + LIFT * share)
    psi, rate = START - SWING * share, -SWING * slope
    tangent = np.array([-np.sin(psi), np.cos(psi)])
    centre = np.array([DISTANCE + ARM * np.cos(psi), ARM * np.sin(psi)])
    sliding = ARM * rate * tangent - sense * np.array([-centre[1], centre[0]])
    across = sliding[0] * tangent[1] - sliding[1] * tangent[0]
    return np.arctan2(np.abs((sliding * tangent).sum(axis=0)), np.abs(across))


CASES = [
    *((title, kind, 1) for title in flanks.SHAPES for kind in ("slide", "rocker")),
    ("3-4-5 polynomial", "slide", -1),
    ("cycloidal", "rocker", -1),
    ("4-5-6-7 polynomial", "carried", -1),
]


SAMPLE = [("cycloidal", "slide", 1), ("harmonic", "rocker", 1), *CASES[-3:]]


@pytest.mark.parametrize(("title", "kind", "sense"), sampled(SAMPLE, CASES))
def test_pressure_angle_equals_closed_form(title: str, kind: str, sense: int) -> None:
    profile = cam.build_profile(
        build_model(title, kind, sense), 0.008, "N_cam_centre_x", "N_cam_centre_y"
    )
    inside = [1e-7, 30.0, 99.9999, 100.0, 111.62, 130.0, 159.999, 170.0, 220.0, 279.9, 300.0, 345.6]
    phi = np.radians(np.concatenate([inside, np.random.default_rng(3).uniform(0, 360, 60)]))
    pressure = profile.course(phi)["pressure"]
    np.testing.assert_allclose(
        pressure, expected_pressure(title, kind, sense, phi), rtol=1e-8, atol=1e-10
    )
    largest, fine = profile.find_largest("pressure"), expected_pressure(title, kind, sense, FINE)
    assert largest.value >= fine.max() - 1e-9
    assert largest.value == pytest.approx(fine.max(), rel=1e-6)


def test_curvature_at_dwell_is_that_of_its_circle() -> None:
    profile = cam.build_profile(
        build_model("cycloidal", "slide", 1), 0.008, "N_cam_centre_x", "N_cam_centre_y"
    )
    columns = profile.course(np.radians([120.0, 155.0, 300.0]))
    radii = np.hypot(OFFSET, BASE + LIFT * np.array([1.0, 1.0, 0.0]))
    np.testing.assert_allclose(columns["kappa"], -1 / radii, rtol=1e-12)
    np.testing.assert_allclose(columns["room"], 1 - 0.008 / radii, rtol=1e-12)


def test_command_gives_greatest_pressure_angle() -> None:
    """A rocker with a 3-4-5 rise and a 4-5-6-7 return, of whom the dwells were found the
    steepest.
    """
    mixed = HEAD.replace("TITLE", "3-4-5 polynomial").replace(
        "share.subs(flanks.x, (t - B2)",
        'flanks.derive_flank_law("4-5-6-7 polynomial")[0].subs(flanks.x, (t - B2)',
    )
    text = mixed + TURNING.replace("SENSE", "1") + ROCKER + END
    place = (
        own.generated(text.replace("BASE_FRAME", "m.world").replace("BASE_BODY", "m.ground"))
        / "own.toml"
    )
    result = answer("cam", str(place), "--roller-mm", "10")
    assert result["pressure_angle_deg"]["max"] == pytest.approx(35.838455, abs=1e-5)
    assert result["pressure_angle_deg"]["at_deg"] == pytest.approx(52.1507, abs=1e-3)


def test_centre_that_never_moves_is_refused() -> None:
    model = build_model("cycloidal", "slide", 1)
    with pytest.raises(ComputationError, match="at rest for a whole turn"):
        cam.build_profile(model, 0.008, "0", "y_0")


def test_direction_without_limit_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    model, phi = build_model("cycloidal", "rocker", 1), np.radians([130.0, 320.0])
    monkeypatch.setattr(cam.RollerPath, "direction", cam.RollerPath._motion)
    profile = cam.build_profile(model, 0.008, "N_cam_centre_x", "N_cam_centre_y")
    wrong = np.abs(
        profile.course(phi)["pressure"] - expected_pressure("cycloidal", "rocker", 1, phi)
    )
    assert wrong.min() > 0.05
