"""True extremes and integrals of functions with corners, roots and jumps against mpmath: of a
machine, and of rows.
"""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from planter.engine.outputs import SampledOutputs
from planter.engine.summary import summarise_machine
from planter.kernels import Array
from planter.mechanism.cycle import simulate_machine
from tests.support.integrands import INTEGRANDS, Integrand, R, S

KINDS = ("mean", "rms", "max", "min")
UNBOUNDED = {"logarithm"}
"""Functions without a least value."""
NOT_REPEATING = {"dwell", "either_condition", "direction_through_pole"}
"""Functions that differ after a turn, so that rows have no means of them."""
ROWS = np.array([[1.0, 0.3], [0.9, 0.25], [1.2, 0.42]])
"""Values of r and s."""


def mean_and_rms(integrand: Integrand, r: float = R, s: float = S) -> tuple[float, float]:
    with mpmath.workdps(30):
        return float(integrand.integrate(r, s)), float(
            mpmath.sqrt(integrand.integrate(r, s, power=2))
        )


def sample_densely(integrand: Integrand, r: float = R, s: float = S) -> Array:
    """Return values at many angles, which no extreme is within, and at one-sided places of
    breaks.
    """
    with mpmath.workdps(30):
        angles = [mpmath.mpf(k) / 50 for k in range(1, 314)]
        angles += [p % (2 * mpmath.pi) + d for p in integrand.breaks(r, s) for d in (-1e-12, 1e-12)]
        inside = [angle for angle in angles if 0 < angle < 2 * mpmath.pi]
        return np.array(
            [float(integrand.evaluate(t, mpmath.mpf(r), mpmath.mpf(s))) for t in inside]
        )


@pytest.mark.parametrize("name", INTEGRANDS)
def test_measures_match_mpmath(name: str) -> None:
    peak = summarise_machine(INTEGRANDS[name].machine).peaks[0]
    mean, rms = mean_and_rms(INTEGRANDS[name])
    assert (peak.mean, peak.rms) == pytest.approx((mean, rms), abs=1e-9 * rms)
    if name in UNBOUNDED:
        return
    values = sample_densely(INTEGRANDS[name])
    size = np.abs(values).max()
    assert peak.max >= values.max() - 1e-9 * size
    assert peak.min <= values.min() + 1e-9 * size
    assert peak.max <= values.max() + 0.02 * size
    assert peak.min >= values.min() - 0.02 * size


EXTREMES = {
    "root_of_part": (0.7**0.5, 0.0),
    "size": (1.3, 0.0),
    "greatest_of_three": (1.3, 0.8),
    "norm_at_rest": (2.0, 0.0),
    "norm_of_root": (2**0.5, 0.0),
    "dead_centre": (2.0, 0.0),
    "angle_at_dead_centre": (np.pi, 0.0),
    "sign_of_friction": (1.91, -2.0),
    "narrow_pulse": (100.0, 0.3),
    "saw": (1.0, 0.0),
    "direction": (np.pi, -np.pi),
}
"""Greatest and least values in closed form."""


@pytest.mark.parametrize("name", EXTREMES)
def test_extremes_match_closed_forms(name: str) -> None:
    peak = summarise_machine(INTEGRANDS[name].machine).peaks[0]
    assert (peak.max, peak.min) == pytest.approx(EXTREMES[name], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", sorted(set(INTEGRANDS) - UNBOUNDED - NOT_REPEATING))
def test_rows_have_measures_of_one_machine(name: str) -> None:
    machine = INTEGRANDS[name].machine
    outputs = SampledOutputs(machine, ["values.r", "values.s"], [f"y_{kind}" for kind in KINDS])
    values = outputs.evaluated(ROWS, 1)
    for (r, s), row in zip(ROWS, values, strict=True):
        mean, rms = mean_and_rms(INTEGRANDS[name], r, s)
        assert row[:2] == pytest.approx((mean, rms), abs=1e-9 * rms)
        peak = summarise_machine(machine.with_numbers({"values.r": r, "values.s": s})).peaks[0]
        assert row == pytest.approx((peak.mean, peak.rms, peak.max, peak.min), abs=1e-8 * rms)


def test_simulated_quantities_are_true_whatever_the_samples() -> None:
    integrand = INTEGRANDS["root_of_part"]
    few, many = (
        simulate_machine(integrand.machine, count).result.quantities["y"] for count in (24, 720)
    )
    assert few == many
    mean, rms = mean_and_rms(integrand)
    assert (few.mean, few.rms, few.max) == pytest.approx((mean, rms, 0.7**0.5), rel=1e-12)


def test_machine_without_events_has_no_jumps() -> None:
    """So that the tests above can fail."""
    machine = INTEGRANDS["sign_of_friction"].machine
    assert len(summarise_machine(machine).shocks) == 2
    assert summarise_machine(replace(machine, events=None, event_kinds=())).shocks == []


def test_pole_takes_the_summary_of_one_quantity_alone() -> None:
    machine = Integrand("1/(r*cos(t) - s)", lambda r, s: []).machine
    result = simulate_machine(machine).result
    assert result.designer is not None
    assert result.designer.peaks == []
    assert [warning.name for warning in result.warnings] == ["no_summary"]
    assert np.cos(np.radians(result.warnings[0].phi_deg or 0.0)) == pytest.approx(S / R, abs=1e-6)
    assert result.quantities["y"].max < np.inf
