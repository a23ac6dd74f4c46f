"""Travel time of the sleeve and its limits as functions of axial angle, gear ratio and linkage, with exact derivatives.

The links rise at a constant rate, so the time is the lift of the link over that rate; the sleeve makes the least travel
that its axial angle allows. Forces and rod angle are held to their limits at stations along the way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from planter.clutch.file import Clutch
from planter.clutch.model import crank, given, model
from planter.errors import InputError
from planter.kernels import Array
from planter.numerics import extremes
from planter.optimise.box import Box
from planter.optimise.constraints import Named
from planter.optimise.expressions import Expression, Expressions
from planter.optimise.problem import Problem
from planter.optimise.smooth import Smooth

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
"""Places along the way, as shares of it, at which limits are held at first."""
ALONG = {"tooth force": "tooth_force", "rod angle": "rod_angle"}
"""What is limited all along the way: its name, and its name in the derivation."""
_DENSE = np.linspace(0, 1, 401)


class Switching:
    """The least travel time of a clutch as a problem over its `VARIABLES`, x (5,) in SI.

    `stations` are the places along the way, as shares of it, at which each limit of `ALONG` is held.

    Raises InputError where the bounds of the file hold linkages that do not close.
    """

    def __init__(self, clutch: Clutch, stations: Mapping[str, Sequence[float]] | None = None) -> None:
        self.clutch, self.values = clutch, given(clutch)
        self.stations = dict(stations) if stations else dict.fromkeys(ALONG, STATIONS)
        self._limits = {"tooth force": clutch.limits.tooth_force_N, "rod angle": clutch.si("limits.rod_angle_deg")}
        bounds = np.array([[clutch.si(f"search.{key}[{i}]") for i in (0, 1)] for _, key in VARIABLES.values()])
        lower, upper = bounds.T
        own = np.array([self.values[name] for name, _ in VARIABLES.values()])
        self.box = Box.shares(tuple(VARIABLES), lower, upper, np.clip(own, lower, upper))
        self.values |= self.design(lower)
        self._check_closure()

    def design(self, x: Array) -> dict[str, float]:
        """The variables in SI under their names in the derivation."""
        return {name: float(value) for (name, _), value in zip(VARIABLES.values(), x, strict=True)}

    @cached_property
    def names(self) -> list[str]:
        """Names of the limits, in their order."""
        along = [f"{what} at {100 * share:.4g} % of the way" for what in ALONG for share in self.stations[what]]
        return ["normal force", "length", "rack radius", "teeth", "outline in the space", "body and way in the space",
                "lift of the link", *along]  # fmt: skip

    @cached_property
    def problem(self) -> Problem:
        """The travel time [s], with the margins as shares of their limits to be kept above 0."""
        return Problem(Smooth(Expression(self._x, self._expressions[0]), len(VARIABLES)), self.box, self.margins)

    @cached_property
    def margins(self) -> Expressions:
        """The limits as constraints, each with a row of its own: its margin as a share of it."""
        count = len(self.names)
        bounds = np.zeros(count), np.full(count, np.inf)
        return Expressions(self._x, self._expressions[1], bounds, [Named(n) for n in self.names], np.arange(count))

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
        at = _entries("travel", v["a"], phi, v["mu"], v["F1"], v["F2"])
        c = at["c_min"]
        rotation = _entries("limit", packed, c, v["r_A"], v["m"])["theta_Amax"]
        drive = _entries("drive", k, span, v["gamma"], rotation)
        way = [
            1 - _entries("push", c * share, packed, v["F1"], drive["r_A"])[name] / self._limits[what]
            for what, name in ALONG.items()
            for share in self.stations[what]
        ]
        outline = _entries("taper", v["R2"], v["d"], phi)["R1"]
        rack, lift = si("rack_least_mm"), si("lift_limit_deg")
        margins = [
            1 - at["F_N"] / limits.normal_force_N,
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
        """For each limit of `ALONG` its least margin over the whole way, as a share, and where: at a design x."""
        design = self.values | self.design(x)
        c = model().at("travel", **{key: design[key] for key in ("a", "phi", "mu", "F1", "F2")})["c_min"]
        r_A = model().at("drive", k=design["k"], span=self.values["r_A"] + self.values["r_D"], gamma=design["gamma"],
                         theta_Amax=0.0)["r_A"]  # fmt: skip
        found = {}
        for what, name in ALONG.items():

            def margin(share: Array, what: str = what, name: str = name) -> Array:
                at = model()("push", shift=c * share, crank=crank(design), F1=design["F1"], r_A=r_A)
                return 1 - at[name] / self._limits[what]

            least = extremes.least(margin, _DENSE)
            found[what] = least.value, least.place
        return found

    def _check_closure(self) -> None:
        """Every linkage in the box closes over the longest travel in it."""
        at = {key: self.values[key] for key in ("a", "mu", "F1", "F2")}
        longest = model().at("travel", phi=self.box.lower[0], **at)["c_min"]
        (shortest, least, near), (_, most, far) = self.box.lower[2:], self.box.upper[2:]
        low, high = far + longest - shortest, shortest + near
        if not (low < least and most < high):
            raise self.clutch.input_error(
                "search.rod_bounds_mm",
                f"it must lie between {low * 1e3:.6g} and {high * 1e3:.6g}, where crank and rod always meet",
                InputError,
            )


def _entries(stage: str, *arguments: ca.SX | float) -> dict[str, ca.SX]:
    """The outputs of a stage of the exact model, by name."""
    packed = model().function(stage)(*arguments)
    return dict(zip(model().outputs(stage), ca.vertsplit(packed), strict=True))
