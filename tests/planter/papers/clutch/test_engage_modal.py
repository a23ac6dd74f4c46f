"""The one-mode engagement of a clutch file: closed form against integration, print against
derivation, the command.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planter.kernels.formulas import load
from planter.papers.clutch import file, modal_engagement
from tests.support.cli import answer, refusal

CLUTCH = file.load_clutch("shi2021")


@pytest.mark.parametrize("shape", modal_engagement.SHAPES)
def test_the_largest_load_stands_where_it_is_said_to(shape: str) -> None:
    result = modal_engagement.evaluate_engagement(CLUTCH, shape)
    engagement = modal_engagement.build_engagement(CLUTCH.si, shape)
    assert modal_engagement.evaluate_motion(engagement, result.t_max_s)["N"] == pytest.approx(
        result.N_max_N, rel=1e-12
    )
    assert modal_engagement.evaluate_motion(engagement, result.t_loss_s)["N"] == pytest.approx(
        0, abs=1e-9
    )
    assert modal_engagement.evaluate_motion(engagement, 0.0)["N"] == pytest.approx(
        result.N0_N, rel=1e-12
    )
    grid = [
        modal_engagement.evaluate_motion(engagement, t)["N"]
        for t in np.linspace(0, result.t_loss_s, 200)
    ]
    assert max(grid) <= result.N_max_N * (1 + 1e-12)
    assert min(grid[:-1]) > 0
    energy = result.energy
    assert energy.imbalance_J == pytest.approx(0, abs=1e-12 * abs(energy.input_J) + 1e-18)


def test_a_wrong_mass_breaks_the_energy_balance() -> None:
    engagement = modal_engagement.build_engagement(CLUTCH.si)
    extremes = modal_engagement.find_extremes(engagement)
    wrong = engagement | {"M_1": 1.1 * engagement["M_1"]}
    end = modal_engagement.evaluate_motion(engagement, extremes["t_loss"])
    balance = load(modal_engagement.MODEL).pick("energy", wrong | end)
    assert abs(balance["given"] - balance["kept"]) > 1e-3 * abs(balance["given"])


def test_contact_is_never_lost_where_the_driving_force_rules() -> None:
    slow = file.load_clutch("shi2021", {"input_speed_rpm": 0.01, "body_kg": 0.01})
    assert modal_engagement.evaluate_engagement(slow).t_loss_s is None


def test_numbers() -> None:
    """Coefficients of the paper's shape; and (12) as printed, by hand from the file's inputs."""
    result = modal_engagement.evaluate_engagement(CLUTCH)
    assert result.modal.K_coefficient == pytest.approx(np.pi**4 / 32, rel=1e-15)
    assert result.modal.mass_coefficient == pytest.approx(0.5, rel=1e-15)
    edge = 0.02 / np.sqrt(3)
    bending = 206e9 * 5 * np.sqrt(3) / 16 * edge**4 / 0.06**3
    m2, force, speed = (
        7850 * 3 * np.sqrt(3) / 2 * edge**2 * 0.06,
        1.2 / 0.0105,
        45 * np.pi / 30 * 0.0105,
    )
    printed = force + 0.35 * np.sqrt(np.pi**4 / 32 * bending * speed**2 / m2 + force**2 / m2**2)
    assert result.printed.N_max_N == pytest.approx(printed, rel=1e-12)
    moving = 0.35 + m2 / 2
    derived = force + 0.35 * np.sqrt(
        np.pi**4 / 32 * bending * speed**2 / moving + force**2 / moving**2
    )
    assert result.N_max_N == pytest.approx(derived, rel=1e-12)
    assert pytest.approx(force * m2 / 2 / moving, rel=1e-12) == result.N0_N
    assert result.printed.N0_N < 0  # the print starts with a pull


@pytest.mark.usefixtures("blank_figures")
def test_command(tmp_path: Path) -> None:
    words = "clutch", "engage", "shi2021", "--shape", "clamped-mode"
    result = answer(*words, "--out", str(tmp_path))
    assert (result["mode"], result["modal"]["shape"]) == ("modal", "clamped-mode")
    assert json.loads((tmp_path / "summary.json").read_text())["N_max_N"] == result["N_max_N"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--shape", "bow"], "--shape = bow: must be one of quarter-sine"),
        (["--set", "dog.backlash_deg=40"], "dog.backlash_deg"),
        (["--set", "dog.edge_mm=5"], "it must be less than depth_mm = 3.4"),
        (["--set", "rod_mm=90", "--mode", "contact"], "linkage.rod_mm = 90:"),
        (
            ["--set", "root_mm=10", "--mode", "contact"],
            "it must be greater than tooth.tip_mm = 10.5",
        ),
        (
            ["--set", "dog.depth_mm=4.3", "--mode", "contact"],
            "it must be less than sleeve.travel_mm = 4.2",
        ),
        (
            ["--speed-rpm", "3", "--mode", "contact"],
            "engagement.input_speed_rpm = 3.0 (set on the command line)",
        ),
        (
            ["--set", "switching_speed_mm_s=1", "--mode", "contact"],
            "the sleeve is there within 3 s",
        ),
    ],
)
def test_invalid_input_exits_with_single_line(arguments: list[str], message: str) -> None:
    assert message in refusal("clutch", "engage", "shi2021", *arguments)
