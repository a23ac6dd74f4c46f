"""A fit that rests on a bound is not settled: the bound is named unless a fit inside of it is as
good.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.engine.machine import Machine
from planter.measured.calibration import describe_active_bounds
from planter.measured.curve import Chosen, MeasuredCurve
from planter.measured.fit import Fit, fit_curve
from planter.measured.reading import Channel, Measurement
from planter.mechanism.model import Model
from tests.planter.measured.test_noise import judge
from tests.support import own

DEGREES = np.arange(0, 360, 3.0)
MASS, STIFFNESS = 1.8, 720.0
NOISE = 1.0


@pytest.fixture(scope="module")
def crank() -> Machine:
    return own.machine("slider_crank", "", m_s_kg=MASS, k_N_m=STIFFNESS)


@pytest.fixture(scope="module")
def measured(crank: Machine) -> Measurement:
    values = Model(crank).results(np.radians(DEGREES))["F_Ox_N"]
    values = values + 2.0 + np.random.default_rng(5).normal(0, NOISE, len(values))
    return Measurement(
        np.radians(DEGREES), (Channel("F", "N", values, np.ones(len(values), bool), NOISE),)
    )


def fit_within(crank: Machine, measured: Measurement, **bounds: tuple[float, float]) -> Fit:
    chosen = Chosen.from_bounds(crank, {"m_s_kg": (1.0, 3.0), "offset_N": (-60.0, 60.0)} | bounds)
    return fit_curve(MeasuredCurve(crank, chosen, measured, "F_Ox_N"), starts=2)


def name_bounds(fit: Fit) -> list[tuple[str, str]]:
    return [(bound.name, bound.side) for bound in describe_active_bounds(fit)]


def test_fit_inside_bounds_explains(crank: Machine, measured: Measurement) -> None:
    fit = fit_within(crank, measured)
    assert (judge(fit), name_bounds(fit)) == ("explained", [])


@pytest.mark.parametrize(("low", "high", "side"), [(1.0, 1.797, "upper"), (1.803, 3.0, "lower")])
def test_fit_on_a_bound_is_not_settled(
    crank: Machine, measured: Measurement, low: float, high: float, side: str
) -> None:
    """The tampered case: a bound less than a deviation from the truth, so that noise alone is
    left.
    """
    fit = fit_within(crank, measured, m_s_kg=(low, high))
    assert (judge(fit), name_bounds(fit)) == ("not settled", [("values.m_s_kg", side)])


def test_bound_without_effect_does_not_count(crank: Machine, measured: Measurement) -> None:
    """The data depend on the inertia of the crank by less than their noise."""
    fit = fit_within(crank, measured, J_kg_m2=(0.0039, 0.0041))
    lower, upper = fit.curve.bounds(fit.values)
    assert np.isclose(fit.values, [lower, upper], rtol=1e-6).any(axis=0)[2], "on a bound"
    assert (judge(fit), name_bounds(fit)) == ("explained", [])
