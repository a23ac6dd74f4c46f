"""The Reuleaux-pentagon clutch (shi2021), derived: its claims, admissible points and a reference cycle."""

from __future__ import annotations

import random
import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import sympy as sp
from mpmath import mpf

from ...chain import Chain
from ...equations import Claimed, Equation, by_claim
from ...quantity import Quantity
from . import quantities as q
from .geometry import polygon_claims, taper_claims, tooth_claims
from .motion import engagement_claims, linkage_claims, slip_claims
from .vocabulary import ClutchClaim

ASSUMPTIONS = (
    "rigid polygon and hexagon, no clearance",
    "vertices A and B stay on their sides while C passes a corner",
    "teeth meet the flats of the shaft without backlash",
    "crank gear rolls on the rack, external mesh",
    "output shaft is a uniform Euler-Bernoulli beam in one assumed mode, a quarter sine from its bearing",
    "shaft end undeformed at contact and at the body's speed; both move together",
)

Values = dict[Quantity, mpf]
DATA = Path(__file__).parents[3] / "planter" / "clutch" / "examples" / "shi2021.toml"
DIGITS = 60
_SCALES: dict[str, Callable[[], Any]] = {
    "_mm_s": lambda: mpf("1e-3"),
    "_mm": lambda: mpf("1e-3"),
    "_deg": lambda: mpmath.pi / 180,
    "_rpm": lambda: mpmath.pi / 30,
    "_GPa": lambda: mpf("1e9"),
}
_ORDER: tuple[tuple[Claimed, Quantity], ...] = (
    (ClutchClaim.DIRECTION_BC, q.beta),
    (ClutchClaim.HEXAGON_SIDE, q.a),
    (ClutchClaim.PATH_SINE, q.A1),
    (ClutchClaim.PATH_COSINE, q.A2),
    (ClutchClaim.SIDE_OF_A, q.y_A),
    (ClutchClaim.SIDE_OF_B, q.Y_B),
    (ClutchClaim.A_SLIDING, q.x_A),
    (ClutchClaim.PATH_X, q.x_C),
    (ClutchClaim.PATH_Y, q.y_C),
    (ClutchClaim.C_TURNED_X, q.X_C),
    (ClutchClaim.C_TURNED_Y, q.Y_C),
    (ClutchClaim.C_FROM_B_X, q.X_B),
    (ClutchClaim.ELLIPSE_CENTRE_X, q.x_E),
    (ClutchClaim.ELLIPSE_CENTRE_Y, q.y_E),
    (ClutchClaim.FOCUS_X, q.x_F),
    (ClutchClaim.FOCI_LINE, q.y_F),
    (ClutchClaim.SEMI_MAJOR_AXIS, q.s_1),
    (ClutchClaim.SEMI_MINOR_AXIS, q.s_2),
    (ClutchClaim.PATH_CURVATURE, q.rho_C),
    (ClutchClaim.THIRD_OVERLAP, q.e_3),
    (ClutchClaim.TIP_PATH_CURVATURE, q.rho_t),
    (ClutchClaim.FACE_ANGLE, q.xi),
    (ClutchClaim.OUTLINE_RADIUS, q.b),
    (ClutchClaim.LEAST_TRAVEL, q.c_min),
    (ClutchClaim.SLEEVE_ACROSS, q.F_N),
    (ClutchClaim.SLEEVE_FRICTION, q.f),
    (ClutchClaim.CRANK_GEAR, q.theta_A),
    (ClutchClaim.CRANK_GEAR_ON_LINK, q.theta_AR),
    (ClutchClaim.CRANK_BY_TRAVEL, q.theta_Amax),
    (ClutchClaim.CRANK_BY_TEETH, q.n),
    (ClutchClaim.SWITCHING_TIME, q.t_c),
    (ClutchClaim.SHAFT_SECTION, q.S),
    (ClutchClaim.SECOND_MOMENT, q.I),
    (ClutchClaim.MODAL_MASS, q.M_1),
    (ClutchClaim.MODAL_STIFFNESS, q.K_1),
    (ClutchClaim.OVERHANG_MASS, q.m2),
    (ClutchClaim.CONTACT_FREQUENCY, q.B1),
    (ClutchClaim.DRIVING_ACCELERATION, q.B2),
    (ClutchClaim.CONTACT_SPEED, q.v_0),
    (ClutchClaim.CONTACT_DEFLECTION, q.y_max),
    (ClutchClaim.MODAL_DEFLECTION, q.y),
    (ClutchClaim.CONTACT_ACCELERATION, q.a_l),
    (ClutchClaim.SHAFT_ACCELERATION, q.a_x),
    (ClutchClaim.FOURTH_DERIVATIVE, q.y_4x),
    (ClutchClaim.MODAL_DELTA, q.delta_l),
    (ClutchClaim.CONTACT_LOAD, q.N),
    (ClutchClaim.LARGEST_LOAD, q.N_max),
    (ClutchClaim.TOOTH_ACROSS, q.F_x),
    (ClutchClaim.SLIP_ACCELERATION, q.a0),
)
"""Which derived equation gives which dependent quantity, in order."""


@cache
def _claims() -> Mapping[Claimed, Equation]:
    parts = (polygon_claims, tooth_claims, taper_claims, linkage_claims, engagement_claims, slip_claims)
    return by_claim(equation for part in parts for equation in part())


def claims() -> dict[Claimed, Equation]:
    """Every derived equation by what it claims to be."""
    return dict(_claims())


@cache
def _steps() -> tuple[tuple[Quantity, tuple[Quantity, ...], Callable[..., mpf]], ...]:
    steps = []
    for let in Chain.of_claims(_claims(), _ORDER).lets():
        needs = tuple(sorted(let.expr.free_symbols, key=str))
        steps.append((let.symbol, needs, sp.lambdify(needs, let.expr, "mpmath")))
    return tuple(steps)


def completed(independent: Values) -> Values:
    """The independent quantities with all that depend on them, to the precision of the moment."""
    values = dict(independent)
    values[q.k] = values[q.r_A] / values[q.r_D]
    values[q.Y1], values[q.Y2] = values[q.S1] - values[q.S2], values[q.S3] - values[q.S4]
    for symbol, needs, function in _steps():
        values[symbol] = mpf(function(*(values[s] for s in needs)))
    return values


_RANGES: dict[Quantity, tuple[str, str]] = {
    q.a1: ("0.008", "0.016"), q.mu: ("0.05", "0.3"), q.d: ("0.008", "0.012"), q.F1: ("50", "90"), q.F2: ("10", "40"),
    q.r_A: ("0.012", "0.022"), q.r_D: ("0.038", "0.05"), q.gamma: ("1.3", "1.5"), q.m: ("0.001", "0.003"),
    q.l_AB: ("0.014", "0.017"), q.l_AC: ("0.038", "0.042"), q.l_BC: ("0.042", "0.047"),
    q.l: ("0.04", "0.09"), q.E: ("1e11", "3e11"), q.rho: ("7000", "8500"), q.m1: ("0.2", "0.4"), q.F_M: ("80", "150"),
    q.Delta_omega: ("3", "6"), q.r1: ("0.009", "0.013"), q.t: ("1e-5", "8e-5"), q.theta0: ("0.4", "0.8"),
    q.F_y: ("1", "3"), q.f0: ("0.5", "2"), q.S1: ("0.01", "0.05"), q.S2: ("0", "0.009"), q.S3: ("0.01", "0.05"),
    q.S4: ("0", "0.009"), q.v_c: ("0.02", "0.08"),
}  # fmt: skip


def admissible(rng: random.Random) -> Values:
    """A random point at which every derived equality and every derived condition of a working clutch holds.

    Two equations speak of a special state and are left out: the faces at the least tip distance, and no slip.
    """
    with mpmath.workdps(DIGITS):

        def between(low: Any, high: Any) -> mpf:
            return low + (high - low) * mpf(rng.getrandbits(DIGITS * 4)) / 2 ** (DIGITS * 4)

        v: Values = {symbol: between(mpf(low), mpf(high)) for symbol, (low, high) in _RANGES.items()}
        half_arc = 2 * mpmath.pi / 5
        v[q.theta] = between(mpmath.pi * 11 / 30, mpmath.pi / 2)
        v[q.R] = v[q.a1] * between(mpf("2.5"), mpf("3.5"))
        v[q.r] = v[q.a1] * between(mpf("0.32"), mpf("0.5"))
        v[q.b1] = v[q.a1] * between(mpf("0.915"), mpf("1.1"))
        v[q.b2] = v[q.a1] * between(mpf(1), mpf("1.1"))
        v[q.R2] = v[q.b2] + between(mpf("0.001"), mpf("0.003"))
        v[q.R1] = v[q.R2] + v[q.d] * between(mpf("0.1"), mpf("0.5"))
        v[q.phi] = mpmath.atan((v[q.R1] - v[q.R2]) / v[q.d])
        lift = v[q.R] * (1 / mpmath.sin(half_arc) - 1) / 2
        v[q.c] = lift / mpmath.tan(v[q.phi]) * between(mpf("1.05"), mpf("1.5"))
        mesh = mpmath.pi / 2 - v[q.gamma]
        v[q.alpha] = rng.choice((between(mpf(0), mesh), between(mesh, mpf(1))))
        v[q.x] = v[q.l] * between(mpf("0.1"), mpf("0.9"))
        return completed(v)


def _tables() -> dict[str, Any]:
    return tomllib.loads(DATA.read_text(encoding="utf-8"), parse_float=mpf)


def _given() -> Values:
    """The data of the built-in clutch in SI units and radians."""
    tables = _tables()
    return {s: _at(tables, s.shown) for s in vars(q).values() if isinstance(s, Quantity) and s.shown}


def _at(tables: Mapping[str, Any], path: str) -> mpf:
    table, _, key = path.partition(".")
    scale = next((factor() for suffix, factor in _SCALES.items() if key.endswith(suffix)), mpf(1))
    return mpf(tables[table][key]) * scale


def reference(points: int) -> list[Values]:
    """All quantities of the built-in clutch while everything that varies runs from start to end of its own course.

    C passes a corner, the link rises from the horizontal to the limit of the linkage, tooth and shaft stay in contact,
    and the place on the shaft moves from the bearing to the contact.
    """
    with mpmath.workdps(DIGITS):
        fixed = _machine()
        zero = mpf(0)
        still = completed({**fixed, q.theta: mpmath.pi / 2, q.alpha: zero, q.t: zero, q.x: zero})
        limit = mpmath.pi / 2 - fixed[q.gamma] + still[q.k] * still[q.theta_Amax]
        courses = {
            q.theta: (mpmath.pi * 11 / 30, mpmath.pi / 2),
            q.alpha: (zero, limit),
            q.t: (zero, _contact_time(still)),
            q.x: (zero, fixed[q.l]),
        }
        shares = [mpf(i) / max(points - 1, 1) for i in range(points)]
        return [completed({**fixed, **{s: a + (b - a) * share for s, (a, b) in courses.items()}}) for share in shares]


def _machine() -> Values:
    """The built-in clutch with what follows from its data at once."""
    tables, v = _tables(), _given()
    v[q.R] = mpmath.sqrt(3) * v[q.a]
    v[q.a1] = _at(tables, "shaft.flat_to_flat_mm") / mpmath.sqrt(3)
    v[q.R1] = v[q.R2] + v[q.d] * mpmath.tan(v[q.phi])
    v[q.Delta_omega] = _at(tables, "engagement.input_speed_rpm")
    v[q.F_M] = _at(tables, "engagement.load_Nm") / v[q.r1]
    return v


def _contact_time(v: Values) -> mpf:
    """When the contact load has fallen to zero; a full period where it never does."""
    swing, lag = v[q.N_max] - v[q.F_M], mpmath.atan2(v[q.B2], v[q.v_0] * v[q.B1])
    ends = mpmath.pi + mpmath.asin(v[q.F_M] / swing) + lag if v[q.F_M] < swing else 2 * mpmath.pi
    return ends / v[q.B1]
