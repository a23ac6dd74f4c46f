"""`planter simulate` of a mechanism of one's own: one command under two names, results at single
angles, refusals.
"""

from __future__ import annotations

import math

import pytest

from planter.errors import InputError
from planter.mechanism.cycle import simulate_machine
from tests.support import own
from tests.support.cli import answer


@pytest.mark.parametrize("name", ["slider_crank", "wang2017"])
def test_simulate_and_turn_are_the_same_command(name: str) -> None:
    path = name if name == "wang2017" else str(own.generated(name) / f"{name}.toml")
    options = (path, "--samples", "12", "--speed-rpm", "25", "--at", "90")
    assert answer("simulate", *options) == answer("turn", *options)


def test_results_at_angles_are_those_of_geometry() -> None:
    """A slider stands at r cos phi + sqrt(l^2 - (e - r sin phi)^2)."""
    result = simulate_machine(own.machine("slider_crank"), 12, [37.0, 397.0, -90.0]).result
    assert [state["phi_deg"] for state in result.at] == [37.0, 397.0, -90.0]
    for state in result.at:
        phi = math.radians(state["phi_deg"])
        expected = 50 * math.cos(phi) + math.sqrt(200**2 - (10 - 50 * math.sin(phi)) ** 2)
        assert state["s_mm"] == pytest.approx(expected, rel=1e-12)
    assert simulate_machine(own.machine("slider_crank"), 12).result.at == []


@pytest.mark.parametrize(("samples", "angle"), [(3, 0.0), (100_001, 0.0), (12, math.nan)])
def test_simulate_refuses_numbers_out_of_range(samples: int, angle: float) -> None:
    with pytest.raises(InputError, match=r"--(samples|at) = "):
        simulate_machine(own.machine("slider_crank"), samples, [angle])
