"""Sizes of a clutch for a shaft, a space and a travel with the margin of every inequality, and its
fastest switching.

The fastest switching minimises the travel time with exact derivatives, by IPOPT, from several
starts, and certifies the optimum. The links rise at a constant rate, so the time is the lift of the
link over that rate; the sleeve makes the least travel that its axial angle allows. Forces and rod
angle satisfy their limits at stations along the way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.solvers.constraints import DesignBox, NamedConstraint
from planter.engine.solvers.expressions import (
    SmoothObjective,
    SymbolicConstraints,
    SymbolicFunction,
)
from planter.engine.solvers.local_search import LocalMinimum, search_from_points
from planter.engine.solvers.problem import Problem
from planter.engine.solvers.result import OptimalityCertificate, certify_candidates
from planter.errors import ComputationError, InputError, Interrupted
from planter.files import units
from planter.kernels import Array
from planter.numerics import extrema
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.model import (
    CrankLinkage,
    build_condition,
    collect_values,
    evaluate_conditions,
    find_linkages,
    load_model,
    pack_crank,
    steepest_rod_angle,
)
from planter.papers.clutch.results import (
    ClutchBindingLimit,
    FastestSwitching,
    InequalityResult,
    Rods,
    Sizes,
    Sizing,
    SwitchingCertificate,
    SwitchingDesign,
)

BINDS = 1e-9
"""Share of its value below which a margin counts as none."""


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
    linkage, rotation = _linkage(clutch, values)
    rows = [
        *evaluate_conditions(values),
        *_space(clutch, values),
        *_limits(clutch, values, linkage),
    ]
    violated = sorted((c for c in rows if not c.holds), key=lambda c: c.share)
    return Sizing(
        clutch=clutch.name,
        feasible=not violated,
        binds=[c.condition for c in rows if abs(c.share) <= BINDS],
        violated=[c.condition for c in violated],
        tightest=min((c for c in rows if abs(c.share) > BINDS), key=lambda c: c.share).condition,
        sizes=_to_sizes(values),
        linkage=Rods(
            crank_mm=linkage.crank * 1e3,
            rod_mm=linkage.rod * 1e3,
            distance_mm=linkage.distance * 1e3,
            crank_rotation_deg=math.degrees(rotation),
            rod_angle_deg=math.degrees(steepest_rod_angle(linkage, values["c"])),
        ),
        conditions=rows,
        assumes=list(ASSUMES[1:]),
    )


def compute_sizes(clutch: ClutchFile) -> dict[str, float]:
    """Return the clutch's numbers in SI with fillet, teeth, hexagon, taper and body at their
    smallest sizes.
    """
    values = collect_values(clutch) | {"c": clutch.si("wanted_travel_mm")}
    wall = clutch.si("wall_mm")
    values["r"] = load_model().at("fillet", flats=values["flats"])["r"]
    teeth = load_model().at("teeth", flats=values["flats"], r=values["r"])
    values |= {"b1": teeth["b1"], "b2": teeth["b2"], "xi": teeth["xi"]}
    values["a"] = load_model().at("body", b2=values["b2"], wall=wall, d=values["d"], c=values["c"])[
        "a"
    ]
    if values["a"] <= 0:
        raise ComputationError(
            f"no hexagon is large enough: over a body of {values['d'] * 1e3:.4g} mm a taper for a "
            f"travel of {values['c'] * 1e3:.4g} mm takes off more than there is; the body must be "
            "shorter or the travel longer"
        )
    angle = load_model().at("angle", a=values["a"], c=values["c"])
    values |= {"b": angle["b"], "phi": angle["phi"], "R2": values["b2"] + wall}
    values["R1"] = load_model().at("taper", R2=values["R2"], d=values["d"], phi=values["phi"])["R1"]
    values["R"] = load_model().at("polygon", a=values["a"])["R"]
    return values


def _linkage(clutch: ClutchFile, values: dict[str, float]) -> tuple[CrankLinkage, float]:
    """Return the linkage for the travel, and the crank rotation [rad] from the lift of the link."""
    lift = clutch.si("lift_limit_deg")
    rotation = load_model().at("gears", alpha=lift, k=values["k"], gamma=values["gamma"])[
        "theta_AR"
    ]
    return find_linkages(values["l_AB"], values["l_AC"], values["c"], rotation)[0], rotation


def _space(clutch: ClutchFile, values: dict[str, float]) -> Iterator[InequalityResult]:
    """Yield the inequalities of the space that the file provides."""
    for subject, key, used in (
        ("corners of the hexagonal hole within the space", "space_radius_mm", values["a"]),
        ("outline of the body within the space", "space_radius_mm", values["R1"]),
        (
            "body and way of the sleeve within the space",
            "space_length_mm",
            values["d"] + values["c"],
        ),
    ):
        available = clutch.si(key)
        yield build_condition(subject, f"wanted.{key}", "m", available - used, available)


def _limits(
    clutch: ClutchFile, values: dict[str, float], linkage: CrankLinkage
) -> Iterator[InequalityResult]:
    """Yield the inequalities of forces, gears and rod by the limits of the file."""
    sleeve = {name: values[name] for name in ("a", "phi", "mu", "F1", "F2")}
    ends = (0.0, values["c"])
    tooth = max(
        load_model().at("push", shift=s, crank=linkage.packed, F1=values["F1"], r_A=values["r_A"])[
            "tooth_force"
        ]
        for s in ends
    )
    limits = clutch.limits
    for subject, key, unit, limit, used in (
        (
            "normal force of body and sleeve",
            "normal_force_N",
            "N",
            limits.normal_force_N,
            load_model().at("travel", **sleeve)["F_N"],
        ),
        ("tooth force of crank gear and rack", "tooth_force_N", "N", limits.tooth_force_N, tooth),
        (
            "angle of the rod",
            "rod_angle_deg",
            "rad",
            clutch.si("limits.rod_angle_deg"),
            steepest_rod_angle(linkage, values["c"]),
        ),
        (
            "length of the linkage",
            "length_mm",
            "m",
            clutch.si("limits.length_mm"),
            linkage.distance + values["c"],
        ),
    ):
        yield build_condition(subject, f"limits.{key}", unit, limit - used, limit)
    min_radius = clutch.si("rack_least_mm")
    yield build_condition(
        "radius of the rack", "limits.rack_least_mm", "m", values["r_D"] - min_radius, min_radius
    )
    teeth = 2 * values["r_A"] / values["m"]
    yield build_condition(
        "teeth of the crank gear", "limits.teeth_least", "1", teeth - limits.teeth_least, teeth
    )


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


def _to_sizes(values: dict[str, float]) -> Sizes:
    return Sizes(**{key: values[name] / units.unit_factor(key) for key, name in SIZES.items()})


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
"""Largest number of times that a peak between stations becomes a station."""


def optimise_clutch(clutch: ClutchFile, seed: int = 0, starts: int = STARTS) -> FastestSwitching:
    """Return axial angle, gear ratio and linkage of the smallest travel time under the limits of
    the file.

    Raises InputError for bounds with linkages that do not close, ComputationError if no start ends
    at a point that satisfies every limit.
    """
    switching = SwitchingProblem(clutch)
    problem, file_design = switching.problem, switching.box.design
    violated = [
        switching.names[i] for i in np.flatnonzero(switching.margins.values(file_design) < -BROKEN)
    ]
    first = [problem.start, *np.random.default_rng(seed).random((starts - 1, len(VARIABLES)))]
    for _ in range(ROUNDS):
        try:
            minima = search_from_points(problem, first, MOST_ITERATIONS)
        except KeyboardInterrupt:
            raise Interrupted(_build_unfinished(clutch, problem)) from None
        good = [minimum for minimum in minima if minimum.settled]
        if not good:
            failure = ComputationError(_describe_failure(switching, problem, minima, starts, seed))
            failure.partial = _build_unfinished(clutch, problem)
            raise failure
        best = min(good, key=lambda minimum: minimum.objective)
        x = problem.design(best.u)
        margins = switching.worst_along(x)
        peaks = {limit: share for limit, (margin, share) in margins.items() if margin < -PEAK}
        if not peaks:
            break
        stations = {
            w: sorted({*at, *([peaks[w]] if w in peaks else [])})
            for w, at in switching.stations.items()
        }
        switching, first = SwitchingProblem(clutch, stations), [minimum.u for minimum in good]
        problem = switching.problem
    return FastestSwitching(
        clutch=clutch.name,
        travel_time_s=best.objective,
        start_travel_time_s=problem.reference.objective,
        start_violates=violated,
        design=SwitchingDesign(**_to_display_units(x)),
        start_design=SwitchingDesign(**_to_display_units(file_design)),
        stations={limit: list(at) for limit, at in switching.stations.items()},
        least_margin_along={limit: margin for limit, (margin, _) in margins.items()},
        bounds=_bounds(switching),
        certificate=_to_certificate(
            certify_candidates(problem, best.u, good), problem.scale, starts
        ),
        assumes=list(ASSUMES),
        seed=seed,
    )


def _to_certificate(
    proof: OptimalityCertificate, scale: float, starts: int
) -> SwitchingCertificate:
    """The certificate; a multiplier is the share of the file's own time that a share of the limit
    is worth.
    """
    active = [(bound.name, bound.multiplier) for bound in proof.active_constraints]
    active += [
        (f"{bound.name} at its {bound.side} bound", bound.multiplier)
        for bound in proof.active_bounds
    ]
    return SwitchingCertificate(
        kkt_residual=proof.kkt_residual,
        active=[ClutchBindingLimit(name, multiplier / scale) for name, multiplier in active],
        agreeing_starts=proof.agreeing_starts,
        spread=proof.spread / scale,
        starts=starts,
    )


def _to_display_units(x: Array) -> dict[str, float]:
    return {
        key: float(value) / units.unit_factor(key) for key, value in zip(VARIABLES, x, strict=True)
    }


def _bounds(switching: SwitchingProblem) -> dict[str, tuple[float, float]]:
    lower, upper = _to_display_units(switching.box.lower), _to_display_units(switching.box.upper)
    return {key: (lower[key], upper[key]) for key in VARIABLES}


def _describe_failure(
    switching: SwitchingProblem,
    problem: Problem,
    minima: list[LocalMinimum],
    starts: int,
    seed: int,
) -> str:
    """Return the message that says what was tried, and which limit the best of the points violates
    most.
    """
    margins = [switching.margins.values(problem.design(minimum.u)) for minimum in minima]
    best = max(margins, key=lambda m: float(m.min()))
    attempts = f"{starts} start{'s' if starts > 1 else ''} with seed {seed}"
    return (
        f"no design that satisfies all limits was found within the bounds, from {attempts}: "
        f"{switching.names[int(best.argmin())]} fails by {-100 * best.min():.3g} % of its limit "
        f"at the closest design"
    )


def _build_unfinished(clutch: ClutchFile, problem: Problem) -> dict[str, Any] | None:
    """Return the best point of a search, or the closest to satisfying the limits, None if it has
    met none.
    """
    best, closest = problem.best, problem.closest
    u = best.u if best is not None else None if closest is None else closest.u
    if u is None:
        return None
    objective = None if best is None else best.objective
    design = _to_display_units(problem.design(u))
    return {
        "clutch": clutch.name,
        "design": design,
        "travel_time_s": objective,
        "met": best is not None,
    }


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
STATIONS = (0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Places along the way, as shares of it, at which limits are imposed first."""
ALONG = {"tooth force": "tooth_force", "rod angle": "rod_angle"}
"""What is limited all along the way: its name, and its name in the derivation."""
_DENSE = np.linspace(0, 1, 401)


class SwitchingProblem:
    """The least travel time of a clutch as a problem over its `VARIABLES`, x (5,) in SI.

    `stations` are the places along the way, as shares of it, at which each limit of `ALONG` is
    imposed.

    Raises InputError if the bounds of the file contain linkages that do not close.
    """

    def __init__(
        self, clutch: ClutchFile, stations: Mapping[str, Sequence[float]] | None = None
    ) -> None:
        self.clutch, self.values = clutch, collect_values(clutch)
        self.stations = dict(stations) if stations else dict.fromkeys(ALONG, STATIONS)
        self._limits = {
            "tooth force": clutch.limits.tooth_force_N,
            "rod angle": clutch.si("limits.rod_angle_deg"),
        }
        bounds = np.array(
            [[clutch.si(f"search.{key}[{i}]") for i in (0, 1)] for _, key in VARIABLES.values()]
        )
        lower, upper = bounds.T
        design = np.array([self.values[name] for name, _ in VARIABLES.values()])
        self.box = DesignBox.shares(tuple(VARIABLES), lower, upper, np.clip(design, lower, upper))
        self.values |= self.design(lower)
        self._check_closure()

    def design(self, x: Array) -> dict[str, float]:
        """The variables in SI under their names in the derivation."""
        return {name: float(value) for (name, _), value in zip(VARIABLES.values(), x, strict=True)}

    @cached_property
    def names(self) -> list[str]:
        """Names of the limits, in their order."""
        stations = [
            f"{limit} at {100 * share:.4g} % of the way"
            for limit in ALONG
            for share in self.stations[limit]
        ]
        return [
            "normal force",
            "length",
            "rack radius",
            "teeth",
            "outline in the space",
            "body and way in the space",
            "lift of the link",
            *stations,
        ]

    @cached_property
    def problem(self) -> Problem:
        """The travel time [s], with the margins as shares of their limits, which must be
        positive.
        """
        return Problem(
            SmoothObjective(SymbolicFunction(self._x, self._expressions[0]), len(VARIABLES)),
            self.box,
            self.margins,
        )

    @cached_property
    def margins(self) -> SymbolicConstraints:
        """The limits as constraints, one component each: its margin as a share of it."""
        count = len(self.names)
        bounds = np.zeros(count), np.full(count, np.inf)
        return SymbolicConstraints(
            self._x,
            self._expressions[1],
            bounds,
            [NamedConstraint(n) for n in self.names],
            np.arange(count),
        )

    @cached_property
    def _x(self) -> ca.SX:
        return ca.SX.sym("x", len(VARIABLES))

    @cached_property
    def _expressions(self) -> tuple[ca.SX, ca.SX]:
        """The travel time [s], and the margins as shares of their limits."""
        return self._time_and_margins(*ca.vertsplit(self._x))

    def _time_and_margins(self, phi: ca.SX, k: ca.SX, *lengths: ca.SX) -> tuple[ca.SX, ca.SX]:
        v, si, limits = self.values, self.clutch.si, self.clutch.limits
        packed, span = ca.vertcat(*lengths), v["r_A"] + v["r_D"]
        forces = _entries("travel", v["a"], phi, v["mu"], v["F1"], v["F2"])
        c = forces["c_min"]
        rotation = _entries("limit", packed, c, v["r_A"], v["m"])["theta_Amax"]
        drive = _entries("drive", k, span, v["gamma"], rotation)
        way = [
            1
            - _entries("push", c * share, packed, v["F1"], drive["r_A"])[name] / self._limits[limit]
            for limit, name in ALONG.items()
            for share in self.stations[limit]
        ]
        outline = _entries("taper", v["R2"], v["d"], phi)["R1"]
        rack, lift = si("rack_least_mm"), si("lift_limit_deg")
        margins = [
            1 - forces["F_N"] / limits.normal_force_N,
            1 - (lengths[2] + c) / si("limits.length_mm"),
            drive["r_D"] / rack - 1,
            2 * drive["r_A"] / v["m"] / limits.teeth_least - 1,
            1 - outline / si("space_radius_mm"),
            1 - (v["d"] + c) / si("space_length_mm"),
            1 - drive["alpha_max"] / lift,
            *way,
        ]
        return drive["lift"] / self.clutch.search.lift_rad_s, ca.vertcat(*margins)

    def worst_along(self, x: Array) -> dict[str, tuple[float, float]]:
        """Return smallest margin and position, as shares, of each limit of `ALONG` over the way at
        a design x.
        """
        design = self.values | self.design(x)
        c = load_model().at(
            "travel", **{key: design[key] for key in ("a", "phi", "mu", "F1", "F2")}
        )["c_min"]
        span = self.values["r_A"] + self.values["r_D"]
        r_A = load_model().at(
            "drive", k=design["k"], span=span, gamma=design["gamma"], theta_Amax=0.0
        )["r_A"]
        margins = {}
        for limit, name in ALONG.items():

            def margin(share: Array, limit: str = limit, name: str = name) -> Array:
                at = load_model()(
                    "push", shift=c * share, crank=pack_crank(design), F1=design["F1"], r_A=r_A
                )
                return 1 - at[name] / self._limits[limit]

            minimum = extrema.find_minimum(margin, _DENSE)
            margins[limit] = minimum.value, minimum.place
        return margins

    def _check_closure(self) -> None:
        """Every linkage in the box closes over the longest travel in it."""
        travel_inputs = {key: self.values[key] for key in ("a", "mu", "F1", "F2")}
        longest = load_model().at("travel", phi=self.box.lower[0], **travel_inputs)["c_min"]
        (shortest, min_rod, min_distance), (_, max_rod, max_distance) = (
            self.box.lower[2:],
            self.box.upper[2:],
        )
        low, high = max_distance + longest - shortest, shortest + min_distance
        if not (low < min_rod and max_rod < high):
            raise self.clutch.input_error(
                "search.rod_bounds_mm",
                f"it must lie between {low * 1e3:.6g} and {high * 1e3:.6g}, where crank and rod "
                f"always meet",
                InputError,
            )


def _entries(stage: str, *arguments: ca.SX | float) -> dict[str, ca.SX]:
    """The outputs of a stage of the exact model, by name."""
    packed = load_model().function(stage)(*arguments)
    return dict(zip(load_model().outputs(stage), ca.vertsplit(packed), strict=True))
