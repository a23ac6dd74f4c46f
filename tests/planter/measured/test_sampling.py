"""NUTS on the public density, by the code of the documentation, against the normal
approximation.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planter
from planter.kernels import Array
from planter.measured.posterior import Posterior
from planter.measured.sensor_curve import SensorCurve
from planter.mechanism.file import build_from_table
from planter.mechanism.machines import build_machine
from tests.planter.measured.test_noise import correlate
from tests.support import own

GALLERY = Path(__file__).parents[3] / "docs" / "gallery" / "measured.md"


PAGE = GALLERY.read_text(encoding="utf-8")
SAMPLERS = {"numpyro": "NumPyro", "pymc": "PyMC"}
"""Rows of the page's table by the package that the code imports."""


def draw_by_page(package: str, posterior: Posterior) -> Array:
    """Run the page's code for a package, and return its draws (m, n)."""
    pytest.importorskip(package, reason=f"{package} is not installed")
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names: dict[str, Any] = {"posterior": posterior, "np": np}
    exec(next(block for block in blocks if f"import {package}\n" in block), names)
    draws: Array = names["draws"]
    return draws


def read_row(name: str) -> tuple[Array, Array]:
    """Return means (n,) and deviations (n,) of a row of the page's table."""
    (row,) = re.findall(rf"^\| {name} \|(.*)\|$", PAGE, re.MULTILINE)
    numbers = np.array(re.findall(r"[\d.]+", row), dtype=float)
    return numbers[::2], numbers[1::2]


@pytest.mark.long
@pytest.mark.parametrize("package", SAMPLERS)
def test_page_has_the_figures_of_its_code(package: str) -> None:
    """Its force and its samplers: means within 0.2 of a deviation, deviations within 10 %."""
    cells = re.findall(r"```\{code-cell\}\n(.*?)```", PAGE, re.DOTALL)
    names: dict[str, Any] = {}
    exec(cells[0], names)
    exec(next(cell for cell in cells if "load_posterior" in cell), names)
    normal = names["posterior"].approximate()
    means, deviations = read_row("`approximate`")
    np.testing.assert_allclose(means, normal.mean, rtol=2e-3)
    np.testing.assert_allclose(deviations, normal.std, rtol=1e-2)
    draws = draw_by_page(package, names["posterior"])
    means, deviations = read_row(SAMPLERS[package])
    assert (np.abs(draws.mean(axis=0) - means) < 0.2 * deviations).all()
    np.testing.assert_allclose(draws.std(axis=0), deviations, rtol=0.1)


@pytest.mark.long
@pytest.mark.parametrize("package", SAMPLERS)
def test_nuts_agrees_with_normal_approximation(tmp_path: Path, package: str) -> None:
    """Mass, lever and offset of a crank: means within 0.3 of a deviation, deviations within 20
    %.
    """
    file = own.file("slider_crank")
    stated = {"quantity": "F_Oy_N", "drive": "M_in", "lever_mm": 80.0}
    machine = build_machine(
        build_from_table(file.table() | {"measurement": stated}, "crank.toml", file.place)
    )
    degrees = np.arange(0, 360, 4.0)
    signal = SensorCurve.at_angles(machine, "F_Oy_N", np.radians(degrees)).evaluate(
        np.zeros(0), np.radians(degrees)
    )[0]
    values = (
        signal[0]
        + 2.0
        + correlate(np.random.default_rng(1), len(degrees), 0.7, 0.02 * np.ptp(signal))
    )
    path = tmp_path / "force.csv"
    rows = (f"{a:.1f},{f:.9f}" for a, f in zip(degrees, values, strict=True))
    path.write_text("\n".join(["angle [deg],force [N]", *rows]) + "\n", encoding="utf-8")
    mass = machine.document.numbers()["values.m_s_kg"]
    bounds = {
        "m_s_kg": (mass / 2, mass * 2),
        "measurement.lever_mm": (40.0, 160.0),
        "offset": (-60.0, 60.0),
    }
    columns = planter.Columns("force", angle="angle")
    posterior = planter.load_posterior(machine, path, columns, "F_Oy_N", bounds)
    normal = posterior.approximate()
    draws = draw_by_page(package, posterior)
    assert (np.abs(draws.mean(axis=0) - normal.mean) < 0.3 * normal.std).all()
    np.testing.assert_allclose(draws.std(axis=0), normal.std, rtol=0.2)
    assert (np.abs(draws.mean(axis=0) - [mass, 80.0, 2.0]) < 3 * normal.std).all(), "the truth"
