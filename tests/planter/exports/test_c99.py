"""C of mechanisms of one's own: it compiles without a warning, and has the model's numbers, loops
closed within it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import Machine
from planter.engine.response import MachineResponse
from planter.kernels import Array
from planter.mechanism import file
from tests.planter.exports.exported import (
    SAMPLES,
    SUMS,
    Library,
    c_files,
    library,
    machine,
    machine_file,
)
from tests.support import own
from tests.support.cli import answer, refusal, run
from tests.support.lanes import needs_compiler

NOT_CLOSED, STUCK = 2, 5
ANGLES = np.array([3.0, 0.0, 7.5, -1.0, 6.283, 40.0, 0.3])
"""In no order, of several turns."""


def model_values(name: str, phi: Array) -> dict[str, Array]:
    return own.evaluate_lane(file.load(machine_file(name)), phi)


def largest_error(actual: Array, names: list[str], expected: dict[str, Array]) -> float:
    """Of each quantity's largest number."""
    rows = np.array([expected[name] for name in names])
    scale = np.maximum(np.abs(rows).max(axis=1), 1e-9)
    return float((np.abs(actual - rows).max(axis=1) / scale).max())


class Sum:
    """Measures of samples with gradients, written out in NumPy; values in the units of the file."""

    def __init__(self, machine_: Machine, x: Array) -> None:
        self.machine, self.x = machine_, x

    def sampled(self, name: str, phi: Array) -> tuple[Array, Array]:
        response = MachineResponse(self.machine, [name])
        values, slopes = response.slopes(response.at(self.x), phi)
        factor = self.machine.find_quantity(name).factor
        return values[0] / factor, slopes[0, :, 1:] / factor

    def term(self, kind: str, name: str) -> tuple[float, Array]:
        v, g = self.sampled(name, 2 * np.pi * np.arange(SAMPLES) / SAMPLES)
        high, low, deviation = int(v.argmax()), int(v.argmin()), v - v.mean()
        if kind == "max abs":
            peak = int(np.abs(v).argmax())
            return abs(v[peak]), np.sign(v[peak]) * g[peak]
        rms, std = np.sqrt((v**2).mean()), v.std()
        return {
            "range": (v[high] - v[low], g[high] - g[low]),
            "min": (v[low], g[low]),
            "mean": (v.mean(), g.mean(axis=0)),
            "rms": (rms, (v @ g) / SAMPLES / rms),
            "std": (std, (deviation @ g) / SAMPLES / std),
            "variance": (v.var(), 2 * (deviation @ g) / SAMPLES),
            "work": (2 * np.pi * v.mean(), 2 * np.pi * g.mean(axis=0)),
        }[kind]

    def total(self, text: str) -> tuple[float, Array]:
        value, gradient = 0.0, np.zeros(len(self.x))
        for term in text.replace(" - ", " + -").split(" + "):
            words = term.split()
            weight = float(words.pop(0)) if words[0].lstrip("-")[0].isdigit() else 1.0
            if "at" in words:
                v, g = (part[0] for part in self.sampled(words[0], np.radians([float(words[2])])))
            else:
                v, g = self.term(" ".join(words[:-1]), words[-1])
            value, gradient = value + weight * v, gradient + weight * g
        return value, gradient


@needs_compiler
@pytest.mark.parametrize("name", SUMS)
def test_c_quantities_equal_those_of_the_model(name: str) -> None:
    status, values = library(name).quantities(ANGLES)
    assert status == 0
    assert largest_error(values, library(name).names, model_values(name, ANGLES)) <= 1e-12


@needs_compiler
@pytest.mark.parametrize("name", SUMS)
def test_c_objective_and_gradient_equal_numpy(name: str) -> None:
    owner = machine(name)
    x = owner.design + 0.1 * (owner.upper - owner.design)
    value, gradient = Sum(owner, x).total(SUMS[name])
    status, objective, slopes = library(name).gradient(x)
    width = owner.upper - owner.lower
    assert status == 0
    assert objective["objective"] == pytest.approx(value, rel=1e-12)
    assert np.abs((slopes - gradient) * width).max() <= 1e-9 * np.abs(gradient * width).max()


@needs_compiler
def test_a_tampered_constant_is_noticed() -> None:
    name = "transplanting_arm"
    head = "const double my_transplanting_arm_2_machine[MY_TRANSPLANTING_ARM_2_MACHINE] = {"
    text = c_files(name)[1].read_text()
    first = text.partition(head)[2].partition(",")[0]
    tampered = Library(c_files(name), (f"{head}{first},", f"{head}{1.001 * float(first)!r},"))
    status, values = tampered.quantities(ANGLES)
    assert status == 0
    assert largest_error(values, tampered.names, model_values(name, ANGLES)) > 1e-5


@needs_compiler
def test_dead_point_and_stuck_friction_are_statuses() -> None:
    crank = library("slider_crank")
    short = crank.x.copy()
    short[1] = 0.05
    assert crank.quantities(ANGLES, short)[0] == NOT_CLOSED
    assert crank.gradient(short)[0] == NOT_CLOSED
    assert crank.quantities(ANGLES)[0] == 0
    index = [value.path for value in (machine("slider_crank").values)].index("values.mu")
    place = index - sum(i < index for i in machine("slider_crank").moved)
    rough = Library(c_files("slider_crank"))
    rough.data[place] = 40.0
    assert rough.quantities(np.linspace(0.0, 6.28, 90))[0] == STUCK


def test_the_header_says_units_meanings_and_the_sum() -> None:
    header = " ".join(c_files("cam_follower")[0].read_text().replace("\n *", " ").split())
    assert "x[0] y_0_mm: y_0 [m] roller's centre at the lowest" in header
    assert "My cam_follower, 2: Cam follower" in header
    assert f"Objective {SUMS['cam_follower']}" in header
    assert "double objective, range_N_cam, variance_N_cam, mean_N_cam, range_s" in header


def test_without_an_objective_there_are_quantities_alone(tmp_path: Path) -> None:
    path = machine_file("cam_follower", objective=False)
    answer(*f"export c {path} --out {tmp_path}".split())
    header = (tmp_path / "my_cam_follower_2.h").read_text()
    assert "_gradient" not in header
    assert "my_cam_follower_2_quantities" in header


def test_tables_of_free_motion_are_refused(tmp_path: Path) -> None:
    path = own.generated("manipulator") / "manipulator.toml"
    message = refusal(*f"export motion {path} --out {tmp_path}".split())
    assert "no angle drives" in message
    assert not list(tmp_path.iterdir())


def test_options_of_other_machines_are_refused(tmp_path: Path) -> None:
    path = str(machine_file("cam_follower"))
    assert "one model" in refusal(*f"export c {path} --model printed --out {tmp_path}".split())
    assert "nothing_here" in refusal(*f"export c nothing_here --out {tmp_path}".split())


def test_speed_and_values_can_be_changed(tmp_path: Path) -> None:
    path = str(machine_file("cam_follower"))
    code, _, err = run(*f"export c {path} --speed-rpm 30 --set m_s_kg=0.5 --out {tmp_path}".split())
    assert code == 0, err
    numbers = (
        (tmp_path / "my_cam_follower_2.c")
        .read_text()
        .partition("_MACHINE] = {")[2]
        .partition("}")[0]
    )
    values = [float(number) for number in numbers.split(", ")]
    assert values[0] == pytest.approx(np.pi, rel=1e-15)
    assert 0.5 in values
