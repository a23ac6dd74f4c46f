"""Sizes of a clutch for a shaft, a space and a travel with the margin of every inequality, and its
fastest switching.

The fastest switching minimises the travel time with exact derivatives, by IPOPT, from several
starts, and certifies the optimum. The links rise at a constant rate, so the time is the lift of the
link over that rate; the sleeve makes the least travel that its axial angle allows. Forces and rod
angle satisfy their limits at stations along the way, among which their peaks are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.solvers.constraints import DesignBox, NamedConstraint
from planter.engine.solvers.expressions import (
    SmoothObjective,
    SymbolicConstraints,
    SymbolicFunction,
)
from planter.engine.solvers.local_search import search_from_points
from planter.engine.solvers.problem import Problem
from planter.engine.solvers.result import certify_candidates
from planter.errors import ComputationError, InputError, Interrupted
from planter.files import units
from planter.kernels import Array
from planter.numerics import extrema
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.model import (
    build_condition,
    collect_values,
    drive_link,
    evaluate_conditions,
    find_linkages,
    least_travel,
    load_model,
    steepest_rod_angle,
)
from planter.papers.clutch.results import (
    FastestSwitching,
    Rods,
    Sizes,
    Sizing,
    SwitchingDesign,
)

BINDS = 1e-9
"""Share of its value below which a margin counts as none."""
ALONG = {
    "tooth_force": ("tooth force of crank gear and rack", "limits.tooth_force_N", "N"),
    "rod_angle": ("angle of the rod", "limits.rod_angle_deg", "rad"),
}
"""What is limited all along the way, by its name in the derivation: meaning, limit and unit."""


def list_limits(values: Mapping[str, Any]) -> Iterator[tuple[str, str, str, Any, int]]:
    """Yield what the file limits, from values by their names in the derivation: meaning, path of
    the limit, unit, value, and 1 for a largest or -1 for a least value.
    """
    length, force = values["d"] + values["c"], values["F_N"]
    teeth = 2 * values["r_A"] / values["m"]
    yield "outline of the body within the space", "wanted.space_radius_mm", "m", values["R1"], 1
    yield "body and way of the sleeve within the space", "wanted.space_length_mm", "m", length, 1
    yield "normal force of body and sleeve", "limits.normal_force_N", "N", force, 1
    yield "length of the linkage", "limits.length_mm", "m", values["l_AC"] + values["c"], 1
    yield "radius of the rack", "limits.rack_least_mm", "m", values["r_D"], -1
    yield "teeth of the crank gear", "limits.teeth_least", "1", teeth, -1


def size_clutch(clutch: ClutchFile) -> Sizing:
    """Return the smallest clutch for the file's shaft, travel and space, with the linkage that
    moves its sleeve.

    Fillet, teeth and hexagon get their smallest sizes, the taper the angle that the travel
    requires; lengths of crank, distance, gears and body stay as in the file. `feasible` says
    whether every inequality holds, `binds` which ones hold with equality and `violated` which do
    not, the worst first.

    Raises ComputationError if no hexagon or no rod exists.
    """
    values = compute_sizes(clutch)
    lift = clutch.si("lift_limit_deg")
    rotation = load_model().pick("gears", {**values, "alpha": lift})["theta_AR"]
    linkage = find_linkages(values["l_AB"], values["l_AC"], values["c"], rotation)[0]
    ends = np.array([0.0, values["c"]])
    push = load_model()(
        "push", shift=ends, crank=linkage.packed, F1=values["F1"], r_A=values["r_A"]
    )
    steepest = steepest_rod_angle(linkage, values["c"])
    largest = {"tooth_force": float(push["tooth_force"].max()), "rod_angle": steepest}
    corners = "corners of the hexagonal hole within the space"
    limits = [
        (corners, "wanted.space_radius_mm", "m", values["a"], 1),
        *list_limits(values),
        *((*ALONG[name], value, 1) for name, value in largest.items()),
    ]
    rows = list(evaluate_conditions(values))
    for meaning, path, unit, value, sign in limits:
        limit = clutch.si(path)
        rows.append(build_condition(meaning, path, unit, sign * (limit - value), limit))
    violated = sorted((row for row in rows if not row.holds), key=lambda row: row.share)
    loose = (row for row in rows if abs(row.share) > BINDS)
    return Sizing(
        clutch=clutch.name,
        feasible=not violated,
        binds=[row.condition for row in rows if abs(row.share) <= BINDS],
        violated=[row.condition for row in violated],
        tightest=min(loose, key=lambda row: row.share).condition,
        sizes=Sizes(**{k: values[name] / units.unit_factor(k) for k, name in SIZES.items()}),
        linkage=Rods(
            crank_mm=linkage.crank * 1e3,
            rod_mm=linkage.rod * 1e3,
            distance_mm=linkage.distance * 1e3,
            crank_rotation_deg=math.degrees(rotation),
            rod_angle_deg=math.degrees(steepest),
        ),
        conditions=rows,
        assumes=list(ASSUMES[1:]),
    )


def compute_sizes(clutch: ClutchFile) -> dict[str, float]:
    """Return the clutch's numbers in SI with fillet, teeth, hexagon, taper and body at their
    smallest sizes.
    """
    model = load_model()
    values = collect_values(clutch) | {"c": clutch.si("wanted_travel_mm")}
    travel, length, wall = values["c"], values["d"], clutch.si("wall_mm")
    values |= model.pick("fillet", values)
    values |= model.pick("teeth", values)
    values |= model.pick("body", {**values, "wall": wall})
    if values["a"] <= 0:
        raise ComputationError(
            f"no hexagon is large enough: over a body of {length * 1e3:.4g} mm a taper for a "
            f"travel of {travel * 1e3:.4g} mm takes off more than there is; the body must be "
            "shorter or the travel longer"
        )
    values |= model.pick("angle", values)
    values["R2"] = values["b2"] + wall
    values |= model.pick("taper", values)
    values["R"] = model.at("polygon", a=values["a"])["R"]
    return values | {"F_N": model.pick("travel", values)["F_N"]}


SIZES = {
    "fillet_mm": "r",
    "tip_mm": "b1",
    "root_mm": "b2",
    "hexagon_side_mm": "a",
    "width_mm": "R",
    "outline_mm": "b",
    "left_radius_mm": "R1",
    "right_radius_mm": "R2",
    "length_mm": "d",
    "travel_mm": "c",
    "face_angle_deg": "xi",
    "axial_angle_deg": "phi",
}
"""Sizes by key, with their names in the derivation."""


def build_refusal(sizing: Sizing) -> ComputationError:
    """Return the error of an infeasible design: the worst inequality and its margin."""
    worst = next(c for c in sizing.conditions if c.condition == sizing.violated[0])
    more = len(sizing.violated) - 1
    tail = f" (and {more} more)" if more else ""
    by = f"{-worst.margin:.4g} {worst.unit}"
    return ComputationError(
        f"no clutch fits: {worst.condition} fails by {by} ({worst.source}){tail}"
    )


STARTS = 8
MOST_ITERATIONS = 100
BROKEN = 1e-8
"""Share of a limit by which the file's own clutch may pass it."""
PEAK = 1e-6
"""Share of a limit by which a peak between stations may pass it."""
ROUNDS = 8
"""Largest number of times that peaks between stations become stations."""
VARIABLES = {
    "axial_angle_deg": ("phi", "axial_angle_bounds_deg"),
    "ratio": ("k", "ratio_bounds"),
    "crank_mm": ("l_AB", "crank_bounds_mm"),
    "rod_mm": ("l_BC", "rod_bounds_mm"),
    "distance_mm": ("l_AC", "distance_bounds_mm"),
}
"""What may be chosen: key, name in the derivation, bounds in the file."""
ASSUMES = (
    "links rise at a constant rate",
    "the sleeve is pushed with the engaging force all along its way",
    "no friction in crank, rod and gears",
)
STATIONS = tuple(np.linspace(0, 1, 9).tolist())
"""Places along the way, as shares of it, at which limits are imposed first."""
_DENSE = np.linspace(0, 1, 401)


def optimise_clutch(clutch: ClutchFile, seed: int = 0, starts: int = STARTS) -> FastestSwitching:
    """Return axial angle, gear ratio and linkage of the smallest travel time under the limits of
    the file.

    Raises InputError for bounds with linkages that do not close, ComputationError if no start ends
    at a point that satisfies every limit.
    """
    stations: Sequence[float] = STATIONS
    random = np.random.default_rng(seed).random((starts - 1, len(VARIABLES)))
    first: list[Array] = []
    for _ in range(ROUNDS):
        problem = build_switching(clutch, stations)
        try:
            minima = search_from_points(problem, first or [problem.start, *random], MOST_ITERATIONS)
        except KeyboardInterrupt:
            raise Interrupted(_build_unfinished(clutch, problem)) from None
        good = [minimum for minimum in minima if minimum.settled]
        if not good:
            attempts = f"{starts} start{'s' if starts > 1 else ''} with seed {seed}"
            closest = max(find_worst(problem, minimum.u) for minimum in minima)
            failure = ComputationError(
                f"no design that satisfies all limits was found within the bounds, from "
                f"{attempts}: {closest[1]} fails by {-100 * closest[0]:.3g} % of its limit at the "
                f"closest design"
            )
            failure.partial = _build_unfinished(clutch, problem)
            raise failure
        best = min(good, key=lambda minimum: minimum.objective)
        peaks = find_peaks(clutch, problem.design(best.u))
        passed = [place for margin, place in peaks if margin < -PEAK]
        if not passed:
            break
        stations, first = sorted({*stations, *passed}), [minimum.u for minimum in good]
    start = problem.box.design
    constraints = problem.constraints
    assert constraints is not None
    broken = constraints.owner[constraints.values(start) < -BROKEN]
    return FastestSwitching(
        clutch=clutch.name,
        travel_time_s=best.objective,
        start_travel_time_s=problem.reference.objective,
        start_violates=[constraints.kinds[k].name for k in np.unique(broken)],
        design=SwitchingDesign(**_to_display_units(problem.design(best.u))),
        start_design=SwitchingDesign(**_to_display_units(start)),
        certificate=certify_candidates(problem, best.u, good),
        assumes=list(ASSUMES),
        seed=seed,
    )


def _to_display_units(x: Array) -> dict[str, float]:
    return {
        key: float(value) / units.unit_factor(key) for key, value in zip(VARIABLES, x, strict=True)
    }


def find_worst(problem: Problem, u: Array) -> tuple[float, str]:
    """Return the smallest margin at a point, as a share of its limit, and what is limited."""
    constraints = problem.constraints
    assert constraints is not None
    margins = constraints.values(problem.design(u))
    worst = int(margins.argmin())
    return float(margins[worst]), constraints.kinds[constraints.owner[worst]].name


def _build_unfinished(clutch: ClutchFile, problem: Problem) -> dict[str, Any] | None:
    """Return the best point of a search, or the closest to satisfying the limits, None if it has
    met none.
    """
    point = problem.best or problem.closest
    if point is None:
        return None
    return {
        "clutch": clutch.name,
        "design": _to_display_units(problem.design(point.u)),
        "travel_time_s": None if problem.best is None else problem.best.objective,
        "met": problem.best is not None,
    }


def build_switching(clutch: ClutchFile, stations: Sequence[float] = STATIONS) -> Problem:
    """Return the least travel time [s] of a clutch as a problem over its `VARIABLES`, x (5,) in SI.

    Margins are shares of their limits; those of `ALONG` are imposed at `stations`, shares of the
    way. Raises InputError if the bounds of the file contain linkages that do not close.
    """
    v: dict[str, Any] = dict(collect_values(clutch))
    bounds = np.array(
        [[clutch.si(f"search.{key}[{i}]") for i in (0, 1)] for _, key in VARIABLES.values()]
    )
    lower, upper = bounds.T
    design = np.array([v[name] for name, _ in VARIABLES.values()])
    box = DesignBox.shares(tuple(VARIABLES), lower, upper, np.clip(design, lower, upper))
    _check_closure(clutch, box)
    model, x = load_model(), ca.SX.sym("x", len(VARIABLES))
    span = v["r_A"] + v["r_D"]
    v |= {name: x[i] for i, (name, _) in enumerate(VARIABLES.values())} | {"span": span}
    v |= model.composed("travel", v)
    v["c"] = v["c_min"]
    v |= model.composed("limit", v)
    v |= model.composed("drive", v)
    v |= model.composed("taper", v)
    limits = [*list_limits(v)]
    limits.append(("lift of the link", "wanted.lift_limit_deg", "rad", v["alpha_max"], 1))
    kinds = [NamedConstraint(meaning) for meaning, *_ in limits]
    rows = [sign * (1 - value / clutch.si(path)) for _, path, _, value, sign in limits]
    owner = list(range(len(rows)))
    for name, (meaning, path, _) in ALONG.items():
        for share in stations:
            push = model.composed("push", {**v, "shift": v["c"] * share})
            rows.append(1 - push[name] / clutch.si(path))
            owner.append(len(kinds))
        kinds.append(NamedConstraint(meaning))
    ends = np.zeros(len(rows)), np.full(len(rows), np.inf)
    time = SymbolicFunction(x, v["lift"] / clutch.search.lift_rad_s)
    constraints = SymbolicConstraints(x, ca.vertcat(*rows), ends, kinds, np.array(owner))
    return Problem(SmoothObjective(time, len(VARIABLES)), box, constraints)


def find_peaks(clutch: ClutchFile, x: Array) -> list[tuple[float, float]]:
    """Return smallest margin and place, as shares, of each limit of `ALONG` over the way at a
    design x.
    """
    values = collect_values(clutch)
    names = (name for name, _ in VARIABLES.values())
    values |= dict(zip(names, x.tolist(), strict=True))
    travel = least_travel(values, values["phi"])
    linkage = [values["l_AB"], values["l_BC"], values["l_AC"]]
    push = {"crank": linkage, "F1": values["F1"], "r_A": drive_link(values, 0.0)["r_A"]}
    peaks = []
    for name, (_, path, _) in ALONG.items():

        def margin(share: Array, name: str = name, limit: float = clutch.si(path)) -> Array:
            return 1 - load_model()("push", shift=travel * share, **push)[name] / limit

        peak = extrema.find_minimum(margin, _DENSE)
        peaks.append((peak.value, peak.place))
    return peaks


def _check_closure(clutch: ClutchFile, box: DesignBox) -> None:
    """Raise InputError unless every linkage in the box closes over the longest travel in it."""
    longest = least_travel(collect_values(clutch), box.lower[0])
    shortest, min_rod, min_distance = box.lower[2:]
    _, max_rod, max_distance = box.upper[2:]
    low, high = max_distance + longest - shortest, shortest + min_distance
    if not (low < min_rod and max_rod < high):
        raise clutch.input_error(
            "search.rod_bounds_mm",
            f"it must lie between {low * 1e3:.6g} and {high * 1e3:.6g}, where crank and rod "
            f"always meet",
            InputError,
        )
