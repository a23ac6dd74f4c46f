"""Pairs of gears by families and by tables, held against integrals of the law of gearing and closed
forms.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from scipy.interpolate import CubicSpline

from derive import Quantity, RollingPair, gear_pair, read_gear_pair
from derive.quantity import TableError
from planter.kernels import Array
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from tests.support import own

PHI = Quantity("phi", "rad", "gear", "test")
COLUMNS = "t | deg | polar angle\nr | mm | pitch radius"
RADII = {
    "ellipse": ({"A": 0.02, "k": 0.2}, lambda u: 0.02 * (1 - 0.2**2) / (1 - 0.2 * np.cos(u))),
    "limacon": ({"l": 0.02, "b": 0.004}, lambda u: 0.02 + 0.004 * np.cos(u)),
    "sine": ({"D": 0.04, "c": 0.3}, lambda u: 0.04 * (1 + 0.3 * np.cos(u)) / (2 + 0.3 * np.cos(u))),
}
DEFORMED = """
from derive import GearContact, Mechanism, gear_pair, quantities, tangent_angle
q = quantities('''
    phi   | rad   | driver
    omega | rad/s | its speed      | 12
    l     | mm    | mean radius    | 20  | 15 25
    b     | mm    | swing          | 4   | 2 5
    k     | 1     | deformation    | 1.3 | 0.9 1.4
    alpha | deg   | pressure angle | 20
    m     | kg    | mate           | 1.8
    J     | kg m2 | mate           | 0.004
    M_r   | N m   | resistance     | 6
''')
m = Mechanism("own", q, angle=q.phi, speed=q.omega)
pair = gear_pair("limacon", -q.phi, q.k, l=q.l, b=q.b)
psi = m.coordinate("psi", "rad", "mate", equals=pair.turned)
D = m.point("D", m.O, m.world, pair.distance)
driver, mate = m.body("driver", m.frame("driver", q.phi)), m.body("mate", m.frame("mate", psi), q.m, D, q.J)
m.pin("O", driver, m.ground, m.O)
m.pin("D", mate, m.ground, D)
tangent = tangent_angle(m.motion, m.world, driver.frame, -q.phi, pair.radius, pair.slope)
m.mesh("P", driver, mate, GearContact(m.world, D, pair.distance - pair.radius, q.alpha, tangent=tangent))
m.torque("resistance", mate, m.ground, q.M_r)
m.motor("M_in", driver, m.ground, m.O)
SYSTEM = m.system()
"""


def evaluate(pair: RollingPair, name: str, angles: Array) -> Array:
    return np.array([float(getattr(pair, name).subs(PHI, angle)) for angle in angles])


@pytest.mark.parametrize("deformation", [None, 1.3])
@pytest.mark.parametrize("family", RADII)
def test_family_rolls_as_its_radius_says(family: str, deformation: float | None) -> None:
    parameters, radius = RADII[family]
    first = deformation or 1.0
    second = first / (2 * first - 1)

    def deformed(t: float) -> float:
        return float(radius(first * t if t <= np.pi / first else second * (2 * np.pi - t)))

    pair = gear_pair(family, PHI, deformation, **parameters)
    distance = float(pair.distance)
    angles = np.array([0.3, 1.7, 2.6, 4.4, 6.1])
    turned = [
        scipy.integrate.quad(
            lambda t: deformed(t) / (distance - deformed(t)),
            0,
            end,
            points=[np.pi / first],
            epsabs=1e-13,
        )[0]
        for end in angles
    ]
    assert evaluate(pair, "radius", angles) == pytest.approx(
        [deformed(t) for t in angles], rel=1e-12
    )
    assert evaluate(pair, "turned", angles) == pytest.approx(turned, abs=1e-11)
    assert evaluate(pair, "turned", angles + 2 * np.pi) == pytest.approx(
        np.add(turned, 2 * np.pi), abs=1e-11
    )
    step = 1e-6
    slopes = (evaluate(pair, "radius", angles + step) - evaluate(pair, "radius", angles - step)) / (
        2 * step
    )
    assert evaluate(pair, "slope", angles) == pytest.approx(slopes, abs=1e-9)


def test_table_of_an_ellipse_is_the_ellipse(tmp_path: Path) -> None:
    radius = RADII["ellipse"][1]
    rows = [
        f"{degrees},{1e3 * radius(np.radians(degrees)):.12f}" for degrees in range(-180, 181, 2)
    ]
    (tmp_path / "r.csv").write_text("t_deg,r_mm\n" + "\n".join(rows) + "\n", encoding="utf-8")
    table = read_gear_pair(tmp_path / "r.csv", COLUMNS)
    exact, angles = gear_pair("ellipse", PHI, A=0.02, k=0.2), np.linspace(-7, 7, 23)
    assert table.distance == pytest.approx(0.04, rel=1e-8)
    for name, tolerance in (("turned", 1e-7), ("radius", 1e-8), ("slope", 1e-6)):
        values = evaluate(table.pair(PHI, table.distance), name, angles)
        assert values == pytest.approx(evaluate(exact, name, angles), abs=tolerance)
    assert evaluate(table.pair(PHI, 0.1), "radius", angles) == pytest.approx(
        2.5 * radius(angles), rel=1e-6
    )


def test_mate_of_measured_gear_turns_half_as_far() -> None:
    rows = np.loadtxt(own.EXAMPLES / "measured_gears.csv", delimiter=",", skiprows=2)
    spline = CubicSpline(np.radians(rows[:, 0]), rows[:, 1] / 1e3, bc_type="periodic")

    def turn(distance: float, end: float = 2 * np.pi) -> float:
        return scipy.integrate.quad(
            lambda t: spline(t) / (distance - spline(t)), 0, end, limit=400, epsabs=1e-12
        )[0]

    distance = scipy.optimize.brentq(lambda a: turn(a) - np.pi, 0.05, 0.2, xtol=1e-13)
    model = Model(own.machine("measured_gears"))
    values = model(np.array([0.0, 1.1, 2 * np.pi]))
    table = read_gear_pair(own.EXAMPLES / "measured_gears.csv", COLUMNS, Fraction(1, 2))
    assert table.distance == pytest.approx(distance, rel=1e-9)
    assert values["psi"] == pytest.approx(
        [0.0, -np.pi + turn(distance, 2 * np.pi - 1.1), -np.pi], abs=1e-8
    )
    assert max(law.violation for law in compute_cycle(model, 90).result.laws) < 1e-10


def test_deformed_pair_satisfies_laws() -> None:
    model = Model(own.machine(DEFORMED, "own"))
    result = compute_cycle(model, 180).result
    assert max(law.violation for law in result.laws) < 1e-10
    assert result.repeats_after_turns == 1


@pytest.mark.parametrize(
    ("rows", "ratio", "reason"),
    [
        ("0,20\n90,21\n180,20\n270,19\n350,20\n", 1, "whole turn"),
        ("0,20\n90,21\n180,20\n270,19\n360,20.5\n", 1, "not the first"),
        ("0,20\n90,21\n180,-20\n270,19\n360,20\n", 1, "not positive"),
        ("0,20\n90,21\n180,20\n270,19\n360,20\n", 2, "does not close"),
    ],
)
def test_table_that_cannot_roll_is_refused(
    rows: str, ratio: int, reason: str, tmp_path: Path
) -> None:
    (tmp_path / "r.csv").write_text("t_deg,r_mm\n" + rows, encoding="utf-8")
    with pytest.raises(TableError, match=rf"r\.csv: .*{reason}"):
        read_gear_pair(tmp_path / "r.csv", COLUMNS, ratio)


@pytest.mark.parametrize(
    ("family", "parameters", "reason"),
    [
        ("fourier", {}, "ellipse, limacon, sine"),
        ("ellipse", {"A": 0.02}, "A, k"),
        ("oval", {}, "ellipse"),
    ],
)
def test_family_without_closed_form_is_refused(
    family: str, parameters: dict[str, float], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        gear_pair(family, PHI, **parameters)
