"""Measures of functions with corners, roots, jumps and dead centres: values and gradients against
mpmath.
"""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from planter.engine.goal import Goal, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import parse_sum
from planter.engine.sensitivity import compute_sensitivity
from planter.engine.solvers.cycle_panels import CyclePanels
from tests.support.integrands import INTEGRANDS

SINGULAR = "logarithm"
"""The only function that is not bounded: its value is right, its gradient is not sought."""
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
@pytest.mark.parametrize("name", [name for name in INTEGRANDS if name != SINGULAR])
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


EXTREMES = {
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


@pytest.mark.parametrize(("name", "text"), EXTREMES)
def test_extremes_and_their_gradients(name: str, text: str) -> None:
    machine = INTEGRANDS[name].machine
    value, slopes = EXTREMES[name, text]
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
