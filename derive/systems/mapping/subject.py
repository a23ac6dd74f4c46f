"""Design of a non-circular planetary gear train by kinematic mapping as an audit subject (sun2019)."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

import mpmath as mp
import numpy as np
import sympy as sp
from mpmath import mpf
from scipy.interpolate import CubicSpline

from ...audit.paper import Subject
from ...equations import Claimed, Equation
from ...evaluate import MachineFile
from ...formulas import Formulas, value
from ...quantity import Quantity
from . import dyads, train
from . import quantities as q
from .quantities import MappingClaim

ASSUMPTIONS = (
    "rigid bodies, plane motion",
    "no clearance, no backlash",
    "pitch curves roll without slip",
)

DATA = Path(__file__).parents[3] / "planter" / "mapping" / "examples" / "sun2019.toml"
DIGITS = 70
REAL = mp.mpf(10) ** -25
"""Share of a root up to which its imaginary part is rounding."""
Point = dict[Quantity, mp.mpf]


@cache
def derive_formulas() -> Formulas:
    """What is derived."""
    f = Formulas("mapping_exact")
    dyads.state(f)
    train.state(f)
    return f


def complete_values(known: Point) -> Point:
    """The known values, and all that the derived definitions make of them."""
    return derive_formulas().followed(known)


def row(known: Point) -> Point:
    """The entries of a matrix's row, its pose being that of a point."""
    mapped = complete_values(known)
    return complete_values({at_j: mapped[z] for z, at_j in zip(q.MAPPED, q.MAPPED_J, strict=True)})


def draw_admissible_point(rng: random.Random) -> dict[Quantity, mp.mpf]:
    """A random point: all quantities independent, but for the split, which the turns of the first stage decide."""
    with mp.workdps(DIGITS):
        sizes = {s: mp.mpf(rng.uniform(0.2, 2)) for s in q.ALL}
        free = {s: size if s in q.POSITIVE else rng.choice((-1, 1)) * size for s, size in sizes.items()}
        return {**free, q.x_s: value(derive_formulas().expr(MappingClaim.SPLIT_PARAMETER), free)}


def null_space(rows: Iterable[Point]) -> dict[Quantity, mp.mpf]:
    """A basis of the null space of the matrix whose rows are given by their entries."""
    matrix = mp.matrix([[row[entry] for entry in q.ENTRIES] for row in rows])
    _, _, right = mp.svd_r(matrix, full_matrices=True)
    return {
        component: right[matrix.rows + n, k] for n, vector in enumerate(q.BASIS) for k, component in enumerate(vector)
    }


def complex_pairs(rows: Iterable[Point]) -> mp.mpf:
    """Number of pairs of complex solutions of the two conditions on the null space of a matrix."""
    basis = complete_values(null_space(rows))
    coefficients = [value(expr, basis) for expr in dyads.eliminant().all_coeffs()]
    roots = mp.polyroots(coefficients, maxsteps=500, extraprec=500)
    real = sum(1 for root in roots if abs(mp.im(root)) < REAL * abs(root))
    return mp.mpf(len(roots) - real) / 2


def pose_rows(machine: MachineFile) -> list[Point]:
    """The rows of the matrix for the poses of a machine file."""
    keys = {q.d1: "x_mm", q.d2: "y_mm", q.phi: "phi_deg"}
    poses = range(len(machine.tables["pose"]))
    return [row({s: machine.si(f"pose[{i}].{key}") for s, key in keys.items()}) for i in poses]


def _dyad(machine: MachineFile) -> Point:
    names = (q.x, q.y, q.X_c, q.Y_c, q.L1)
    hinges = (*machine.all_si("dyad.moving_point_mm"), *machine.all_si("dyad.centre_mm"))
    return {**dict(zip(names, (*hinges, machine.si("dyad.radius_mm")), strict=True)), q.a0: mp.mpf(1)}


def _curve(machine: MachineFile) -> CubicSpline:
    """The absolute angle of the arm over that of the carrier, periodic."""
    theta, relative = (np.array(machine.all_si(f"curve.{key}"), float) for key in ("carrier_deg", "relative_deg"))
    arm = relative + theta
    return CubicSpline(theta, [*arm[:-1], arm[0]], bc_type="periodic")


def mean_root(curve: CubicSpline, samples: int = 3600) -> mp.mpf:
    """Mean of 1/sqrt(i) over a turn, of a periodic curve of the arm's angle; the trapezoidal rule."""
    slopes = curve(np.arange(samples) * 2 * np.pi / samples, 1) - 1
    return mp.mpf(float(np.mean(np.sqrt(-slopes))))


def compute_reference_cycle(points: int) -> list[dict[Quantity, mp.mpf]]:
    """All quantities along a turn of the built-in train; the poses of its matrix are five of that turn."""
    with mp.workdps(DIGITS):
        machine = MachineFile.read(DATA)
        curve, dyad = _curve(machine), _dyad(machine)
        speed = machine.si("train.carrier_speed_rpm")
        start = mp.mpf(float(curve(0)))
        shared = {
            **dyad, q.w1: speed, q.a: machine.si("train.centre_distance_mm"),
            q.mean_root: mean_root(curve), q.n_pairs: complex_pairs(pose_rows(machine)), q.y_first: start,
            q.y_last: start + mp.mpf(sp.N(train.rise(), DIGITS)),
        }  # fmt: skip

        def at(turned: mp.mpf) -> Point:
            angle, rate = (mp.mpf(float(curve(float(turned), order))) for order in (0, 1))
            return {q.theta: turned, q.phi: angle, q.w2: speed * rate}

        rows = [row({**dyad, **at(2 * mp.pi * k / 5)}) for k in range(5)]
        shared |= null_space(rows) | {z: rows[1][z] for z in q.MAPPED_J}
        shared |= _multiples(complete_values({**shared, **at(mp.mpf(0))}))
        return [complete_values({**shared, **at(2 * mp.pi * k / points)}) for k in range(points)]


def _multiples(point: Point) -> Point:
    """Multiples of the basis that make up the coefficients of the dyad."""
    basis = mp.matrix([[point[component] for component in vector] for vector in q.BASIS]).T
    found = mp.lu_solve(basis, mp.matrix([point[p] for p in q.COEFFICIENTS]))
    return dict(zip(q.PARAMETERS, found, strict=True))


class KinematicMapping(Subject):
    """The design by kinematic mapping, as derived, on the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        return derive_formulas().equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        return draw_admissible_point(rng)

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        return compute_reference_cycle(points)


SUBJECT = KinematicMapping()
