"""The derived formulas of the mapping as functions of arrays, each a generated kernel behind its
strict call.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from planter.kernels import Array, Kernel
from planter.kernels.formulas import load

MODEL = "mapping_exact"
"""The generated formulas of the mapping."""


def _evaluate(stage: str, **inputs: object) -> Array:
    """Return the outputs of a stage as rows (k, n)."""
    return np.array([*load(MODEL)(stage, **inputs).values()])


@cache
def _build_slopes(stage: str, lanes: tuple[str, ...], variables: tuple[str, ...]) -> Kernel:
    """Return a stage with its Jacobians in some inputs as further outputs."""
    function = load(MODEL).function(stage)
    outputs = [f"{stage}_out", *(f"jac:{stage}_out:{name}" for name in variables)]
    return Kernel(function.factory(stage, function.name_in(), outputs), lanes=lanes)


def image(poses: Array) -> Array:
    """Mapping parameters Z (n, 4) of poses (n, 3): x, y [m], angle [rad]."""
    return _evaluate("image", pose=poses.T).T


def rows(poses: Array) -> Array:
    """Rows (n, 8) of the linear system (4) of sun2019 for poses (n, 3)."""
    return _evaluate("row", image=image(poses).T).T


def conics(basis: Array) -> tuple[Array, Array]:
    """Symmetric matrices (3, 3) of the conditions (8), (9) of sun2019 on a basis (8, 3) of the null
    space.
    """
    first, second, third = basis.T
    entries = _evaluate("conics", v_alpha=first, v_beta=second, v_gamma=third)[:, 0]
    return _symmetric(entries[:6]), _symmetric(entries[6:])


def _symmetric(k: Array) -> Array:
    """The matrix of k0 a^2 + k1 b^2 + k2 a b + k3 a c + k4 b c + k5 c^2."""
    half = k / 2
    return np.array([[k[0], half[2], half[3]], [half[2], k[1], half[4]], [half[3], half[4], k[5]]])


def place_dyad(kind: str, p: Array) -> Array:
    """Return the hinges of a vector (8,) of the null space, by its kind.

    "dyad": moving hinge x, y and fixed hinge X, Y (4,), for a first entry that is not zero.
    "slider": moving hinge x, y, normal and offset (5,) of its line in the fixed frame, for a0 = 0.
    "swinging": fixed hinge X, Y, normal and offset (5,) of the body's line through it, for a0 = a1
    = a2 = 0.
    """
    return _evaluate(kind, coefficients=p)[:, 0]


def place_point(poses: Array, point: Array) -> Array:
    """Places (n, 2) of a point of the body (2,) in poses (n, 3)."""
    return _evaluate("hinge", pose=poses.T, point=point).T


def squares(poses: Array, dyad: Array) -> tuple[Array, Array]:
    """Distance of the hinges squared less the radius squared (n,), and its derivatives (n, 5) in x,
    y, X, Y, radius.
    """
    outputs = _build_slopes("distance", ("pose",), ("dyad",))(pose=poses.T, dyad=dyad)
    return outputs["distance_out"][0], outputs["jac_distance_out_dyad"].reshape(len(poses), 5)


def arm(theta: Array, phi: Array, dyad: Array) -> Array:
    """Tip x, y and moving hinge X, Y (4, n) for angles of carrier and arm (n,) on a dyad (5,)."""
    return _evaluate("arm", theta=theta, phi=phi, crank=dyad)


def arm_slopes(theta: Array, phi: Array, dyad: Array) -> tuple[Array, Array, Array]:
    """Return the values of `arm`, and the derivatives (4, n) in the angle of the carrier and in
    that of the arm.
    """
    outputs = _build_slopes("arm", ("theta", "phi"), ("theta", "phi"))(
        theta=theta, phi=phi, crank=dyad
    )
    return outputs["arm_out"], outputs["jac_arm_out_theta"], outputs["jac_arm_out_phi"]


def loop(theta: Array, crank: Array, follower: Array) -> Array:
    """A, B, C (3, n) of the closed loop A cos(phi) + B sin(phi) + C = 0 of two dyads (5,) at crank
    angles (n,).
    """
    return _evaluate("loop", theta=theta, crank=crank, follower=follower)


def evaluate_closure(theta: Array, phi: Array, crank: Array, follower: Array) -> Array:
    """The closure and its derivatives in crank and arm angle (3, n)."""
    return _evaluate("closed", theta=theta, phi=phi, crank=crank, follower=follower)


def transmission(theta: Array, phi: Array, crank: Array, follower: Array) -> Array:
    """Angle (n,) [rad] between coupler and follower, in [0, pi]."""
    across, axial = _evaluate("transmission", theta=theta, phi=phi, crank=crank, follower=follower)
    return np.arctan2(np.abs(across), axial)


def gears(slope: Array, x_s: float, distance: float) -> dict[str, Array]:
    """Ratios, pitch radii and rates of the polar angles (n,) by their names, for positive slopes
    (n,).
    """
    return load(MODEL)("gears", slope=-slope, x_s=x_s, a=distance)


def curvature(slope: Array, dslope: Array, ddslope: Array, x_s: float, distance: float) -> Array:
    """Curvatures (4, n) [1/m] of the pitch curves, positive where convex; slopes as in `gears`, and
    derivatives.
    """
    return _evaluate(
        "curvature", slope=-slope, dslope=-dslope, ddslope=-ddslope, x_s=x_s, a=distance
    )


def bend(crank: float, distance: float) -> float:
    """Angle at the middle hinge [rad] of a carrier with the length `crank` between its end
    hinges.
    """
    return load(MODEL).at("bend", L1=crank, a=distance)["bend"]
