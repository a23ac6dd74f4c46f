"""A mechanism of a user's own, derived as a process: its code against the textbook and against its own energy."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from planter.kernels import generated

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "slider_crank.py"
DATA = {"omega": 11.0, "r": 0.03, "L": 0.11, "c": 0.04, "m": 0.7, "J": 0.0009, "M": 1.3}
PHI = np.linspace(0, 2 * np.pi, 721)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `python -m derive FILE` writes beside a file, run from elsewhere."""
    place = tmp_path_factory.mktemp("own")
    file = place / "slider_crank.py"
    file.write_text(EXAMPLE.read_text(encoding="utf-8"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "derive", str(file)], cwd="/", capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{place / 'generated'}/: 5 files of {file}\n"
    return place / "generated"


def names(folder: Path) -> list[str]:
    return [entry["name"] for entry in json.loads((folder / "slider_crank.json").read_text())["vectors"]["forces"]]


def by_arrays(folder: Path, **changed: float) -> dict[str, np.ndarray]:
    code = generated.module("array/slider_crank", folder)
    data = list({**DATA, **changed}.values())
    return dict(zip(names(folder), code.lane(np, PHI, data, code.prologue(np, data)), strict=True))


def place_and_acceleration() -> tuple[np.ndarray, np.ndarray]:
    """Of the slider: x = r cos(phi) + sqrt(L^2 - r^2 sin^2(phi)), differentiated twice by hand (any mechanics text)."""
    r, L, omega = DATA["r"], DATA["L"], DATA["omega"]
    root = np.sqrt(L**2 - (r * np.sin(PHI)) ** 2)
    bend = -r * np.cos(PHI) - r**2 * np.cos(2 * PHI) / root - (r**2 * np.sin(2 * PHI)) ** 2 / (4 * root**3)
    return r * np.cos(PHI) + root, omega**2 * bend


def test_place_and_force_are_those_of_the_textbook(folder: Path) -> None:
    found, (place, acceleration) = by_arrays(folder), place_and_acceleration()
    assert found["x_B"] == pytest.approx(place, rel=1e-14)
    assert found["F_Bx"] == pytest.approx(DATA["M"] * acceleration, rel=1e-12, abs=1e-12)


def test_a_heavier_slider_is_noticed(folder: Path) -> None:
    _, acceleration = place_and_acceleration()
    assert by_arrays(folder, M=1.4)["F_Bx"] != pytest.approx(DATA["M"] * acceleration, rel=1e-2)


def test_the_motor_gives_what_the_energy_takes(folder: Path) -> None:
    """Torque is the slope of the kinetic energy over the crank angle: no gravity, no friction; complex steps."""
    r, L, c, omega = DATA["r"], DATA["L"], DATA["c"], DATA["omega"]

    def energy(phi: np.ndarray) -> np.ndarray:
        psi = np.arcsin(r / L * np.sin(phi))
        turn = r / L * np.cos(phi) / np.cos(psi) * omega
        slider = -r * omega * np.sin(phi) - L * np.sin(psi) * turn
        rod = (-r * omega * np.sin(phi) - c * np.sin(psi) * turn, r * omega * np.cos(phi) - c * np.cos(psi) * turn)
        return (DATA["M"] * slider**2 + DATA["m"] * (rod[0] ** 2 + rod[1] ** 2) + DATA["J"] * turn**2) / 2

    assert by_arrays(folder)["M_O"] == pytest.approx(np.imag(energy(PHI + 1e-30j)) / 1e-30, rel=1e-11, abs=1e-12)


def test_the_casadi_module_builds_and_agrees(folder: Path) -> None:
    code, data = generated.module("slider_crank", folder), list(DATA.values())
    hoisted, lane = code.prologue()(data), code.lane()
    found = [lane(phi, data, hoisted).full().ravel() for phi in PHI[::60]]
    expected = np.array([values[::60] for values in by_arrays(folder).values()]).T
    assert np.array(found) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_one_side_without_composed_functions_is_a_clean_module(folder: Path) -> None:
    described = json.loads((folder / "slider_crank.json").read_text())
    assert list(described["functions"]) == ["prologue", "lane"]
    assert list(described["vectors"]) == ["data", "forces"]
    assert not {"callables", "events"} & described.keys()
    for text in (path.read_text() for path in folder.rglob("slider_crank.py")):
        assert not [word for word in ("side", "stage", "frame(", "None", "events") if word in text]


def test_what_is_written_compares_equal_and_a_changed_file_does_not(folder: Path) -> None:
    command = [sys.executable, "-m", "derive", str(folder.parent / "slider_crank.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "is up to date: 5 files" in done.stdout
    written = folder / "slider_crank.json"
    text = written.read_text()
    written.write_text(text.replace("crank speed", "another speed"))
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    written.write_text(text)
    assert (done.returncode, done.stdout) == (1, "changed: slider_crank.json\n")
