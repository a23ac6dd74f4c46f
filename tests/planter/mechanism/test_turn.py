"""A mechanism of one's own over a turn: loops that close and that do not, its command, its
files.
"""

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from derive.__main__ import main as derive
from planter.engine.machine import load_machine
from planter.errors import ComputationError, InputError
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.file import load
from planter.mechanism.model import Model
from tests.support.cli import answer
from tests.support.schemas import load_schema

STATEMENT = '''
from sympy import Rational
from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | rad/s | crank speed  | 12
    a     | mm    | crank        | 40
    b     | mm    | coupler      | 110
    c     | mm    | rocker       | 80
    d     | mm    | frame        | 120
    m_c   | kg    | rocker       | 0.9
    J_c   | kg m2 | rocker       | 0.0007
""")
m = Mechanism("four_bar", q, angle=q.phi, speed=q.omega)
beta, gamma = m.coordinate("beta", "rad", "coupler angle"), m.coordinate("gamma", "rad", "rocker angle")
A = m.point("A", m.O, m.frame("crank", q.phi), q.a)
D = m.point("D", m.O, m.world, q.d)
coupler, rocker = m.frame("coupler", beta), m.frame("rocker", gamma)
B, end = m.point("B", A, coupler, q.b), m.point("end", D, rocker, q.c)
m.close(B, end, start={beta: Rational(4, 5), gamma: Rational(8, 5)})
one, two = m.body("crank", m.frame("crank", q.phi)), m.body("coupler", coupler)
three = m.body("rocker", rocker, mass=q.m_c, centroid=end, inertia=q.J_c)
m.pin("O", one, m.ground, m.O)
m.pin("A", two, one, A)
m.pin("B", three, two, end)
m.pin("D", three, m.ground, D)
m.motor("M_in", one, m.ground, m.O)
SYSTEM = m.system()
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("own")
    (place / "four_bar.py").write_text(STATEMENT, encoding="utf-8")
    assert derive([str(place / "four_bar.py")]) == 0
    return place


def model(folder: Path, **values: float) -> Model:
    return Model(load_machine(str(folder / "generated" / "four_bar.toml"), values))


def rocker_angle(phi: np.ndarray, a: float, b: float, c: float, d: float) -> np.ndarray:
    """Freudenstein's equation, solved by half-angles; the open assembly (Freudenstein, Trans.

    ASME 77 (1955) 853).
    """
    k1, k2, k3 = d / a, d / c, (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    p = np.cos(phi) - k1 - k2 * np.cos(phi) + k3
    q, r = -2 * np.sin(phi), k1 - (k2 + 1) * np.cos(phi) + k3
    return 2 * np.arctan2(-q - np.sqrt(q**2 - 4 * p * r), 2 * p)


def test_angles_are_those_of_freudensteins_equation(folder: Path) -> None:
    phi = np.radians(np.arange(-400.0, 800.0, 7.0))
    angles = model(folder)(phi)["gamma"]
    assert np.cos(angles) == pytest.approx(
        np.cos(rocker_angle(phi, 0.04, 0.11, 0.08, 0.12)), abs=1e-12
    )
    assert np.sin(angles) == pytest.approx(
        np.sin(rocker_angle(phi, 0.04, 0.11, 0.08, 0.12)), abs=1e-12
    )


def test_motor_work_equals_energy(folder: Path) -> None:
    """Nothing but the rocker has mass: M omega = d/dt of J gamma_dot^2/2, differentiated by central
    differences.
    """
    step, phi = 1e-4, np.radians(np.arange(0.0, 360.0, 10.0))
    mechanism = model(folder)

    def energy(angles: np.ndarray) -> np.ndarray:
        rate: np.ndarray = mechanism(angles)["gamma_dot"]
        return (0.0007 + 0.9 * 0.08**2) * rate**2 / 2

    slope = (
        energy(phi - 2 * step)
        - 8 * energy(phi - step)
        + 8 * energy(phi + step)
        - energy(phi + 2 * step)
    ) / (12 * step)
    assert mechanism(phi)["M_in"] == pytest.approx(slope, rel=1e-8, abs=1e-9)


def test_open_loop_names_last_closed_angle(folder: Path) -> None:
    """Where the crank's end is as far from D as coupler and rocker reach together."""
    a, b, c, d = 0.04, 0.06, 0.08, 0.12
    limit = np.degrees(np.arccos((a**2 + d**2 - (b + c) ** 2) / (2 * a * d)))
    with pytest.raises(ComputationError) as error:
        model(folder, b_mm=60.0)(np.radians(np.arange(0.0, 360.0)))
    message = re.search(
        r"dead point near (\S+) deg: beyond it the loops do not close \(gap_B[xy] is",
        error.value.message,
    )
    assert message is not None
    assert float(message[1]) == pytest.approx(limit, abs=2e-3)


def test_start_in_other_assembly_stays_there(folder: Path) -> None:
    """A coordinate never jumps from one assembly to the other along the turn."""
    values = model(folder)(np.radians(np.arange(0.0, 360.0)))
    assert np.abs(np.diff(values["gamma"])).max() < 0.05


def test_command_prints_and_writes(folder: Path, tmp_path: Path) -> None:
    file = folder / "generated" / "four_bar.toml"
    result = answer(
        "turn",
        str(file),
        "--samples",
        "45",
        "--out",
        str(tmp_path / "run"),
        "--set",
        "omega_rad_s=20",
    )
    jsonschema.validate(result, load_schema("turn"))
    assert (result["machine"], result["samples"]) == ("four_bar", 45)
    assert {law["unit"] for law in result["laws"]} == {"W", "N", "N m"}
    assert max(law["violation"] for law in result["laws"]) < 1e-9
    assert result["work"]["M_in_J"] == pytest.approx(0, abs=1e-4)
    assert result["quantities"]["gamma_deg"].keys() == {
        "unit",
        "min",
        "max",
        "mean",
        "rms",
        "min_deg",
        "max_deg",
    }
    written = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert written["quantities"] == result["quantities"]
    assert {"values.csv", "report.html", "figures"} <= {
        path.name for path in (tmp_path / "run").iterdir()
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("b_mm = 110  # coupler", "[values] lacks b_mm (coupler)"),
        ("a_mm = 40  # crank", "[values] lacks a_mm (crank)"),
    ],
)
def test_missing_value_is_named_with_meaning(folder: Path, text: str, message: str) -> None:
    file = folder / "generated" / "less.toml"
    file.write_text(
        (folder / "generated" / "four_bar.toml").read_text().replace(text, ""), encoding="utf-8"
    )
    with pytest.raises(InputError) as error:
        load(file)
    assert message in error.value.message


def test_misspelt_value_gets_suggestion(folder: Path) -> None:
    file = folder / "generated" / "more.toml"
    text = (folder / "generated" / "four_bar.toml").read_text()
    file.write_text(text.replace("[turn]", "[bounds]\nbb_mm = [1, 2]\n[turn]"), encoding="utf-8")
    with pytest.raises(InputError, match=r"bounds\.bb_mm: did you mean b_mm"):
        load(file)


def test_missing_functions_are_reported(folder: Path) -> None:
    file = folder / "generated" / "lost.toml"
    text = (folder / "generated" / "four_bar.toml").read_text()
    file.write_text(
        text.replace('functions = "four_bar"', 'functions = "five_bar"'), encoding="utf-8"
    )
    with pytest.raises(
        InputError, match=r"five_bar\.py and five_bar\.json must be in the folder of the file"
    ):
        load(file)


def test_negative_mass_is_refused(folder: Path) -> None:
    with pytest.raises(InputError, match=r"values\.m_c_kg = -1.*: it must not be negative"):
        model(folder, m_c_kg=-1.0)


def test_a_mechanism_at_rest_does_no_work(folder: Path) -> None:
    result = compute_cycle(model(folder, omega_rad_s=0.0), 12).result
    assert result.work == {}
    assert result.quantities["gamma_dot_rad_s"].rms == 0
