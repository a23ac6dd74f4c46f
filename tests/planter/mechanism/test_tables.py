"""Tables of CSV files as functions of a statement, held against splines of SciPy and closed
forms.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import CubicSpline

from derive import Quantity, read_table
from derive.evaluate import NotEvaluated, Point
from derive.quantity import DimensionError, TableError, dimension, of_unit
from planter.errors import ComputationError
from planter.kernels import Array
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from tests.support import own

LIFT = own.EXAMPLES / "tabulated_cam.csv"
COLUMNS = "phi | deg | cam angle\nlift | mm | lift of the roller"
ANGLES = np.linspace(0.05, 6.2, 83)
PHI, PLACE = Quantity("phi", "rad", "cam", "test"), Quantity("s", "m", "place", "test")
ROWS = ["0,0", "90,3", "180,1", "270,2", "360,0"]


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(own.machine("tabulated_cam"))


def closed_form_lift(angles: Array) -> Array:
    """Return the 3-4-5 polynomials (R.

    L. Norton, Cam design and manufacturing handbook) that the table samples.
    """
    degrees = np.degrees(angles)
    share = np.clip(np.where(degrees < 180, degrees / 120, (300 - degrees) / 120), 0, 1)
    lift: Array = 0.018 * (10 * share**3 - 15 * share**4 + 6 * share**5)
    return lift


def test_cam_follows_table(model: Model) -> None:
    rows = np.loadtxt(LIFT, delimiter=",", skiprows=2)
    spline = CubicSpline(np.radians(rows[:, 0]), rows[:, 1] / 1000, bc_type="periodic")
    values = model(ANGLES)
    for order, name in enumerate(("s", "s_dot", "s_ddot")):
        expected = spline(ANGLES, order) * model.speed**order
        own.deviation(name, values[name], expected)
        assert values[name] == pytest.approx(expected, rel=1e-12, abs=1e-12)
    load = 0.65 * (9.81 + values["s_ddot"]) + 22 + 1800 * values["s"]
    assert values["M_in"] == pytest.approx(load * spline(ANGLES, 1), abs=1e-12)
    assert values["s"] == pytest.approx(closed_form_lift(ANGLES), abs=2e-6), (
        "between rows 5 degrees apart"
    )


def test_cam_repeats_and_satisfies_laws(model: Model) -> None:
    result = compute_cycle(model, 90).result
    assert not result.warnings
    assert max(law.violation for law in result.laws) < 1e-10
    assert model(ANGLES + 2 * np.pi)["s"] == pytest.approx(model(ANGLES)["s"], abs=1e-15)


def test_array_code_agrees(model: Model) -> None:
    data, module = model.machine.data, own.array_code("tabulated_cam")
    names = [quantity.name for quantity in model.machine.quantities]
    hoisted = module.prologue(np, data)
    row = module.lane(np, 2.0, data, hoisted)
    assert row[names.index("s_ddot")] == pytest.approx(
        model(np.array([2.0]))["s_ddot"][0], rel=1e-12
    )


def write_table(folder: Path, rows: list[str], header: str = "phi_deg,lift_mm") -> Path:
    path = folder / "lift.csv"
    path.write_text("\n".join(["# measured", header, *rows]) + "\n")
    return path


def test_units_of_derivatives_are_per_argument(tmp_path: Path) -> None:
    path = write_table(tmp_path, ["0,0", "100,1", "200,4", "300,9"], "s_mm,load_N")
    load = read_table(path, "s | mm | depth\nload | N | soil")(PLACE)
    assert [dimension(load.diff(PLACE, k)) for k in (0, 1, 2)] == [
        of_unit("N"),
        of_unit("N/m"),
        of_unit("N/m2"),
    ]
    point = Point({PLACE: sp.Rational(1, 4)})
    assert [float(point(load.diff(PLACE, k))) for k in (0, 1, 2)] == pytest.approx(
        [6.25, 50, 200], rel=1e-12
    )
    assert load.diff(PLACE, 4) == 0
    with pytest.raises(DimensionError, match="load"):
        read_table(path, "s | mm | depth\nload | N | soil")(PHI)


def test_semicolons_and_decimal_commas_are_read(tmp_path: Path) -> None:
    path = write_table(tmp_path, ["0;0,5", "1,5;1", "2;3", "3;5"], "v_km_h;load_kN")
    load = read_table(path, "v | km/h | speed\nload | kN | pull")
    speed = Quantity("v", "m/s", "speed", "own")
    assert float(Point({speed: sp.Rational(5, 12)})(load(speed))) == pytest.approx(1000, rel=1e-12)


def test_table_is_undefined_beyond_rows(tmp_path: Path) -> None:
    lift = read_table(write_table(tmp_path, ROWS[:4]), COLUMNS)
    with pytest.raises(NotEvaluated):
        Point({PHI: 5})(lift(PHI))
    statement = f"""
from derive import Mechanism, quantities, read_table
lift = read_table({str(tmp_path / "lift.csv")!r}, {COLUMNS!r})
q = quantities('''
    phi   | rad   | angle
    omega | rad/s | speed | 10
    m     | kg    | slide | 2
    w     | m     | wall  | 1
''')
m = Mechanism("own", q, angle=q.phi, speed=q.omega)
s = m.coordinate("s", "m", "lift", equals=lift(q.phi))
P = m.point("P", m.O, m.world, s)
slide = m.body("slide", m.world, q.m, P)
m.slide("guide", slide, m.ground, P)
m.actuator("F_in", slide, m.ground, (P, m.point("wall", m.O, m.world, q.w)))
SYSTEM = m.system()
"""
    model = Model(own.machine(statement, "own"))
    assert model(np.radians([90.0]))["s"] == pytest.approx(0.003, abs=1e-15)
    with pytest.raises(ComputationError):
        model(np.radians([300.0]))


def edit_row(row: int, text: str) -> Callable[[Path], Path]:
    return lambda folder: write_table(folder, [*ROWS[:row], text, *ROWS[row + 1 :]])


@pytest.mark.parametrize(
    ("build", "place"),
    [
        (edit_row(2, "180,high"), "line 5, column lift_mm"),
        (edit_row(2, "180"), "line 5, column lift_mm"),
        (edit_row(2, "180,nan"), "line 5, column lift_mm"),
        (edit_row(2, "180,1,5"), "line 5, column phi_deg"),
        (edit_row(3, "180,2"), "line 6, column phi_deg"),
        (edit_row(4, "360,1"), "column lift_mm"),
        (lambda folder: write_table(folder, ROWS, "angle_deg,lift_mm"), "no column phi_deg"),
        (lambda folder: write_table(folder, ROWS[:3]), "4 to 400 rows"),
        (lambda folder: folder / "missing.csv", "missing.csv"),
    ],
)
def test_bad_table_is_refused_with_location(
    tmp_path: Path, build: Callable[[Path], Path], place: str
) -> None:
    path = build(tmp_path)
    with pytest.raises(TableError, match=place) as refusal:
        read_table(path, COLUMNS, periodic=True)
    assert str(path) in str(refusal.value)
    assert place in str(refusal.value)
