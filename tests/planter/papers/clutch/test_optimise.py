"""Fastest switching: exact derivatives, an optimum that another solver does not beat, a certificate
that can fail.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize

from planter.engine.solvers.certificate import check_conditions, estimate_multipliers, kkt_residual
from planter.engine.solvers.epigraph import Epigraph
from planter.errors import InputError
from planter.papers.clutch import file
from planter.papers.clutch.results import FastestSwitching, SwitchingDesign
from planter.papers.clutch.sizing import VARIABLES, SwitchingProblem, optimise_clutch

CLUTCH = file.load_clutch("shi2021")


@cache
def optimum() -> FastestSwitching:
    return optimise_clutch(CLUTCH)


def at(switching: SwitchingProblem, design: SwitchingDesign) -> np.ndarray:
    """The point of the box."""
    corners = np.array(
        [
            getattr(design, key)
            * (np.pi / 180 if key.endswith("deg") else 1e-3 if key.endswith("mm") else 1)
            for key in VARIABLES
        ]
    )
    return (corners - switching.box.origin) / switching.box.unit


def programme_of(switching: SwitchingProblem) -> Epigraph:
    return Epigraph(
        switching.problem, switching.problem.local(switching.box.start), switching.box.start
    )


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_against_differences(seed):
    switching = SwitchingProblem(CLUTCH)
    programme = programme_of(switching)
    u, h = np.random.default_rng(seed).uniform(0.1, 0.9, 5), 1e-5
    steps = h * np.eye(5)
    multipliers = np.random.default_rng(seed + 9).normal(size=len(switching.names))

    def slope(z):
        return 0.7 * programme.gradient(z) + programme.jacobian(z).T @ multipliers

    gradient = [(programme.f(u + s) - programme.f(u - s)) / (2 * h) for s in steps]
    jacobian = np.array([(programme.g(u + s) - programme.g(u - s)) / (2 * h) for s in steps]).T
    hessian = np.array([(slope(u + s) - slope(u - s)) / (2 * h) for s in steps])
    assert programme.gradient(u) == pytest.approx(gradient, rel=1e-6, abs=1e-8)
    assert programme.jacobian(u) == pytest.approx(jacobian, rel=1e-6, abs=1e-8)
    assert programme.hessian(u, 0.7, multipliers) == pytest.approx(hessian, rel=1e-5, abs=1e-6)


def test_the_optimum_keeps_every_limit_and_is_certified():
    proof = optimum().certificate
    assert proof.kkt_residual < 1e-6
    assert proof.agreeing_starts == proof.starts == 8
    assert min(optimum().least_margin_along.values()) > -1e-6
    switching = SwitchingProblem(CLUTCH)
    assert switching.margins.values(switching.box.at(at(switching, optimum().design))).min() > -1e-6
    assert optimum().travel_time_s < optimum().start_travel_time_s
    for key, (low, high) in optimum().bounds.items():
        assert low <= getattr(optimum().design, key) <= high


def test_another_solver_does_not_beat_it():
    programme = programme_of(SwitchingProblem(CLUTCH))
    best = optimum().travel_time_s / optimum().start_travel_time_s
    random = np.random.default_rng(4)
    limits = {"type": "ineq", "fun": programme.g, "jac": programme.jacobian}
    for _ in range(3):
        solution = minimize(
            programme.f,
            random.random(5),
            jac=programme.gradient,
            bounds=[(0, 1)] * 5,
            method="SLSQP",
            constraints=[limits],
            options={"maxiter": 300, "ftol": 1e-12},
        )
        if solution.success and programme.g(solution.x).min() > -1e-8:
            assert solution.fun > best * (1 - 1e-5)


def test_point_off_the_optimum_has_no_certificate():
    switching = SwitchingProblem(CLUTCH, optimum().stations)
    problem, u = switching.problem, at(switching, optimum().design)
    assert kkt_residual(problem, u) < 1e-5
    for i in range(5):
        moved = u.copy()
        moved[i] += 0.02 if u[i] < 0.5 else -0.02
        assert kkt_residual(problem, moved) > 1e-3


def test_a_wrong_multiplier_is_noticed():
    switching = SwitchingProblem(CLUTCH, optimum().stations)
    problem, u = switching.problem, at(switching, optimum().design)
    m = estimate_multipliers(problem, u)
    assert (m.required <= 0).all()
    for wrong in (-m.required, 2 * m.required, 0 * m.required, np.roll(m.required, 1)):
        assert check_conditions(problem, u, replace(m, required=wrong)).worst > 1e-3


def test_relaxing_active_limits_saves_time():
    """A multiplier is the share of the time that a share of its limit is worth."""
    multipliers = {a.name: a.multiplier for a in optimum().certificate.active}
    assert {"normal force", "teeth"} <= multipliers.keys()
    assert sum(
        m for name, m in multipliers.items() if name.startswith("tooth force")
    ) == pytest.approx(0.9435, abs=1e-2)
    for name, key in (("normal force", "normal_force_N"), ("tooth force", "tooth_force_N")):
        share = 1e-4
        limit = getattr(CLUTCH.limits, key)
        freed = optimise_clutch(
            file.load_clutch("shi2021", {key: limit * (1 + share)})
        ).travel_time_s
        gained = (optimum().travel_time_s - freed) / optimum().start_travel_time_s / share
        worth = sum(m for active, m in multipliers.items() if active.startswith(name))
        assert gained == pytest.approx(worth, rel=0.02)


def test_the_time_goes_with_the_speed_of_the_links():
    faster = optimise_clutch(file.load_clutch("shi2021", {"lift_rad_s": 1.8}))
    assert faster.travel_time_s == pytest.approx(optimum().travel_time_s / 2, rel=1e-6)


def test_bounds_without_closed_linkage_are_refused():
    with pytest.raises(
        InputError, match=r"search.rod_bounds_mm = \[40.0, 60.0\]: it must lie between"
    ):
        optimise_clutch(file.load_clutch("shi2021", {"rod_bounds_mm[1]": 60}))
