"""NUTS on the public density, by the code of the documentation, against the normal approximation."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planter
from planter.measured.sensor_curve import SensorCurve
from planter.mechanism.file import build_from_table
from planter.mechanism.machines import build_machine
from tests.planter.measured.test_noise import correlate
from tests.support import own

GALLERY = Path(__file__).parents[3] / "docs" / "gallery" / "measured.md"


@pytest.mark.long
def test_nuts_agrees_with_normal_approximation(tmp_path: Path) -> None:
    """Mass, lever and offset of a crank: means within 0.3 of a deviation, deviations within 20 %."""
    pytest.importorskip("numpyro", reason="planter[sampling] is not installed")
    file = own.file("slider_crank")
    stated = {"quantity": "F_Oy_N", "drive": "M_in", "lever_mm": 80.0}
    machine = build_machine(build_from_table(file.table() | {"measurement": stated}, "crank.toml", file.place))
    degrees = np.arange(0, 360, 4.0)
    signal = SensorCurve.at_angles(machine, "F_Oy_N", np.radians(degrees)).evaluate(np.zeros(0), np.radians(degrees))[0]
    values = signal[0] + 2.0 + correlate(np.random.default_rng(1), len(degrees), 0.7, 0.02 * np.ptp(signal))
    path = tmp_path / "force.csv"
    rows = (f"{a:.1f},{f:.9f}" for a, f in zip(degrees, values, strict=True))
    path.write_text("\n".join(["angle [deg],force [N]", *rows]) + "\n", encoding="utf-8")
    mass = machine.document.numbers()["values.m_s_kg"]
    bounds = {"m_s_kg": (mass / 2, mass * 2), "measurement.lever_mm": (40.0, 160.0), "offset": (-60.0, 60.0)}
    columns = planter.Columns("force", angle="angle")
    posterior = planter.load_posterior(machine, path, columns, "F_Oy_N", bounds)
    normal = posterior.approximate()
    (code,) = re.findall(r"```python\n(.*?)```", GALLERY.read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, Any] = {"posterior": posterior, "np": np}
    exec(code, names)
    draws = names["draws"]
    assert (np.abs(draws.mean(axis=0) - normal.mean) < 0.3 * normal.std).all()
    np.testing.assert_allclose(draws.std(axis=0), normal.std, rtol=0.2)
    assert (np.abs(draws.mean(axis=0) - [mass, 80.0, 2.0]) < 3 * normal.std).all(), "the truth"
