"""A mechanism of a user's own, derived as a process: its code against the textbook and against its
own energy.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.engine.response import MachineResponse
from planter.errors import ComputationError
from planter.kernels import generated
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "slider_crank.py"
PHI = np.linspace(0, 2 * np.pi, 721)
BARE = {"e_mm": 0.0, "g_m_s2": 0.0, "mu": 0.0, "k_N_m": 0.0, "p_0_N_m2": 0.0}
"""Nothing but inertia, the guide through the crank's axis."""
OWN = {
    "omega_rpm": 105.0,
    "r_mm": 30.0,
    "l_mm": 110.0,
    "c_mm": 40.0,
    "m_r_kg": 0.7,
    "J_kg_m2": 0.0009,
    "m_s_kg": 1.3,
}
R, L, C, M_ROD, J, M, OMEGA = 0.03, 0.11, 0.04, 0.7, 0.0009, 1.3, 105 * np.pi / 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `python -m derive FILE` writes beside a file, run from elsewhere."""
    place = tmp_path_factory.mktemp("own")
    file = shutil.copy(EXAMPLE, place)
    done = subprocess.run(
        [sys.executable, "-m", "derive", file], cwd="/", capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{place / 'generated'}/: 6 files of {file}\n"
    return place / "generated"


def model(folder: Path, **values: float) -> Model:
    return Model(load_machine(str(folder / "slider_crank.toml"), values))


def place_and_acceleration() -> tuple[np.ndarray, np.ndarray]:
    """Of the slider: x = r cos(phi) + sqrt(L^2 - r^2 sin^2(phi)), differentiated twice by hand (any
    mechanics text).
    """
    root = np.sqrt(L**2 - (R * np.sin(PHI)) ** 2)
    bend = (
        -R * np.cos(PHI)
        - R**2 * np.cos(2 * PHI) / root
        - (R**2 * np.sin(2 * PHI)) ** 2 / (4 * root**3)
    )
    return R * np.cos(PHI) + root, OMEGA**2 * bend


def test_place_and_force_are_those_of_the_textbook(folder: Path) -> None:
    outputs, (place, acceleration) = model(folder, **BARE, **OWN)(PHI), place_and_acceleration()
    assert outputs["s"] == pytest.approx(place, rel=1e-14)
    assert outputs["F_Bx"] == pytest.approx(M * acceleration, rel=1e-12, abs=1e-12)


def test_a_heavier_slider_is_noticed(folder: Path) -> None:
    _, acceleration = place_and_acceleration()
    heavier = model(folder, **BARE, **(OWN | {"m_s_kg": 1.4}))(PHI)
    assert heavier["F_Bx"] != pytest.approx(M * acceleration, rel=1e-2)


def test_motor_power_balances_energy(folder: Path) -> None:
    """Torque is the slope of the kinetic energy over the crank angle: no gravity, no friction;
    complex steps.
    """

    def energy(phi: np.ndarray) -> np.ndarray:
        psi = np.arcsin(R / L * np.sin(phi))
        turned = R / L * np.cos(phi) / np.cos(psi) * OMEGA
        slider = -R * OMEGA * np.sin(phi) - L * np.sin(psi) * turned
        rod = (
            -R * OMEGA * np.sin(phi) - C * np.sin(psi) * turned,
            R * OMEGA * np.cos(phi) - C * np.cos(psi) * turned,
        )
        return (M * slider**2 + M_ROD * (rod[0] ** 2 + rod[1] ** 2) + J * turned**2) / 2

    outputs = model(folder, **BARE, **OWN)(PHI)
    assert outputs["M_in"] == pytest.approx(
        np.imag(energy(PHI + 1e-30j)) / 1e-30, rel=1e-11, abs=1e-12
    )


@pytest.mark.parametrize("friction", [0.05, 0.4])
def test_friction_follows_both_signs_of_the_guides_force(folder: Path, friction: float) -> None:
    """The slider's balance, with Coulomb's law typed by hand; the fast one is pressed to either
    side of the guide.
    """
    outputs = model(folder, mu=friction, omega_rpm=900.0)(PHI)
    normal, tangential = (
        outputs["N_guide"],
        outputs["F_Bx"] + outputs["F_gas"] + outputs["F_spring"],
    )
    assert normal.min() < 0 < normal.max()
    drag = -friction * np.abs(normal) * np.where(outputs["v_guide"] >= 0, 1, -1)
    assert tangential + drag == pytest.approx(1.5 * outputs["s_ddot"], abs=1e-9)
    assert outputs["P_guide"].min() >= 0


def test_a_turn_obeys_the_laws_and_a_wrong_reaction_breaks_them(folder: Path) -> None:
    outputs = compute_cycle(model(folder, mu=0.2, omega_rpm=700.0), 90).result
    assert {law.law.partition(",")[0] for law in outputs.laws} >= {
        "power of all forces and of inertia",
        "rate of angular momentum less outer moments",
        "virtual work where phi alone moves",
        "virtual work where beta alone moves",
    }
    assert max(law.violation for law in outputs.laws) < 1e-9
    assert outputs.work["M_in_J"] == pytest.approx(outputs.work["guide_J"], rel=1e-9)
    assert outputs.work["guide_J"] > 0.1


def test_the_casadi_module_builds_and_agrees_with_the_arrays(folder: Path) -> None:
    arrays, derived_model = generated.module("array/slider_crank", folder), model(folder)
    data = derived_model.machine.data
    outputs = arrays.lane(
        np,
        PHI,
        data,
        MachineResponse(derived_model.machine).coordinates(data, PHI),
        arrays.prologue(np, data),
    )
    by_casadi = derived_model(PHI)
    for quantity, values in zip(derived_model.machine.quantities, outputs, strict=True):
        assert by_casadi[quantity.name] == pytest.approx(values + 0 * PHI, rel=1e-10, abs=1e-10), (
            quantity.name
        )


def test_single_side_module_has_no_composed_functions(folder: Path) -> None:
    described = json.loads((folder / "slider_crank.json").read_text())
    assert list(described["functions"]) == [
        "prologue",
        "lane",
        "events",
        "assembly",
        "closure",
        "places",
        "elements",
        "loads",
    ]
    assert list(described["vectors"]) == [
        "data", "loops", "outputs", "start", "gaps", "places", "elements", "state", "loads",
    ]  # fmt: skip
    assert "callables" not in described
    for text in (path.read_text() for path in folder.rglob("slider_crank.py")):
        assert not [
            word
            for word in ("side", "stage", "frame(", "None")
            if word in text.replace("outside", "")
        ]


def test_changed_written_file_is_noticed(folder: Path) -> None:
    command = [sys.executable, "-m", "derive", str(folder.parent / "slider_crank.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "is up to date: 6 files" in done.stdout
    written = folder / "slider_crank.json"
    text = written.read_text()
    written.write_text(text.replace("crank speed", "another speed"))
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    written.write_text(text)
    assert (done.returncode, done.stdout) == (1, "changed: slider_crank.json\n")


def test_jamming_is_reported_and_locking_raises(folder: Path) -> None:
    """Where mu tan(beta) passes one, more states than one are possible, or none."""
    mild, many = (compute_cycle(model(folder, mu=mu), 90).result.laws[-1] for mu in (0.2, 5.0))
    assert mild.law.startswith("states of friction")
    assert (mild.violation, many.violation) == (0, 1)
    with pytest.raises(ComputationError, match="friction holds it fast at"):
        compute_cycle(model(folder, mu=50.0), 90)


def test_nonfinite_result_names_the_angle(folder: Path) -> None:
    with pytest.raises(ComputationError, match=r"F_\w+ \(force of .*\) is not finite at 0 deg"):
        compute_cycle(model(folder, h_mm=0.0), 90)
