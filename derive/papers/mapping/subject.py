"""Design of a non-circular planetary gear train by kinematic mapping as an audit subject
(sun2019).
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import mpmath as mp
import numpy as np
import sympy as sp
from scipy.interpolate import CubicSpline

from ...audit.paper import Subject
from ...equations import Claimed, Equation
from ...evaluate import MachineFile
from ...formulas import Formulas, evaluate_expression
from ...quantity import Quantity
from . import geometry
from . import quantities as q

ASSUMPTIONS = (
    "rigid bodies, plane motion",
    "no clearance, no backlash",
    "pitch curves roll without slip",
)

DATA = Path(__file__).parents[3] / "planter" / "papers" / "mapping" / "examples" / "sun2019.toml"
DIGITS = 70
SAMPLES = 3600
"""Angles of a revolution over which a mean is taken."""
REAL = mp.mpf(10) ** -25
"""Share of a root up to which its imaginary part is a rounding error."""
Point = dict[Quantity, mp.mpf]


@cache
def derive_formulas() -> Formulas:
    """Return the derived equations."""
    f = Formulas("mapping_exact")
    geometry.add_dyads(f)
    geometry.add_train(f)
    return f


def complete_values(values: Point) -> Point:
    """Return the values with all that the derived definitions give."""
    return derive_formulas().followed(values)


def evaluate_row(values: Point) -> Point:
    """Return the entries of a row of the matrix, for the pose of a point."""
    mapped = complete_values(values)
    return complete_values({at_j: mapped[z] for z, at_j in zip(q.MAPPED, q.MAPPED_J, strict=True)})


def null_space(rows: Iterable[Point]) -> dict[Quantity, mp.mpf]:
    """Return a basis of the null space of the matrix with some rows."""
    matrix = mp.matrix([[row[entry] for entry in q.ENTRIES] for row in rows])
    _, _, right = mp.svd_r(matrix, full_matrices=True)
    return {
        component: right[matrix.rows + n, k]
        for n, vector in enumerate(q.BASIS)
        for k, component in enumerate(vector)
    }


def complex_pairs(rows: Iterable[Point]) -> mp.mpf:
    """Return the number of pairs of complex solutions of the two conditions on the null space of a
    matrix.
    """
    basis = complete_values(null_space(rows))
    coefficients = [
        evaluate_expression(expr, basis) for expr in geometry.derive_eliminant().all_coeffs()
    ]
    roots = mp.polyroots(coefficients, maxsteps=500, extraprec=500)
    real = sum(1 for root in roots if abs(mp.im(root)) < REAL * abs(root))
    return mp.mpf(len(roots) - real) / 2


def pose_rows(machine: MachineFile) -> list[Point]:
    """Return the rows of the matrix for the poses of a machine file."""
    keys = {q.d1: "x_mm", q.d2: "y_mm", q.phi: "phi_deg"}
    poses = range(len(machine.tables["pose"]))
    return [
        evaluate_row({s: machine.si(f"pose[{i}].{key}") for s, key in keys.items()}) for i in poses
    ]


def _dyad(machine: MachineFile) -> Point:
    names = q.TABLE.select("x y X_c Y_c L1")
    hinges = (*machine.all_si("dyad.moving_point_mm"), *machine.all_si("dyad.centre_mm"))
    return {
        **dict(zip(names, (*hinges, machine.si("dyad.radius_mm")), strict=True)),
        q.a0: mp.mpf(1),
    }


def _curve(machine: MachineFile) -> CubicSpline:
    """Return the absolute angle of the arm over that of the carrier, periodic."""
    theta, relative = (
        np.array(machine.all_si(f"curve.{key}"), float) for key in ("carrier_deg", "relative_deg")
    )
    arm = relative + theta
    return CubicSpline(theta, [*arm[:-1], arm[0]], bc_type="periodic")


def mean_root(curve: CubicSpline) -> mp.mpf:
    """Return the mean of 1/sqrt(i) over a revolution of a periodic angle curve, by the trapezoidal
    rule.
    """
    slopes = curve(np.arange(SAMPLES) * 2 * np.pi / SAMPLES, 1) - 1
    return mp.mpf(float(np.mean(np.sqrt(-slopes))))


def _multiples(point: Point) -> Point:
    """Return the multiples of the basis that give the coefficients of the dyad."""
    basis = mp.matrix([[point[component] for component in vector] for vector in q.BASIS]).T
    multiples = mp.lu_solve(basis, mp.matrix([point[p] for p in q.COEFFICIENTS]))
    return dict(zip(q.PARAMETERS, multiples, strict=True))


class MappingSubject(Subject):
    """The design by kinematic mapping as derived, with the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return the derived equations by their claims."""
        return derive_formulas().equations

    def admissible(self, rng: random.Random) -> dict[Quantity, mp.mpf]:
        """Return a random point: all quantities are independent, except the split parameter."""
        with mp.workdps(DIGITS):
            sizes = {s: mp.mpf(rng.uniform(0.2, 2)) for s in q.TABLE.values()}
            free = {
                s: size if s in q.POSITIVE else rng.choice((-1, 1)) * size
                for s, size in sizes.items()
            }
            return {
                **free,
                q.x_s: evaluate_expression(derive_formulas().expr("split parameter"), free),
            }

    def reference(self, points: int) -> list[dict[Quantity, mp.mpf]]:
        """Return all quantities over a revolution of the built-in train; five of its poses form the
        matrix.
        """
        with mp.workdps(DIGITS):
            machine = MachineFile.read(DATA)
            curve, dyad = _curve(machine), _dyad(machine)
            speed = machine.si("train.carrier_speed_rpm")
            start = mp.mpf(float(curve(0)))
            shared = {
                **dyad,
                q.w1: speed,
                q.a: machine.si("train.centre_distance_mm"),
                q.mean_root: mean_root(curve),
                q.n_pairs: complex_pairs(pose_rows(machine)),
                q.y_first: start,
                q.y_last: start + mp.mpf(sp.N(geometry.curve_rise(), DIGITS)),
            }

            def pose_at(theta: mp.mpf) -> Point:
                angle, rate = (mp.mpf(float(curve(float(theta), order))) for order in (0, 1))
                return {q.theta: theta, q.phi: angle, q.w2: speed * rate}

            rows = [evaluate_row({**dyad, **pose_at(2 * mp.pi * k / 5)}) for k in range(5)]
            shared |= null_space(rows) | {z: rows[1][z] for z in q.MAPPED_J}
            shared |= _multiples(complete_values({**shared, **pose_at(mp.mpf(0))}))
            return [
                complete_values({**shared, **pose_at(2 * mp.pi * k / points)})
                for k in range(points)
            ]


SUBJECT = MappingSubject()
