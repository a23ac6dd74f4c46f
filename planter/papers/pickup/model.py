"""The gear train of a pick-up: a law of the arm, the bars and the carrier, whatever the law was
made from.

t is the carrier angle from the farthest tip; the carrier turns counter-clockwise at constant speed.
SI and radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.gears.geometry.flanks import TEETH
from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics import extrema, piecewise
from planter.numerics.arrays import TURN
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.inverse import Inversion, invert_path
from planter.papers.pickup.law import MODEL, ArmLaw, CosineLaw, Dwell, toothed_range

PANELS, NODES = 96, 8
"""Panels over a range of angles for integrals, and nodes in each."""
_STEP = TURN / 2880
BESIDE = np.radians(30)
"""How far from the dwell what cannot be gears is left to other means than teeth."""


@dataclass(frozen=True)
class PickupGeometry:
    """Constant geometry of the mechanism: bars, carrier triangle, helical pair [m, rad, -]."""

    L1: float
    L2: float
    gamma: float
    a1: float
    a2: float
    beta1: float
    helix: float
    helical_contact_ratio: float

    @property
    def triangle(self) -> Array:
        return np.array([self.L1, self.L2, self.gamma, self.a1, self.a2, self.beta1])


@dataclass(frozen=True)
class PickupTrain:
    """A pick-up that runs: `law` drives the arm, `omega` [rad/s] the carrier; `found` is what a
    path gave, if one did.

    `teeth` are module [m], both addendum coefficients and the angle of the line of action [rad].
    """

    law: ArmLaw
    geometry: PickupGeometry
    phi5_far: float
    omega: float
    teeth: Array
    inversion: Inversion | None = None

    def is_locked(self, t: Array) -> Array:
        """Whether the arm dwells at carrier angles (n,)."""
        dwell = self.law.dwell
        return np.zeros(np.shape(t), dtype=bool) if dwell is None else dwell.holds(np.asarray(t))

    def slope(self, t: Array) -> Array:
        """g = dphi1/dphi5 (n,), zero in the dwell."""
        return np.where(self.is_locked(t), 0.0, self.law.slopes(t)[0])

    def motion(self, t: Array) -> dict[str, Array]:
        """Places of the axes and the tip [m], its velocity [m/s], its distance L3, the arm's
        direction Z1, by name.
        """
        t = np.asarray(t, dtype=float)
        angles = {"phi5": self.phi5_far + t, "phi1": self.law.arm(t), "g": self.slope(t)}
        return load(MODEL)("motion", **angles, omega=self.omega, triangle=self.geometry.triangle)

    def tip(self, t: Array) -> Array:
        """Places of the tip (n, 2) [m]."""
        motion = self.motion(t)
        return np.column_stack([motion["x_S"], motion["y_S"]])

    def arm_heading(self, t: Array) -> Array:
        """Direction of the arm O1 to tip, counted on: phi5 + pi - phi1 [rad]."""
        return np.asarray(self.phi5_far + np.asarray(t) + np.pi - self.law.arm(t))

    def pitch(self, t: Array) -> dict[str, Array]:
        """Pitch radii, curvatures, places in the gears' own frames and rate of arc at angles on the
        teeth.

        Both frames lie along the centre line where the tip is farthest. Angles in the dwell are
        taken to be the end of the teeth that they are closer to.
        """
        t = np.asarray(t, dtype=float)
        turned = self.law.arm(t) - np.pi
        return load(MODEL)(
            "pitch", slopes=self.law.slopes(t), phi5=t, phi2=turned, a1=self.geometry.a1
        )

    def contact_ratio(
        self, t: Array, module: float | None = None, addendum: float | None = None
    ) -> Array:
        """Contact ratio of the non-circular pair at angles on the teeth; with another module [m] or
        addendum [-].

        NaN where a pitch curve is so hollow that the tips of its teeth lie inside their base
        circle.
        """
        teeth = self.teeth.copy()
        teeth[0] = teeth[0] if module is None else module
        teeth[1:3] = teeth[1:3] if addendum is None else addendum
        curves = self.pitch(t)
        meshing = TEETH(
            "contact_ratio", kappa1=curves["kappa1"], kappa2=curves["kappa2"], teeth=teeth
        )
        meet = np.minimum(meshing["outside1"], meshing["outside2"]) >= 0
        return np.where(meet, meshing["epsilon"], np.nan)

    @property
    def driven(self) -> tuple[float, float]:
        """First and last carrier angle at which the arm is driven: the turn without the dwell, from
        its end on.
        """
        return toothed_range(self.law.dwell)

    @cached_property
    def toothed(self) -> tuple[float, float]:
        """First and last carrier angle of the teeth.

        That is where the arm is driven, less the law's own transitions; or, where a path stops so
        gradually that no pitch curve can follow, less the parts next to the dwell that cannot be
        gears.
        """
        (first, last), transition = self.driven, self.law.transition
        if self.law.dwell is None or transition:
            return first + transition, last - transition
        t = np.linspace(first, last, round((last - first) / _STEP) + 1)
        slope = self.law.slopes(t)[0]
        moving = slope > 0
        fails = ~moving & (slope > BACKWARD)
        fails[moving] = violates_limits(self.pitch(t[moving]), self.teeth)
        lost = np.flatnonzero(fails)
        after, before = lost[t[lost] < first + BESIDE], lost[t[lost] > last - BESIDE]
        return float(t[after[-1] + 1]) if len(after) else first, float(t[before[0] - 1]) if len(
            before
        ) else last

    def samples(self, count: int) -> Array:
        """Angles evenly over the teeth, both ends included."""
        return np.linspace(*self.toothed, count)

    @cached_property
    def nearest_angle(self) -> float:
        """Carrier angle where the tip is nearest [rad]; the first of them, should the arm dwell
        there.
        """
        return float(
            scipy.optimize.brentq(
                lambda t: float(self.law.arm(np.array([t]))[0]) - TURN,
                0.0,
                TURN,
                xtol=1e-15,
                rtol=1e-14,
            )
        )

    @cached_property
    def slope_extremes(self) -> tuple[float, float]:
        """Least and largest slope of the law on the teeth."""

        def slope(t: Array) -> Array:
            return self.law.slopes(t)[0]

        t = self.samples(1441)
        return extrema.find_minimum(slope, t).value, extrema.find_maximum(slope, t).value

    @cached_property
    def arc(self) -> float:
        """Length of pitch curve on the sun's teeth [m]; the intermediate gear's is the same."""
        return self.integral(lambda t: self.pitch(t)["arc"], self.toothed)

    @property
    def monotone(self) -> bool:
        """Whether the arm's angle never falls."""
        return (
            float(self.law.slopes(np.linspace(*self.driven, 1441))[0].min()) >= 0
            and self.slope_extremes[0] >= 0
        )

    def meshes(self, t: Array) -> Array:
        """Whether teeth drive the arm at carrier angles (n,)."""
        first, last = self.toothed
        return np.asarray((np.asarray(t) - first) % TURN < last - first)

    def integral(
        self, function: Callable[[Array], Array], over: tuple[float, float] | None = None
    ) -> float:
        """Integral of a function of angles (n,) over a range, or where the arm is driven.

        By Gauss panels between the law's breakpoints.
        """
        first, last = over or self.driven
        points = self.law.breakpoints()
        inside = points[(points > first) & (points < last)]
        ends = np.unique(np.concatenate([np.linspace(first, last, PANELS + 1), inside]))
        nodes, weights = piecewise.gauss_panels(ends, NODES)
        return float(np.sum(function(nodes.ravel()) * weights.ravel()))


def build_geometry(machine: Pickup, L1: float, L2: float) -> PickupGeometry:
    """Triangle and helical pair of a pick-up with given bars [m].

    Raises GeometryError where the triangle is none.
    """
    gamma, a2 = machine.si("carrier.gamma_deg"), machine.si("carrier.a2_mm")
    if a2 >= L1:
        raise _no_triangle(machine, L1)
    stage = {
        key: machine.si(f"helical_stage.{key}")
        for key in ("mn_mm", "z1", "z2", "B_mm", "alpha_n_deg", "ha")
    }
    carrier = load(MODEL).at("carrier", carrier=np.array([L1, gamma, a2, *stage.values()]))
    return PickupGeometry(
        L1, L2, gamma, carrier["a1"], a2, carrier["beta1"], carrier["beta"], carrier["epsilon_h"]
    )


def _no_triangle(machine: Pickup, L1: float) -> GeometryError:
    allowed = f"it must be less than L1 = {L1 * 1000:.6g} mm, or the carrier is no triangle"
    if machine.points is not None:
        allowed += (
            f"; L1 is half the difference of the largest and the least distance of the points in "
            f"{machine.points_source} from the origin (are they in mm, and is their origin the "
            f"sun's centre?)"
        )
    return GeometryError(str(machine.input_error("carrier.a2_mm", allowed)))


def build_train(machine: Pickup) -> PickupTrain:
    """The train that a file asks for, by its law or by its path; with a path the file's bars play
    no part.

    Raises InputError where a path or a law has no mechanism.
    """
    teeth = np.array(
        [machine.si(f"noncircular_stage.{key}") for key in ("m_mm", "ha1", "ha2", "alpha0_deg")]
    )
    omega = machine.si("carrier.speed_deg_per_s")
    if machine.points is not None:
        inversion = invert_path(machine.points, machine.tolerance, machine.points_source)
        return PickupTrain(
            inversion.law,
            build_geometry(machine, inversion.L1, inversion.L2),
            inversion.phi5_far,
            omega,
            teeth,
            inversion,
        )
    geometry = build_geometry(machine, machine.si("bars.L1_mm"), machine.si("bars.L2_mm"))
    return PickupTrain(_law(machine), geometry, machine.si("phi5_far_deg"), omega, teeth)


def _law(machine: Pickup) -> ArmLaw:
    assert machine.law is not None
    dwell = Dwell(*(machine.si(f"dwell_t_deg[{i}]") for i in (0, 1)))
    p, far, transition = machine.si("law.p"), machine.si("phi1_far_deg"), machine.law.transition
    law = CosineLaw(p, dwell, far, transition)
    if transition and not law.rises:
        raise machine.input_error(
            "law.p", "the slope must rise from zero throughout the transitions next to the dwell"
        )
    return law


GEARS = {"sun": ("R1", "kappa1"), "intermediate gear": ("R2", "kappa2")}
"""The non-circular gears, each with the names of its pitch radius and curvature."""
BACKWARD = -0.02
"""Slope below which the arm turns back, and not by what a spline through points overshoots [-]."""


def mate_reaches(teeth: Array) -> dict[str, float]:
    """Return the depth to which the teeth of its mate reach into the pitch curve of each gear
    [m].
    """
    return {"sun": float(teeth[2] * teeth[0]), "intermediate gear": float(teeth[1] * teeth[0])}


def tip_heights(teeth: Array) -> dict[str, float]:
    """Return the height of each gear's teeth above its pitch curve [m]."""
    return {"sun": float(teeth[1] * teeth[0]), "intermediate gear": float(teeth[2] * teeth[0])}


def limit_excesses(curves: Mapping[str, Array], teeth: Array) -> dict[tuple[str, str], Array]:
    """Return the excess over each limit at angles (n,) of positive slope, by gear and kind;
    violated if not negative.

    A pitch radius is more than the mate's teeth reach into it. The radius of curvature is more than
    the depth of the roots where the curve is convex, and than the height of the tips where it is
    hollow: else the curve of the roots, or of the tips, has a cusp.
    """
    excess = {}
    for gear, (radius, kappa) in GEARS.items():
        excess[gear, "radius"] = mate_reaches(teeth)[gear] - curves[radius]
        excess[gear, "sharp"] = curves[kappa] * mate_reaches(teeth)[gear] - 1
        excess[gear, "hollow"] = -curves[kappa] * tip_heights(teeth)[gear] - 1
    return excess


def violates_limits(curves: Mapping[str, Array], teeth: Array) -> Array:
    """Return whether any limit is violated (n,)."""
    return np.asarray(np.max(list(limit_excesses(curves, teeth).values()), axis=0) >= 0)
