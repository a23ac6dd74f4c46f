"""Sizes hold the inequalities and say what binds; the fastest switching is certified, and no other
solver beats it.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from planter.engine.solvers.certificate import kkt_residual
from planter.errors import ComputationError, InputError, Interrupted
from planter.papers.clutch import sizing
from planter.papers.clutch.file import load_clutch
from planter.papers.clutch.model import CrankLinkage
from planter.papers.clutch.results import FastestSwitching, Sizing
from planter.papers.clutch.rotor import Rotor
from planter.papers.clutch.sizing import (
    VARIABLES,
    build_refusal,
    build_switching,
    compute_sizes,
    find_peaks,
    find_worst,
    optimise_clutch,
    size_clutch,
)

CLUTCH = load_clutch("shi2021")
SIZED_TO = {
    "fillet that the tooth tips clear",
    "tooth tips go round the shaft",
    "tooth roots clear the shaft's corners",
    "travel of the sleeve",
    "least axial angle for a travel",
}


def sizes(**changes: float) -> Sizing:
    return size_clutch(load_clutch("shi2021", changes))


@pytest.mark.parametrize(
    "changes",
    [{}, {"flat_to_flat_mm": 26, "space_radius_mm": 30}, {"wanted_travel_mm": 3}, {"wall_mm": 3}],
)
def test_least_sizes_hold_every_inequality_of_the_clutch(changes: dict[str, float]) -> None:
    result = sizes(**changes)
    assert all(c.holds for c in result.conditions[:8])
    assert set(result.binds) >= SIZED_TO


def test_sizes_are_those_of_the_laws() -> None:
    result = sizes()
    s, flats = result.sizes, 20.0
    assert s.tip_mm == pytest.approx(flats / (2 * math.sin(math.radians(72))), rel=1e-13)
    assert s.fillet_mm == pytest.approx(Rotor(5, 6, flats).ellipse["fillet"], rel=1e-12)
    corner = (flats / 2 - s.fillet_mm) / math.cos(math.pi / 6) + s.fillet_mm
    assert s.root_mm == pytest.approx(corner, rel=1e-13)
    assert s.right_radius_mm == pytest.approx(s.root_mm + 1, rel=1e-13)
    assert s.left_radius_mm == pytest.approx(s.outline_mm, rel=1e-12)
    taper = math.tan(math.radians(s.axial_angle_deg))
    assert s.left_radius_mm - s.right_radius_mm == pytest.approx(10 * taper, rel=1e-12)
    assert s.outline_mm - s.width_mm / 2 == pytest.approx(4.2 * taper, rel=1e-12)
    linkage = CrankLinkage.from_lengths(result.linkage)
    turned = result.linkage.crank_rotation_deg
    assert np.degrees(linkage.rotation(0.0042)) == pytest.approx(turned, abs=1e-9)
    assert turned == pytest.approx((10 - 5) * 46 / 14, rel=1e-12)


def test_a_smaller_hexagon_would_not_do() -> None:
    """Shrinking the hexagon at the same travel leaves less than the wall outside the tooth
    roots.
    """
    values = compute_sizes(CLUTCH)
    side = 0.99 * values["a"]
    outline = side * math.sqrt(3) / (2 * math.sin(math.radians(72)))
    apothem = side * math.sqrt(3) / 2
    thin_end = outline - values["d"] * (outline - apothem) / values["c"]
    assert thin_end < values["b2"] + 0.001


@pytest.mark.parametrize(
    ("changes", "worst"),
    [
        ({"space_radius_mm": 14}, "corners of the hexagonal hole within the space"),
        ({"space_length_mm": 12}, "body and way of the sleeve within the space"),
        ({"normal_force_N": 1}, "normal force of body and sleeve"),
        ({"tooth_force_N": 30}, "tooth force of crank gear and rack"),
        ({"limits.length_mm": 41}, "length of the linkage"),
        ({"rack_least_mm": 50}, "radius of the rack"),
        ({"teeth_least": 17}, "teeth of the crank gear"),
        ({"sleeve.friction": 20}, "largest axial angle at which the sleeve slides"),
        ({"spring_preload_N": 70}, "sleeve slides along the taper"),
    ],
)
def test_violated_design_conditions_are_named(changes: dict[str, float], worst: str) -> None:
    result = sizes(**changes)
    assert not result.feasible
    assert worst in result.violated
    assert result.violated[0] in build_refusal(result).message


def test_exhausted_length_limit_binds() -> None:
    used = next(c for c in sizes().conditions if c.source == "limits.length_mm")
    limit = 48 - used.margin
    assert "length of the linkage" in sizes(**{"limits.length_mm": limit}).binds


def test_no_hexagon_at_all() -> None:
    with pytest.raises(ComputationError, match="body must be shorter or the travel longer"):
        sizes(**{"sleeve.length_mm": 100, "wanted_travel_mm": 2})


@cache
def optimum() -> FastestSwitching:
    return optimise_clutch(CLUTCH)


def optimal_design() -> np.ndarray:
    """The optimum in SI."""
    units = {"deg": np.pi / 180, "mm": 1e-3}
    design = optimum().design.table()
    return np.array([design[key] * units.get(key.rpartition("_")[2], 1) for key in VARIABLES])


def test_optimum_satisfies_limits_and_is_certified() -> None:
    proof = optimum().certificate
    assert proof.kkt_residual < 1e-6
    assert proof.agreeing_starts == proof.starts == 8
    peaks = find_peaks(CLUTCH, optimal_design())
    assert min(margin for margin, _ in peaks) > -1e-6
    problem = build_switching(CLUTCH, sorted({place for _, place in peaks}))
    u = problem.box.point(optimal_design())
    assert find_worst(problem, u)[0] > -1e-6
    assert optimum().travel_time_s < optimum().start_travel_time_s
    for i in range(len(u)):
        moved = u.copy()
        moved[i] += 0.02 if u[i] < 0.5 else -0.02
        assert kkt_residual(problem, moved) > 1e-3


def test_another_solver_does_not_beat_it() -> None:
    problem = build_switching(CLUTCH, np.linspace(0, 1, 33))
    constraints = problem.constraints
    assert constraints is not None
    random = np.random.default_rng(4)
    solved = 0
    for _ in range(3):
        solution = minimize(
            lambda u: problem.evaluate(u).objective / optimum().travel_time_s,
            random.random(5),
            bounds=[(0, 1)] * 5,
            method="SLSQP",
            constraints=[{"type": "ineq", "fun": lambda u: constraints.values(problem.design(u))}],
            options={"maxiter": 300, "ftol": 1e-12},
        )
        if solution.success and find_worst(problem, solution.x)[0] > -1e-8:
            assert solution.fun > 1 - 1e-3
            solved += 1
    assert solved


def test_relaxing_active_limits_saves_time() -> None:
    """A multiplier is the time that a share of its limit is worth."""
    certificate = optimum().certificate
    multipliers = {row.name: row.multiplier for row in certificate.active_constraints}
    assert multipliers.keys() == {
        "normal force of body and sleeve",
        "teeth of the crank gear",
        "tooth force of crank gear and rack",
    }
    share, key = 1e-4, "limits.tooth_force_N"
    freed = optimise_clutch(load_clutch("shi2021", {key: CLUTCH.si(key) * (1 + share)}))
    gained = (optimum().travel_time_s - freed.travel_time_s) / share
    assert gained == pytest.approx(multipliers["tooth force of crank gear and rack"], rel=0.02)


def test_the_time_goes_with_the_speed_of_the_links() -> None:
    faster = optimise_clutch(load_clutch("shi2021", {"lift_rad_s": 1.8}), starts=2)
    assert faster.travel_time_s == pytest.approx(optimum().travel_time_s / 2, rel=1e-6)


def test_bounds_without_closed_linkage_are_refused() -> None:
    message = r"search.rod_bounds_mm = \[40.0, 60.0\]: it must lie between"
    with pytest.raises(InputError, match=message):
        optimise_clutch(load_clutch("shi2021", {"rod_bounds_mm[1]": 60}))


def test_stopped_search_hands_over_its_best(monkeypatch: pytest.MonkeyPatch) -> None:
    search = sizing.search_from_points

    def stop(problem: Any, starts: Any, iterations: Any) -> Any:
        search(problem, starts[:1], iterations)
        raise KeyboardInterrupt

    monkeypatch.setattr(sizing, "search_from_points", stop)
    with pytest.raises(Interrupted) as caught:
        optimise_clutch(CLUTCH, starts=2)
    assert caught.value.partial is not None
    assert caught.value.partial["design"].keys() == VARIABLES.keys()
    lower, upper = CLUTCH.table()["search"]["crank_bounds_mm"]
    assert lower <= caught.value.partial["design"]["crank_mm"] <= upper


def test_infeasible_search_hands_over_the_closest() -> None:
    with pytest.raises(ComputationError, match="from 2 starts") as caught:
        optimise_clutch(load_clutch("shi2021", {"teeth_least": 40}), starts=2)
    assert caught.value.partial is not None
    assert not caught.value.partial["met"]
