"""Equations of motion of one side of the planting device by Lagrange's method, with virtual power
for every force.

Every constraint whose force is asked for is released into a coordinate: both gears turn freely, the
halves swing freely, both shafts may leave their bearings, and the whole device may shift. No force
balance is written anywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

Number = Any
Objects = NDArray[np.object_]
COORDINATES = phi, phi52, phi72, theta1, x_A1, y_A1, x_B1, y_B1, X, Y = sp.symbols(
    "phi phi52 phi72 theta1 x_A1 y_A1 x_B1 y_B1 X Y", real=True
)
RATES = sp.symbols([f"{q}_dot" for q in COORDINATES], real=True)
ACCELERATIONS = sp.symbols([f"{q}_ddot" for q in COORDINATES], real=True)
GEOMETRY = a1, a2, gamma, theta, x_A, y_A, z_A = sp.symbols(
    "a1 a2 gamma theta x_A y_A z_A", real=True
)
LOCAL = sp.symbols("x y z", real=True)
MASS = mass, gravity, *MOMENTS = sp.symbols("m g I_x I_y I_z", real=True)
RELEASED = [COORDINATES.index(q) for q in (phi52, phi72, theta1, x_A1, y_A1, x_B1, y_B1)]
WHOLE = {
    name: COORDINATES.index(q) for name, q in (("M_L", phi), ("F_support_x", X), ("F_support", Y))
}
NAMES = ("sun", "carrier", "middle", "planet", "inner", "outer")


def _about_z(angle: sp.Expr) -> sp.Matrix:
    return sp.rot_axis3(-angle)


def _about_y(angle: sp.Expr) -> sp.Matrix:
    return sp.rot_axis2(-angle)


def _displace(angle: sp.Expr, length: sp.Expr) -> sp.Matrix:
    return _about_z(angle) * sp.Matrix([length, 0, 0])


def _rate(expr: sp.Matrix | sp.Expr) -> sp.Matrix | sp.Expr:
    """Time derivative by the chain rule."""
    pairs = (*zip(COORDINATES, RATES, strict=True), *zip(RATES, ACCELERATIONS, strict=True))
    return sum(
        (expr.diff(q) * rate for q, rate in pairs),
        sp.zeros(*expr.shape) if hasattr(expr, "shape") else 0,
    )


@dataclass(frozen=True)
class Body:
    """A rigid body as a function of the coordinates: where its frame's origin is and how it is
    turned.
    """

    name: str

    @cached_property
    def placed(self) -> tuple[sp.Matrix, sp.Matrix]:
        shift = sp.Matrix([X, Y, 0])
        A1 = shift + _displace(phi + sp.pi / 2, a1)
        B1 = A1 + _displace(phi + sp.pi / 2 + gamma, a2) + sp.Matrix([x_B1, y_B1, 0])
        planet = _about_z(phi + phi72 + theta - sp.pi)
        if self.name in ("inner", "outer"):
            side = 1 if self.name == "inner" else -1
            return B1 + planet * sp.Matrix([x_A, y_A, side * z_A]), planet * _about_y(side * theta1)
        return {
            "sun": (shift, sp.eye(3)),
            "carrier": (shift, _about_z(phi)),
            "planet": (B1, planet),
            "middle": (A1 + sp.Matrix([x_A1, y_A1, 0]), _about_z(phi + phi52)),
        }[self.name]

    @property
    def point(self) -> sp.Matrix:
        """A point fixed in the body at LOCAL."""
        origin, turned = self.placed
        return origin + turned * sp.Matrix(LOCAL)

    @cached_property
    def jacobian(self) -> Callable[..., Objects]:
        """Displacement of a point of the body per coordinate, (3, coordinates)."""
        return _compiled(self.point.jacobian(COORDINATES))

    @cached_property
    def frame(self) -> Callable[..., Objects]:
        """Origin and rotation as columns, (3, 4)."""
        return _compiled(sp.Matrix.hstack(*self.placed))

    @cached_property
    def inertia(self) -> Callable[..., Objects]:
        """d/dt dT/dq' - dT/dq + dV/dq of a part of the body, (coordinates, 1)."""
        velocity, turned = _rate(self.point), self.placed[1]
        skew = turned.T * _rate(turned)
        spin = (skew[2, 1], skew[0, 2], skew[1, 0])
        kinetic = (
            mass * velocity.dot(velocity) / 2
            + sum(i * w**2 for i, w in zip(MOMENTS, spin, strict=True)) / 2
        )
        potential = mass * gravity * self.point[1]
        rows = [
            _rate(sp.diff(kinetic, rate)) - sp.diff(kinetic - potential, q)
            for q, rate in zip(COORDINATES, RATES, strict=True)
        ]
        return _compiled(sp.Matrix(rows))


def _compiled(expr: sp.Matrix) -> Callable[..., Objects]:
    """An evaluator at the device itself, where nothing has left its place."""
    free = (x_A1, y_A1, x_B1, y_B1, X, Y)
    indices = [COORDINATES.index(q) for q in free]
    rest = {symbol[i]: 0 for i in indices for symbol in (COORDINATES, RATES, ACCELERATIONS)}
    arguments = (COORDINATES[:4], RATES[:4], ACCELERATIONS[:4], GEOMETRY, LOCAL, MASS)
    f = sp.lambdify(arguments, expr.xreplace(rest), modules="mpmath", cse=True)
    return lambda *values: np.array(f(*values).tolist(), dtype=object)


@cache
def body(name: str) -> Body:
    return Body(name)


@dataclass(frozen=True)
class State:
    """Coordinates, rates, accelerations and lengths of one side at an instant."""

    coordinates: Sequence[Number]
    rates: Sequence[Number]
    accelerations: Sequence[Number]
    geometry: Sequence[Number]

    def _at(self, local: Sequence[Number]) -> tuple[Sequence[Number], ...]:
        return self.coordinates, self.rates, self.accelerations, self.geometry, local

    def inertia(self, name: str, local: Sequence[Number], part: Sequence[Number]) -> Objects:
        """Generalised inertia forces and weight of a part (m, g, I_x, I_y, I_z) with its centroid
        at `local`.
        """
        return body(name).inertia(*self._at(local), part)[:, 0]

    def frame(self, name: str) -> tuple[Objects, Objects]:
        frame = body(name).frame(*self._at((0, 0, 0)), (0,) * 5)
        return frame[:, 0], frame[:, 1:]

    def power(self, on: str, by: str, at: Objects, direction: Objects) -> Objects:
        """Virtual power of a pair of forces between two bodies, per coordinate, at a point of the
        global frame.
        """
        terms = []
        for name in (on, by):
            origin, turned = self.frame(name)
            terms.append(body(name).jacobian(*self._at(turned.T @ (at - origin)), (0,) * 5))
        return direction @ (terms[0] - terms[1])
