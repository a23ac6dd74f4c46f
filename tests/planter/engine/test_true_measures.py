"""True extremes and integrals of functions with corners, roots, jumps and dead centres against
mpmath: of a machine, of rows, and of goals with their gradients.
"""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from planter.engine.goal import Goal, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import parse_sum
from planter.engine.outputs import SampledOutputs
from planter.engine.sensitivity import compute_sensitivity
from planter.engine.solvers.cycle_panels import CyclePanels
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


POWERS = {"mean": 1, "rms": 2}


def build(machine: Machine, text: str) -> Goal:
    return Goal(machine, [resolve_measure(machine, measure) for measure in parse_sum(text)])


def find_exact(name: str, kind: str) -> tuple[float, list[float]]:
    """Return mean or root mean square with its derivatives in r and s."""
    power = POWERS[kind]
    value, slopes = (
        INTEGRANDS[name].integrate(power=power),
        INTEGRANDS[name].differentiate(power=power),
    )
    if power == 1:
        return float(value), [float(slope) for slope in slopes]
    root = mpmath.sqrt(value)
    return float(root), [float(slope / (2 * root)) for slope in slopes]


@pytest.mark.parametrize("kind", POWERS)
@pytest.mark.parametrize("name", [name for name in INTEGRANDS if name not in UNBOUNDED])
def test_integrals_and_their_gradients(name: str, kind: str) -> None:
    machine = INTEGRANDS[name].machine
    goal, (value, slopes) = build(machine, f"{kind} y"), find_exact(name, kind)
    scale = max(1.0, abs(value), *map(abs, slopes))
    assert goal.evaluate(machine.design) == pytest.approx(value, rel=1e-9, abs=1e-9)
    np.testing.assert_allclose(goal.slope(machine.design), slopes, rtol=1e-7, atol=1e-8 * scale)


@pytest.mark.parametrize(
    "name", ["root_of_part", "size", "case_that_jumps", "norm_at_rest", "dead_centre", "dwell"]
)
def test_sums_are_those_of_their_measures(name: str) -> None:
    """Variance, deviation and work follow from mean and root mean square; so do their gradients."""
    machine = INTEGRANDS[name].machine
    (mean, mean_slope), (rms, rms_slope) = (
        (value, np.array(slopes)) for value, slopes in (find_exact(name, kind) for kind in POWERS)
    )
    variance, slope = rms**2 - mean**2, 2 * rms * rms_slope - 2 * mean * mean_slope
    goal = build(machine, "variance y - 2 mean y")
    assert goal.evaluate(machine.design) == pytest.approx(variance - 2 * mean, rel=1e-9)
    np.testing.assert_allclose(goal.slope(machine.design), slope - 2 * mean_slope, atol=1e-8)
    goal = build(machine, "std y")
    np.testing.assert_allclose(goal.slope(machine.design), slope / (2 * variance**0.5), atol=1e-7)


SLOPED_EXTREMES = {
    ("size", "max y"): (1.3, [1, 1]),
    ("size", "range y"): (1.3, [1, 1]),
    ("part", "max y"): (0.7, [1, -1]),
    ("clipped", "range y"): (0.6, [0, 2]),
    ("case_that_jumps", "max y"): (np.sqrt(0.91), [np.sqrt(0.91), -0.3 / np.sqrt(0.91)]),
    ("greatest_of_three", "range y"): (0.5, [0.5, 0]),
    ("sign_of_friction", "jump y"): (2 * (1 + 0.91), [2, -4 * 0.3]),
    ("root_of_part", "max y"): (np.sqrt(0.7), [0.5 / np.sqrt(0.7), -0.5 / np.sqrt(0.7)]),
    ("size_within_size", "max abs y"): (0.7, [1, -1]),
}


@pytest.mark.parametrize(("name", "text"), SLOPED_EXTREMES)
def test_extremes_have_gradients(name: str, text: str) -> None:
    machine = INTEGRANDS[name].machine
    value, slopes = SLOPED_EXTREMES[name, text]
    goal = build(machine, text)
    assert goal.evaluate(machine.design) == pytest.approx(value, rel=1e-9)
    np.testing.assert_allclose(goal.slope(machine.design), slopes, atol=1e-7)


def test_what_a_condition_leaves_moves_with_its_ends() -> None:
    """r/(1 + s cos t) where it is at least 1: cos t <= (r - 1)/s, of which r = 1 leaves the half
    where cos t <= 0.
    """
    machine = INTEGRANDS["smooth"].machine
    goal = build(machine, "mean y while y >= 1")

    def mean(r: mpmath.mpf, s: mpmath.mpf) -> mpmath.mpf:
        end = mpmath.acos((r - 1) / s)
        total = mpmath.quad(lambda t: r / (1 + s * mpmath.cos(t)), [end, mpmath.pi])
        return total / (mpmath.pi - end)

    assert goal.evaluate(machine.design) == pytest.approx(
        float(mean(mpmath.mpf(1), mpmath.mpf(0.3))), rel=1e-12
    )
    slopes = [float(mpmath.diff(mean, (1, mpmath.mpf(0.3)), order)) for order in ((1, 0), (0, 1))]
    np.testing.assert_allclose(goal.slope(machine.design), slopes, rtol=1e-9)


def test_root_of_a_part_as_it_was_reported() -> None:
    """The mean of a root by cases; sums over 360 samples miss its gradient by 4 %."""
    machine = INTEGRANDS["root_of_part"].machine
    terms = [resolve_measure(machine, measure) for measure in parse_sum("mean y")]
    exact, sampled = compute_sensitivity(machine, terms), compute_sensitivity(machine, terms, 360)
    assert (exact.kind, exact.samples, sampled.kind, sampled.samples) == (
        "true",
        None,
        "sampled",
        360,
    )
    assert exact.objective == pytest.approx(0.26006829287648816, rel=1e-12)
    assert list(exact.gradient.values()) == pytest.approx(
        [0.24781919422178996, -0.39261682594515304], rel=1e-10
    )
    assert abs(sampled.gradient["s"] / exact.gradient["s"] - 1) > 0.01


def test_fixed_nodes_would_miss_the_motion_of_a_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = INTEGRANDS["case_that_jumps"].machine
    slopes = find_exact("case_that_jumps", "mean")[1]
    monkeypatch.setattr(
        CyclePanels, "_velocity", property(lambda panels: np.zeros((len(panels.breaks), 2)))
    )
    assert np.abs(build(machine, "mean y").slope(machine.design) - slopes).max() > 0.1
