"""Printed numbers of the patent on kinematic mapping: poses with all lengths in mm, their null space
and dyads, the four-bar linkage of the two smallest dyads, the split of the ratio."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from planter.audit.registry import MM, Inputs, Value, formula
from planter.files.units import unit_factor
from planter.kernels import Array
from planter.papers.mapping import model
from planter.papers.mapping.curve import closed_turn
from planter.papers.mapping.dyads import Dyad, Solution, null_space, solve_dyads
from planter.papers.mapping.linkage import FourBar, reversals, standings
from planter.papers.mapping.synthesis import is_outside
from planter.papers.mapping.train import Train

LENGTHS = np.array([2, 1, 1, 1, 1, 0, 0, 0])
"""Number of lengths that are multiplied in each column of the linear system: entries in mm follow
from those in m.
"""
_POSE = np.array([MM, MM, unit_factor("phi_deg")])


def poses(inputs: Inputs) -> Array:
    """The poses (n, 3) that the paper calls so [m, m, rad]."""
    return np.array([inputs[name] for name in inputs[inputs["poses"]]]) * _POSE


def solve_poses(inputs: Inputs) -> Solution:
    """All dyads of the poses; many numbers of a paper are those of the same ones."""
    return _solved(tuple(map(tuple, poses(inputs).tolist())))


@lru_cache
def _solved(rows: tuple[tuple[float, ...], ...]) -> Solution:
    return solve_dyads(np.array(rows))


def choose_dyad(inputs: Inputs) -> Dyad | None:
    """Return the dyad of a number, counted by radius, or None if there are fewer."""
    dyads = solve_poses(inputs).dyads
    number = inputs["dyad"]
    return dyads[number - 1] if number <= len(dyads) else None


@formula("kinematic image")
def kinematic_image(inputs: Inputs) -> float:
    """A component of the image of one pose: Z1 and Z2 [mm], Z3 and Z4."""
    number = inputs["component"]
    entry = model.image(_pose(inputs))[0, number - 1]
    return float(entry / MM if number <= 2 else entry)


@formula("entry of the null space")
def null_space_entry(inputs: Inputs) -> float:
    """An entry p1 to p5 of the vector of the null space that has the printed entries p6 to p8.

    A basis of the null space is anyone's choice; what a vector of it has in three places gives the
    other five.
    """
    basis = _basis(inputs)
    weights = np.linalg.solve(basis[5:], np.asarray(inputs[inputs["vector"]], dtype=float))
    return float((basis @ weights)[inputs["entry"] - 1])


@formula("entry of the nearest basis")
def nearest_basis_entry(inputs: Inputs) -> float:
    """An entry of that orthonormal basis of the null space which comes nearest to the printed one.

    All such bases differ by a rotation: three numbers for the printed twenty-four (Schoenemann,
    Psychometrika, 1966).
    """
    basis = np.linalg.qr(_basis(inputs))[0]
    names = inputs["vectors"]
    printed = np.array([[*inputs[f"{name}_head"], *inputs[name]] for name in names], dtype=float).T
    left, _, right = np.linalg.svd(basis.T @ printed)
    return float((basis @ left @ right)[inputs["entry"] - 1, names.index(inputs["vector"])])


@formula("eigenvalues that vanish")
def vanishing_eigenvalues(inputs: Inputs) -> float:
    """Return the number of zero eigenvalues of A^T A: columns of A less its rank."""
    return float(null_space(poses(inputs))[0].shape[1])


@formula("real dyads")
def real_dyads(inputs: Inputs) -> float:
    """Return the number of real dyads of the five poses."""
    return float(len(solve_poses(inputs).dyads))


@formula("dyad")
def dyad_part(inputs: Inputs) -> Value:
    """A coordinate of a dyad [mm]."""
    dyad = choose_dyad(inputs)
    return None if dyad is None else _to_numbers(dyad)[inputs["part"]]


@formula("circle coefficient")
def circle_coefficient(inputs: Inputs) -> Value:
    """A coefficient of a0 (X^2 + Y^2) = 2 a1 X + 2 a2 Y + a3, at the scale of a printed one of
    them.
    """
    dyad = choose_dyad(inputs)
    if dyad is None:
        return None
    part = _to_numbers(dyad)
    unit = {
        "a0": 1.0,
        "a1": part["X"],
        "a2": part["Y"],
        "a3": part["r"] ** 2 - part["X"] ** 2 - part["Y"] ** 2,
    }
    return unit[inputs["coefficient"]] * float(inputs["scale"]) / unit[inputs["scale_of"]]


@formula("moving hinge")
def moving_hinge(inputs: Inputs) -> Value:
    """Coordinate of a dyad's moving hinge in one of the poses [mm]."""
    dyad = choose_dyad(inputs)
    if dyad is None:
        return None
    return float(model.place_point(_pose(inputs), dyad.point)[0, inputs["axis"] - 1] / MM)


@formula("distance of a point")
def distance(inputs: Inputs) -> float:
    """Distance of a printed point of the body from its origin [mm]."""
    return float(np.linalg.norm(np.asarray(inputs[inputs["point"]], dtype=float)))


def _pose(inputs: Inputs) -> Array:
    return np.atleast_2d(inputs[inputs["pose"]]) * _POSE


def _basis(inputs: Inputs) -> Array:
    """Basis (8, 3) of the null space of the linear system of poses in mm."""
    basis = null_space(poses(inputs))[0]
    return np.asarray(basis * MM ** LENGTHS[:, None])


def _to_numbers(dyad: Dyad) -> dict[str, float]:
    """x, y, X, Y and r of a dyad [mm]."""
    return dict(zip(("x", "y", "X", "Y", "r"), (dyad.vector / MM).tolist(), strict=True))


@formula("poses in the assembly of one of them")
def in_assembly(inputs: Inputs) -> Value:
    """Return the number of poses that the linkage passes in the assembly of the first of them."""
    linkage = _linkage(inputs)
    if linkage is None:
        return None
    names: Sequence[str] = inputs[inputs["poses"]]
    by_name = dict(zip(names, standings(linkage, poses(inputs)), strict=True))
    counted = [name for name in names if name in inputs["counted"]]
    return float(sum(by_name[name].assembly == by_name[counted[0]].assembly for name in counted))


@formula("driver is a crank")
def is_crank(inputs: Inputs) -> Value:
    """1 if the shorter dyad turns fully, else 0."""
    linkage = _linkage(inputs)
    return None if linkage is None else float(linkage.turns_round)


@formula("largest reversal between neighbouring poses")
def largest_reversal(inputs: Inputs) -> Value:
    """Largest rotation by which the arm must turn back relative to the carrier between two poses
    [deg]; 0 if none.

    A carrier that turns once passes the poses in the order of their crank angles.
    """
    linkage = _linkage(inputs)
    if linkage is None:
        return None
    where = poses(inputs)
    crank = np.radians([standing.crank_angle_deg for standing in standings(linkage, where)])
    return max((r.deg for r in reversals(crank, where[:, 2])), default=0.0)


@formula("distance of a hinge outside the poses")
def outside_distance(inputs: Inputs) -> Value:
    """Distance of a dyad's fixed hinge from the polygon through the poses' points [mm]; negative
    inside.
    """
    dyad = choose_dyad(inputs)
    return None if dyad is None else _distance(poses(inputs)[:, :2], dyad.centre) / MM


def _distance(corners: Array, point: Array) -> float:
    """Signed distance of a point (2,) from a closed polygon (n, 2), positive outside."""
    frame = np.roll(corners, -1, axis=0) - corners
    share = np.clip(((point - corners) * frame).sum(1) / (frame**2).sum(1), 0, 1)
    away = float(np.linalg.norm(corners + share[:, None] * frame - point, axis=1).min())
    return away if is_outside(point, corners) else -away


def _linkage(inputs: Inputs) -> FourBar | None:
    dyads = solve_poses(inputs).dyads
    return FourBar(dyads[0], dyads[1]) if len(dyads) > 1 else None


@formula("split of the ratio")
def split_parameter(inputs: Inputs) -> Value:
    """Parameter that closes the first of two stages of a ratio: the mean of its inverse root over a
    turn.

    None where the curve is not monotone. The centre distance has no part in it.
    """
    curve = closed_turn(inputs.si("carrier_deg")[:-1], inputs.si("relative_deg")[:-1])
    return Train(curve, distance=1.0).x_s if curve.monotone else None
