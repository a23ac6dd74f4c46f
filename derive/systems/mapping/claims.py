"""Design of a non-circular planetary gear train by kinematic mapping: what is derived, and points to hold it against.

The derivation stands in ``mapping_dyads`` (from poses to dyads) and ``mapping_train`` (from the angle curve to gears).
"""

from __future__ import annotations

import random
import tomllib
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp
from scipy.interpolate import CubicSpline

from ...equations import Claimed, Equation, among, by_claim
from ...quantity import Quantity
from . import dyads, train
from . import quantities as q
from .vocabulary import MappingClaim

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
MM = mp.mpf(1) / 1000


def claims() -> dict[Claimed, Equation]:
    """What is derived, by what it is claimed to be."""
    return dict(_derived())


@cache
def _derived() -> dict[Claimed, Equation]:
    return by_claim((*dyads.equations(), *train.equations()))


def _function(inputs: Sequence[sp.Symbol], expr: Any) -> Callable[..., Any]:
    return sp.lambdify(inputs, expr, "mpmath")


@cache
def _solution(claim: Claimed, symbol: Quantity) -> tuple[tuple[Quantity, ...], Callable[..., mp.mpf]]:
    """What ``symbol`` is by an equation that it is linear in: inputs and function."""
    (expr,) = sp.solve(among(_derived(), claim).residual, symbol)
    inputs = tuple(sorted(expr.free_symbols, key=str))
    return inputs, _function(inputs, expr)


def _value(claim: Claimed, symbol: Quantity, known: Point) -> mp.mpf:
    inputs, function = _solution(claim, symbol)
    return mp.mpf(function(*(known[s] for s in inputs)))


def completed(known: Point) -> Point:
    """The known values, and all that the derived definitions make of them."""
    found = dict(known)
    waiting = [e for e in _derived().values() if e.defines and e.defines not in known]
    while ready := [e for e in waiting if e.residual.free_symbols <= found.keys() | {e.defines}]:
        for equation in ready:
            symbol = equation.defines
            if symbol is not None and symbol not in found:
                found[symbol] = _value(equation.claims, symbol, found)
        waiting = [e for e in waiting if e.defines not in found]
    return found


def row(known: Point) -> Point:
    """The entries of a matrix's row, its pose being that of a point."""
    mapped = completed(known)
    return completed({at_j: mapped[z] for z, at_j in zip(q.MAPPED, q.MAPPED_J, strict=True)})


def admissible(rng: random.Random) -> dict[Quantity, mp.mpf]:
    """A random point: all quantities independent, but for the split, which the turns of the first stage decide."""
    with mp.workdps(DIGITS):
        sizes = {s: mp.mpf(rng.uniform(0.2, 2)) for s in q.ALL}
        free = {s: size if s in q.POSITIVE else rng.choice((-1, 1)) * size for s, size in sizes.items()}
        return {**free, q.x_s: _value(MappingClaim.SPLIT_PARAMETER, q.x_s, free)}


def null_space(rows: Iterable[Point]) -> dict[Quantity, mp.mpf]:
    """A basis of the null space of the matrix whose rows are given by their entries."""
    matrix = mp.matrix([[row[entry] for entry in q.ENTRIES] for row in rows])
    _, _, right = mp.svd_r(matrix, full_matrices=True)
    return {
        component: right[matrix.rows + n, k] for n, vector in enumerate(q.BASIS) for k, component in enumerate(vector)
    }


def complex_pairs(rows: Iterable[Point]) -> mp.mpf:
    """Number of pairs of complex solutions of the two conditions on the null space of a matrix."""
    basis = completed(null_space(rows))
    names = (*q.K1, *q.K2)
    coefficients = _function(names, dyads.eliminant().all_coeffs())(*(basis[k] for k in names))
    roots = mp.polyroots(coefficients, maxsteps=500, extraprec=500)
    real = sum(1 for root in roots if abs(mp.im(root)) < REAL * abs(root))
    return mp.mpf(len(roots) - real) / 2


def pose_rows(machine: dict[str, Any]) -> list[Point]:
    """The rows of the matrix for the poses of a machine file."""
    places = [{q.d1: p["x_mm"] * MM, q.d2: p["y_mm"] * MM, q.phi: mp.radians(p["phi_deg"])} for p in machine["pose"]]
    return [row(place) for place in places]


def _dyad(machine: dict[str, Any]) -> Point:
    dyad = machine["dyad"]
    names = (q.x, q.y, q.X_c, q.Y_c, q.L1)
    values = (*dyad["moving_point_mm"], *dyad["centre_mm"], dyad["radius_mm"])
    return {name: mp.mpf(str(value)) * MM for name, value in zip(names, values, strict=True)} | {q.a0: mp.mpf(1)}


def _curve(machine: dict[str, Any]) -> CubicSpline:
    """The absolute angle of the arm over that of the carrier, periodic."""
    theta, relative = (np.radians(machine["curve"][key]) for key in ("carrier_deg", "relative_deg"))
    arm = relative + theta
    return CubicSpline(theta, [*arm[:-1], arm[0]], bc_type="periodic")


def mean_root(curve: CubicSpline, samples: int = 3600) -> mp.mpf:
    """Mean of 1/sqrt(i) over a turn, of a periodic curve of the arm's angle; the trapezoidal rule."""
    slopes = curve(np.arange(samples) * 2 * np.pi / samples, 1) - 1
    return mp.mpf(float(np.mean(np.sqrt(-slopes))))


def reference(points: int) -> list[dict[Quantity, mp.mpf]]:
    """All quantities along a turn of the built-in train; the poses of its matrix are five of that turn."""
    with mp.workdps(DIGITS):
        machine = tomllib.loads(DATA.read_text(encoding="utf-8"))
        curve, dyad = _curve(machine), _dyad(machine)
        speed = mp.mpf(machine["train"]["carrier_speed_rpm"]) * mp.pi / 30
        start = mp.mpf(float(curve(0)))
        shared = {
            **dyad, q.w1: speed, q.a: mp.mpf(machine["train"]["centre_distance_mm"]) * MM,
            q.mean_root: mean_root(curve), q.n_pairs: complex_pairs(pose_rows(machine)), q.y_first: start,
            q.y_last: start + mp.mpf(sp.N(train.rise(), DIGITS)),
        }  # fmt: skip

        def at(turned: mp.mpf) -> Point:
            angle, rate = (mp.mpf(float(curve(float(turned), order))) for order in (0, 1))
            return {q.theta: turned, q.phi: angle, q.w2: speed * rate}

        rows = [row({**dyad, **at(2 * mp.pi * k / 5)}) for k in range(5)]
        shared |= null_space(rows) | {z: rows[1][z] for z in q.MAPPED_J}
        shared |= _multiples(completed({**shared, **at(mp.mpf(0))}))
        return [completed({**shared, **at(2 * mp.pi * k / points)}) for k in range(points)]


def _multiples(point: Point) -> Point:
    """Multiples of the basis that make up the coefficients of the dyad."""
    basis = mp.matrix([[point[component] for component in vector] for vector in q.BASIS]).T
    found = mp.lu_solve(basis, mp.matrix([point[p] for p in q.COEFFICIENTS]))
    return dict(zip(q.PARAMETERS, found, strict=True))
