"""The Reuleaux-pentagon clutch as an audit subject (shi2021): derived equations, admissible points,
reference cycle.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
from mpmath import mpf
from sympy import Expr

from ...audit.paper import Subject
from ...equations import Claimed, Equation
from ...evaluate import MachineFile
from ...formulas import Formulas, Values
from ...quantity import Quantity
from . import geometry, motion
from . import quantities as q

ASSUMPTIONS = (
    "rigid polygon and hexagon, no clearance",
    "vertices A and B stay on their sides while C passes a corner",
    "teeth meet the flats of the shaft without backlash",
    "crank gear rolls on the rack, external mesh",
    "output shaft is a uniform Euler-Bernoulli beam in one assumed mode, a quarter sine from its "
    "bearing",
    "shaft end undeformed at contact and at the body's speed; both move together",
)

DATA = Path(__file__).parents[3] / "planter" / "papers" / "clutch" / "examples" / "shi2021.toml"
DIGITS = 60
SOLVED = (
    ("vertex C from vertex B, X", q.X_B),
    ("sleeve on the taper, force across it", q.F_N),
    ("rotation of the crank gear for a number of teeth", q.n),
    ("forces on the tooth across the surface", q.F_x),
)
"""Quantities that follow from equations which do not define them."""


@cache
def derive_formulas() -> Formulas:
    """Return every derived equation by its claim."""
    f = Formulas("clutch")
    parts = geometry.add_polygon, geometry.add_tooth, geometry.add_taper
    for add_equations in (*parts, motion.add_linkage, motion.add_engagement, motion.add_slip):
        add_equations(f)
    return Formulas(
        f.name,
        (replace(e, residual=geometry.substitute_angles(e.residual)) for e in f.equations.values()),
    )


def complete_values(independent: Values) -> Values:
    """Return the independent quantities with all that depend on them, to the current precision."""
    values = dict(independent)
    values[q.k] = values[q.r_A] / values[q.r_D]
    values[q.Y1], values[q.Y2] = values[q.S1] - values[q.S2], values[q.S3] - values[q.S4]
    return derive_formulas().followed(values, *SOLVED)


_RANGES: dict[Quantity, tuple[str, str]] = {
    q.a1: ("0.008", "0.016"),
    q.mu: ("0.05", "0.3"),
    q.d: ("0.008", "0.012"),
    q.F1: ("50", "90"),
    q.F2: ("10", "40"),
    q.r_A: ("0.012", "0.022"),
    q.r_D: ("0.038", "0.05"),
    q.gamma: ("1.3", "1.5"),
    q.m: ("0.001", "0.003"),
    q.l_AB: ("0.014", "0.017"),
    q.l_AC: ("0.038", "0.042"),
    q.l_BC: ("0.042", "0.047"),
    q.l: ("0.04", "0.09"),
    q.E: ("1e11", "3e11"),
    q.rho: ("7000", "8500"),
    q.m1: ("0.2", "0.4"),
    q.F_M: ("80", "150"),
    q.Delta_omega: ("3", "6"),
    q.r1: ("0.009", "0.013"),
    q.t: ("1e-5", "8e-5"),
    q.theta0: ("0.4", "0.8"),
    q.F_y: ("1", "3"),
    q.f0: ("0.5", "2"),
    q.S1: ("0.01", "0.05"),
    q.S2: ("0", "0.009"),
    q.S3: ("0.01", "0.05"),
    q.S4: ("0", "0.009"),
    q.v_c: ("0.02", "0.08"),
    q.fixity: ("0.2", "0.8"),
}


def _read_data(machine: MachineFile) -> Values:
    """Return the data of the built-in clutch in SI units and radians."""
    return {s: machine.si(s.shown) for s in q.TABLE.values() if s.shown}


def _machine_values() -> Values:
    """Return the data of the built-in clutch, with the quantities that follow directly."""
    machine = MachineFile.read(DATA)
    v = _read_data(machine)
    v[q.R] = mpmath.sqrt(3) * v[q.a]
    v[q.a1] = machine.si("shaft.flat_to_flat_mm") / mpmath.sqrt(3)
    v[q.R1] = v[q.R2] + v[q.d] * mpmath.tan(v[q.phi])
    v[q.Delta_omega] = machine.si("engagement.input_speed_rpm")
    v[q.F_M] = machine.si("engagement.load_Nm") / v[q.r1]
    return v


def _contact_time(v: Values) -> mpf:
    """Return the time at which the contact load has fallen to zero, or a full period if it never
    does.
    """
    swing, lag = v[q.N_max] - v[q.F_M], mpmath.atan2(v[q.B2], v[q.v_0] * v[q.B1])
    ends = mpmath.pi + mpmath.asin(v[q.F_M] / swing) + lag if v[q.F_M] < swing else 2 * mpmath.pi
    return ends / v[q.B1]


class ClutchSubject(Subject):
    """The clutch as derived, with the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return the derived equations by their claims."""
        return derive_formulas().equations

    def admissible(self, rng: random.Random) -> Values:
        """Return a random point at which all derived equalities and conditions of a working clutch
        hold.

        Two equations describe a special state and are left out: the faces at the smallest tip
        distance, and no slip.
        """
        with mpmath.workdps(DIGITS):

            def between(low: Any, high: Any) -> mpf:
                return low + (high - low) * mpf(rng.getrandbits(DIGITS * 4)) / 2 ** (DIGITS * 4)

            v: Values = {
                symbol: between(mpf(low), mpf(high)) for symbol, (low, high) in _RANGES.items()
            }
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
            return complete_values(v)

    def reference(self, points: int) -> list[Values]:
        """Return all quantities of the built-in clutch while each variable runs from its start to
        its end.

        C passes a corner, the link rises from the horizontal to the limit of the linkage, tooth and
        shaft stay in contact, and the position on the shaft moves from the bearing to the contact.
        """
        with mpmath.workdps(DIGITS):
            fixed = _machine_values()
            zero = mpf(0)
            still = complete_values(
                {**fixed, q.theta: mpmath.pi / 2, q.alpha: zero, q.t: zero, q.x: zero}
            )
            limit = mpmath.pi / 2 - fixed[q.gamma] + still[q.k] * still[q.theta_Amax]
            ranges = {
                q.theta: (mpmath.pi * 11 / 30, mpmath.pi / 2),
                q.alpha: (zero, limit),
                q.t: (zero, _contact_time(still)),
                q.x: (zero, fixed[q.l]),
            }
            shares = [mpf(i) / max(points - 1, 1) for i in range(points)]
            return [
                complete_values(
                    {**fixed, **{s: a + (b - a) * share for s, (a, b) in ranges.items()}}
                )
                for share in shares
            ]

    def constraint_residuals(self, claim: Claimed, formula: Expr) -> Mapping[str, Expr]:
        """Return what must vanish at the bearing, by a stated deflection."""
        deflections = ("deflection of the shaft in its mode", "deflection of the shaft over time")
        return motion.bearing_conditions(formula) if claim in deflections else {}


SUBJECT = ClutchSubject()
