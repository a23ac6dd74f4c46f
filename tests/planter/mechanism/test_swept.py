"""Sweeps of mechanisms of one's own: every row is the turn of the mechanism with these values."""

import numpy as np
import pytest

from planter.errors import InputError
from planter.mechanism.machines import takes
from planter.rows.points import Plan
from planter.rows.sweep import Sweep
from tests.support import own


def plan(**more: object) -> Plan:
    folder = own.generated("slider_crank")
    table = {
        "machine": str(folder / "slider_crank.toml"),
        "outputs": ["M_in_max_Nm", "F_Ox_range_N", "M_in_rms_Nm"],
        "inputs": {"r_mm": [50, 60], "omega_rpm": [200, 400]},
    }
    return Plan.read(table | more, "plan.toml")


def test_row_with_open_loop_is_empty() -> None:
    sweep = Sweep(plan(inputs={"r_mm": [60, 5000]}))
    rows = sweep.recipe.job().chunk(0, 2, 1)
    assert np.isfinite(rows[0]).all()
    assert np.isnan(rows[1]).all()


def test_machine_without_a_motor_needs_outputs() -> None:
    with pytest.raises(InputError, match="outputs is missing"):
        Sweep(plan(machine="yu2023", inputs={"bars.L1_mm": [60, 70]}, outputs=[]))


def test_non_mechanism_is_not_accepted() -> None:
    assert not takes("wang2017")
    assert not takes("nowhere.toml")
