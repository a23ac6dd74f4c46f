"""Five poses of a body: their images, null space and dyads as the patent prints them, with all
lengths in mm.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from planter.audit.registry import MM, Inputs, Value, formula
from planter.files.units import unit_factor
from planter.kernels import Array
from planter.papers.mapping import model
from planter.papers.mapping.dyads import Dyad, Solution, null_space, solve_dyads

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
