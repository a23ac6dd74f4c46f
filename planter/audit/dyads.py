"""Five poses of a body: kinematic map, null space, and the dyads (points that stay on a circle) with their centres.

Ravani and Roth, Motion synthesis using kinematic mappings, 1983; Ge, Zhao, Purwar and others, 2013 (linear form).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.audit.registry import Inputs, Value, formula
from planter.kernels import Array

POSES = 5
_REAL = 1e-7
"""A root is real below this share of imaginary part; double roots keep half the digits."""


@dataclass(frozen=True)
class Dyad:
    """A point of the moving body, the centre of its circle and the radius [mm]."""

    point: Array
    centre: Array
    radius: float


def image(pose: Array) -> Array:
    """Kinematic image Z (4,) of a pose (x [mm], y [mm], angle [deg])."""
    x, y, half = pose[0], pose[1], np.radians(pose[2]) / 2
    s, c = np.sin(half), np.cos(half)
    return np.array([(x * s - y * c) / 2, (x * c + y * s) / 2, s, c])


def conditions(images: Array) -> Array:
    """Rows (n, 8) of the linear form of the circle condition, for images (n, 4)."""
    z1, z2, z3, z4 = images.T
    return np.column_stack([
        z1**2 + z2**2, z1 * z3 - z2 * z4, z2 * z3 + z1 * z4, z1 * z3 + z2 * z4,
        z2 * z3 - z1 * z4, z3 * z4, z3**2 - z4**2, z3**2 + z4**2,
    ])  # fmt: skip


def null_space(images: Array) -> Array:
    """Basis (8, 3) of what solves the conditions, by singular values of rows and columns of one size."""
    rows = conditions(images)
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0] = 1
    basis = np.linalg.svd(rows / scale)[2][POSES:].T / scale[:, None]
    return np.linalg.qr(basis)[0]


def dyads(poses: Array) -> list[Dyad]:
    """The real dyads of five poses (5, 3), by radius."""
    basis = null_space(np.array([image(pose) for pose in poses]))
    solutions = common_points(*(basis.T @ q @ basis for q in _quadrics()))
    return sorted((_dyad(basis @ u) for u in solutions), key=lambda dyad: dyad.radius)


def placed(point: Array, pose: Array) -> Array:
    """Place (2,) of a point of the body (2,) in a pose (x [mm], y [mm], angle [deg])."""
    turn = np.radians(pose[2])
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s], [s, c]]) @ point + np.asarray(pose[:2])


def _quadrics() -> tuple[Array, Array]:
    """The two conditions that make a vector p that of a dyad: p1 p6 + p2 p5 - p3 p4, 2 p1 p7 - p2 p4 - p3 p5."""
    first, second = np.zeros((8, 8)), np.zeros((8, 8))
    for matrix, i, j, factor in (
        (first, 0, 5, 1.0), (first, 1, 4, 1.0), (first, 2, 3, -1.0),
        (second, 0, 6, 2.0), (second, 1, 3, -1.0), (second, 2, 4, -1.0),
    ):  # fmt: skip
        matrix[i, j] = matrix[j, i] = factor / 2
    return first, second


def common_points(first: Array, second: Array) -> list[Array]:
    """Real points u (3,) in the projective plane on both conics u^T Q u = 0, Q (3, 3).

    The eliminant of u2 is a quartic in u1 for u3 = 1; its roots are the eigenvalues of its companion matrix. The plane
    is turned first, so that no point lies at infinity.
    """
    turn = np.linalg.qr(np.array([[1.0, 0.3, -0.7], [0.2, 1.0, 0.5], [0.6, -0.4, 1.0]]))[0]
    q1, q2 = (turn.T @ q @ turn / np.linalg.norm(q) for q in (first, second))
    found = [_lifted(q1, q2, root.real) for root in np.roots(_eliminant(q1, q2)) if _is_real(root)]
    return [turn @ u for u in found]


def _is_real(root: complex) -> bool:
    return abs(root.imag) <= _REAL * (1 + abs(root))


def _in_second(q: Array) -> tuple[Array, Array, Array]:
    """Coefficients of u2^2, u2 and 1 in a conic, as polynomials in u1."""
    return np.array([q[1, 1]]), 2 * np.array([q[0, 1], q[1, 2]]), np.array([q[0, 0], 2 * q[0, 2], q[2, 2]])


def _eliminant(q1: Array, q2: Array) -> Array:
    """Resultant of two conics with respect to u2: (a1 c2 - a2 c1)^2 - (a1 b2 - a2 b1)(b1 c2 - b2 c1)."""
    (a1, b1, c1), (a2, b2, c2) = _in_second(q1), _in_second(q2)
    mixed = np.polysub(np.polymul(a1, c2), np.polymul(a2, c1))
    leading = np.polysub(np.polymul(a1, b2), np.polymul(a2, b1))
    last = np.polysub(np.polymul(b1, c2), np.polymul(b2, c1))
    return np.polysub(np.polymul(mixed, mixed), np.polymul(leading, last))


def _lifted(q1: Array, q2: Array, u1: float) -> Array:
    """The common point over a root u1: u2 from the combination without u2^2, then Newton steps."""
    (a1, b1, c1), (a2, b2, c2) = (tuple(np.polyval(p, u1) for p in _in_second(q)) for q in (q1, q2))
    u = np.array([u1, -(a1 * c2 - a2 * c1) / (a1 * b2 - a2 * b1), 1.0])
    for _ in range(4):
        slopes = 2 * np.array([q1 @ u, q2 @ u])[:, :2]
        u[:2] -= np.linalg.lstsq(slopes, np.array([u @ q1 @ u, u @ q2 @ u]), rcond=None)[0]
    return u


def _dyad(p: Array) -> Dyad:
    """The dyad of a vector p (8,), of any scale."""
    a0 = -p[0]
    point, centre = p[1:3] / a0, p[3:5] / a0
    squared = 4 * p[7] / a0 + point @ point + centre @ centre
    return Dyad(point, centre, float(np.sqrt(squared)))


@formula("kinematic image")
def kinematic_image(inputs: Inputs) -> float:
    """A component of the image of one pose."""
    return float(image(np.asarray(inputs[inputs["pose"]], dtype=float))[inputs["component"] - 1])


@formula("entry of the null space")
def null_space_entry(inputs: Inputs) -> float:
    """An entry p1 to p5 of the vector of the null space that has the printed entries p6 to p8.

    A basis of the null space is anyone's choice; what a vector of it has in three places gives the other five.
    """
    basis = null_space(np.array([image(pose) for pose in _poses(inputs)]))
    weights = np.linalg.solve(basis[5:], np.asarray(inputs[inputs["vector"]], dtype=float))
    return float((basis @ weights)[inputs["entry"] - 1])


@formula("entry of the nearest basis")
def nearest_basis_entry(inputs: Inputs) -> float:
    """An entry of that orthonormal basis of the null space which comes nearest to the printed one.

    All such bases differ by a rotation: three numbers for the printed twenty-four (Schoenemann, Psychometrika, 1966).
    """
    basis = null_space(np.array([image(pose) for pose in _poses(inputs)]))
    names = inputs["vectors"]
    printed = np.array([[*inputs[f"{name}_head"], *inputs[name]] for name in names], dtype=float).T
    left, _, right = np.linalg.svd(basis.T @ printed)
    return float((basis @ left @ right)[inputs["entry"] - 1, names.index(inputs["vector"])])


@formula("real dyads")
def real_dyads(inputs: Inputs) -> float:
    """How many dyads of the five poses are real."""
    return float(len(dyads(_poses(inputs))))


@formula("dyad")
def dyad_part(inputs: Inputs) -> Value:
    """A coordinate of a dyad [mm]; the dyads are counted by radius."""
    dyad = _chosen(inputs)
    return None if dyad is None else _part(dyad, inputs["part"])


@formula("circle coefficient")
def circle_coefficient(inputs: Inputs) -> Value:
    """A coefficient of a0 (X^2 + Y^2) = 2 a1 X + 2 a2 Y + a3, at the scale of a printed one of them."""
    dyad = _chosen(inputs)
    if dyad is None:
        return None
    x, y = dyad.centre
    unit = {"a0": 1.0, "a1": float(x), "a2": float(y), "a3": float(dyad.radius**2 - x**2 - y**2)}
    return unit[inputs["coefficient"]] * float(inputs["scale"]) / unit[inputs["scale_of"]]


@formula("moving hinge")
def moving_hinge(inputs: Inputs) -> Value:
    """Coordinate of a dyad's moving hinge in one of the poses [mm]."""
    dyad = _chosen(inputs)
    return None if dyad is None else float(placed(dyad.point, inputs[inputs["pose"]])[inputs["axis"] - 1])


@formula("distance of a point")
def distance(inputs: Inputs) -> float:
    """Distance of a printed point of the body from its origin [mm]."""
    return float(np.linalg.norm(np.asarray(inputs[inputs["point"]], dtype=float)))


def _poses(inputs: Inputs) -> Array:
    return np.array([inputs[name] for name in inputs[inputs["poses"]]], dtype=float)


def _chosen(inputs: Inputs) -> Dyad | None:
    found = dyads(_poses(inputs))
    number = inputs["dyad"]
    return found[number - 1] if number <= len(found) else None


def _part(dyad: Dyad, part: str) -> float:
    values = (*dyad.point, *dyad.centre, dyad.radius)
    return float(dict(zip(("x", "y", "X", "Y", "r"), values, strict=True))[part])
