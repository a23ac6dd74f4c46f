"""The seedling pick-up as an audit subject (yu2023): derived equations, admissible points,
reference cycle.

Only independent quantities are chosen; the others follow from the derived formulas, at 60 digits.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mpmath as mp
import sympy as sp
from mpmath import mpf

from ...audit.paper import Subject
from ...equations import Claimed, Equation
from ...evaluate import MachineFile
from ...formulas import Formulas, Values, evaluate_expression
from ...quantity import Quantity
from . import geometry
from . import quantities as q
from .geometry import CONTROLS, INTERVALS, KNOTS

ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "M1 lies counter-clockwise of O1 as seen from O",
    "the helical gears of stage 2 are equal",
    "L2 is longer than L1",
    "pitch curves convex where teeth mesh",
)


@cache
def derive_formulas() -> Formulas:
    """Return the derived equations of the pick-up."""
    f = Formulas("pickup_exact")
    for add_equations in (
        geometry.add_spline,
        geometry.add_geometry,
        geometry.add_train,
        geometry.add_teeth,
    ):
        add_equations(f)
    return f


DIGITS = 60
MACHINE = Path(__file__).parents[3] / "planter" / "papers" / "pickup" / "examples" / "yu2023.toml"


def complete_values(formulas: Formulas, base: Mapping[Quantity, mpf]) -> Values:
    """Return the base with all defined symbols of the formulas.

    Raises ValueError if one does not follow from it.
    """
    values = formulas.followed(base)
    defined = {equation.defines for equation in formulas.equations.values()} - {None}
    if left := sorted(map(str, defined - values.keys())):
        raise ValueError(f"nothing leads to {', '.join(left)}")
    return values


def random_base(rng: random.Random) -> Values:
    """Draw the independent quantities of a pick-up: an obtuse bend, L2 > L1 > a2, any direction of
    the tip from O.
    """
    ranges: dict[Quantity, tuple[float, float]] = {
        q.L1: (0.06, 0.12),
        q.gamma: (1.7, 2.9),
        q.phi1: (3.2, 9.4),
        q.phi4: (-3.1, 3.1),
        q.phi50: (-1.0, 1.0),
        q.phi30: (0.5, 1.5),
        q.phi2: (0.1, 6.2),
        q.omega: (1.0, 9.0),
        q.dphi1: (0.2, 1.5),
        q.dphi5: (0.2, 1.5),
        q.dR1: (-0.005, 0.005),
        q.ddR1: (-0.004, 0.002),
        q.m_n: (0.001, 0.002),
        q.beta: (0.14, 0.35),
        q.B: (0.005, 0.02),
        q.alpha_n: (0.25, 0.45),
        q.ha_n: (0.8, 1.2),
        q.alpha0: (0.25, 0.45),
        q.m: (0.001, 0.003),
        q.ha1: (0.8, 1.3),
        q.ha2: (0.8, 1.3),
        q.theta_box: (0.5, 1.2),
    }
    values = {symbol: mpf(rng.uniform(*bounds)) for symbol, bounds in ranges.items()}
    values[q.L2] = values[q.L1] + mpf(rng.uniform(0.02, 0.1))
    values |= {symbol: mpf(rng.randint(15, 25)) for symbol in (q.z_1, q.z_2)}
    values |= {q.n: mpf(rng.randint(8, 40)), q.k: mpf(3)}
    values |= {d: mpf(rng.uniform(-0.2, 0.2)) for d in CONTROLS.values()}
    position = mpf(0)
    for knot in KNOTS.values():
        position += mpf(rng.uniform(0.01, 0.1))
        values[knot] = position
    values[q.u] = values[q.u_i] + mpf(rng.random()) * (values[q.u_ip1] - values[q.u_i])
    return values


@dataclass(frozen=True)
class ArmSlope:
    """Slope of the arm's angle over the carrier angle t from the farthest point: c (1 + p cos t),
    zero in the dwell.
    """

    p: mpf
    dwell: tuple[mpf, mpf]

    @property
    def c(self) -> mpf:
        """Mean slope on the teeth, for one revolution of the arm in a cycle."""
        return 2 * mp.pi / self._plain(2 * mp.pi)

    def is_locked(self, t: mpf) -> bool:
        """Whether the carrier angle is in the dwell."""
        return bool(self.dwell[0] <= t <= self.dwell[1])

    def slopes(self, t: mpf) -> tuple[mpf, mpf, mpf]:
        """Return the slope on the teeth and its two derivatives."""
        swing = self.c * self.p
        return self.c + swing * mp.cos(t), -swing * mp.sin(t), -swing * mp.cos(t)

    def rotation(self, t: mpf) -> mpf:
        """Return the increase of the arm's angle since the farthest point, within one
        revolution.
        """
        return self.c * self._plain(t)

    def _plain(self, t: mpf) -> mpf:
        start, end = self.dwell
        return self._toothed(min(t, start)) + self._toothed(max(t, end)) - self._toothed(end)

    def _toothed(self, t: mpf) -> mpf:
        return t + self.p * mp.sin(t)


_FILE_KEYS = {
    q.L1: "bars.L1_mm",
    q.L2: "bars.L2_mm",
    q.gamma: "carrier.gamma_deg",
    q.a2: "carrier.a2_mm",
    q.omega: "carrier.speed_deg_per_s",
    q.phi50: "law.phi5_far_deg",
    q.m_n: "helical_stage.mn_mm",
    q.z_1: "helical_stage.z1",
    q.z_2: "helical_stage.z2",
    q.B: "helical_stage.B_mm",
    q.alpha_n: "helical_stage.alpha_n_deg",
    q.ha_n: "helical_stage.ha",
    q.alpha0: "noncircular_stage.alpha0_deg",
    q.m: "noncircular_stage.m_mm",
    q.ha1: "noncircular_stage.ha1",
    q.ha2: "noncircular_stage.ha2",
    q.theta_box: "tray.box_inclination_deg",
}


def _constant_values(machine: MachineFile, formulas: Formulas) -> Values:
    """Return the quantities of the built-in machine that are constant; the helix angle follows from
    a2.
    """
    values = {symbol: machine.si(key) for symbol, key in _FILE_KEYS.items()}
    values |= {q.n: machine.si("spline.value_points") + 2, q.k: mpf(3)}
    roots = sp.solve(formulas.equations["centre distance of the helical pair"].residual, q.beta)
    helix = (evaluate_expression(root, values) for root in roots)
    return values | {q.beta: min(root for root in helix if root > 0)}


ARM_SLOPES = sp.symbols("g0 g1 g2")
"""Slope of the arm's angle and its two derivatives, in the formulas for the derivatives of the
pitch radius.
"""


def pitch_slopes(formulas: Formulas) -> dict[Quantity, sp.Expr]:
    """Return the derivatives of the sun's pitch radius by the carrier angle, from those of the
    arm's angle.
    """
    t = sp.Symbol("t")
    g = sp.Function("g")(t)
    middle = formulas.expr("pitch radius of the intermediate gear").subs(q.i1, 1 / g)
    radius = formulas.expr("pitch radius of the sun").subs(q.R2, middle)
    names = [(g.diff(t, order), ARM_SLOPES[order]) for order in (2, 1, 0)]
    return {
        symbol: radius.diff(t, order).subs(names) for order, symbol in ((1, q.dR1), (2, q.ddR1))
    }


class ValuePoints:
    """Closed cubic spline through the x of value points equally spaced in t, over their cumulative
    chord length.
    """

    def __init__(self, formulas: Formulas, points: list[tuple[mpf, mpf]]) -> None:
        self.count = len(points)
        pairs = zip(points, points[1:] + points[:1], strict=True)
        chords = [mp.hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairs]
        total = mp.fsum(chords)
        self.intervals = [chord / total for chord in chords]
        matrix, right = mp.zeros(self.count), mp.zeros(self.count, 1)
        for i, (x, _) in enumerate(points):
            row = formulas.followed(self.interval_lengths(i))
            for shift, symbol in ((-1, q.a_i), (0, q.b_i), (1, q.c_i)):
                matrix[i, (i + shift) % self.count] += row[symbol]
            right[i] = evaluate_expression(
                formulas.expr("right side of the row of a knot"), row | {q.q_i: x}
            )
        self.controls = list(mp.lu_solve(matrix, right))

    def interval_lengths(self, i: int) -> Values:
        """Return the intervals around knot i."""
        return {
            symbol: self.intervals[(i + shift) % self.count] for shift, symbol in INTERVALS.items()
        }

    def evaluate(self, turn: mpf) -> Values:
        """Return knots and control points around a share of the cycle, and the parameter."""
        i = int(turn * self.count)
        share = turn * self.count - i
        values = {d: self.controls[(i + shift) % self.count] for shift, d in CONTROLS.items()}
        position = -self.intervals[i - 2] - self.intervals[i - 1]
        for shift, knot in KNOTS.items():
            values[knot] = position
            position += self.intervals[(i + shift) % self.count]
        return values | {q.u: share * values[q.u_ip1]}


def compute_cycle(formulas: Formulas, points: int) -> list[Values]:
    """Return the independent quantities of the built-in machine at the middle of equal steps,
    without the dwell.
    """
    with mp.workdps(DIGITS):
        machine = MachineFile.read(MACHINE)
        base = _constant_values(machine, formulas)
        start, end = machine.all_si("law.dwell_t_deg")
        law, far = ArmSlope(machine.si("law.p"), (start, end)), machine.si("law.phi1_far_deg")

        def moment(turn: mpf) -> Values:
            t = 2 * mp.pi * turn
            return base | {q.phi5: base[q.phi50] + t, q.phi1: far + law.rotation(t)}

        count = int(machine.si("spline.value_points"))
        tips = [formulas.followed(moment(mpf(j) / count)) for j in range(count)]
        base[q.phi30] = tips[0][q.phi3]
        spline = ValuePoints(formulas, [(tip[q.x_S], tip[q.y_S]) for tip in tips])
        radius = pitch_slopes(formulas)

        def independent(turn: mpf) -> Values:
            t = 2 * mp.pi * turn
            slopes = dict(zip(ARM_SLOPES, law.slopes(t), strict=True)) | {q.a1: tips[0][q.a1]}
            pitch = {symbol: evaluate_expression(expr, slopes) for symbol, expr in radius.items()}
            relative = {q.phi2: law.rotation(t), q.dphi5: mpf(1), q.dphi1: slopes[ARM_SLOPES[0]]}
            return moment(turn) | spline.evaluate(turn) | pitch | relative

        turns = [(j + mpf(1) / 2) / points for j in range(points)]
        return [independent(turn) for turn in turns if not law.is_locked(2 * mp.pi * turn)]


class PickupSubject(Subject):
    """The seedling pick-up as derived, with the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return the derived equations by their claims."""
        return derive_formulas().equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Return a random pick-up at a random time: consistent values of all symbols."""
        return complete_values(derive_formulas(), random_base(rng))

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """Return the built-in pick-up at equal steps of the carrier, without those in the dwell.

        In the dwell the total ratio is infinite and no teeth mesh. The first step is half a step
        after the farthest point.
        """
        return [
            complete_values(derive_formulas(), base)
            for base in compute_cycle(derive_formulas(), points)
        ]


SUBJECT = PickupSubject()
