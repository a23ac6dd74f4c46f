"""The vertical force on the support over a turn, with exact derivatives.

Where the frame adds up what two equal sides do, the force is F(phi) = S(phi) + S(phi - pi), S the share of a side, and
each angle is two lanes of S. Derivatives cross the prologue's cut as inputs: along the design, h moves by its tangent
`dh`, so that no lane is differentiated by the coefficients of a series.
"""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.planting.functions import Functions, Prologue

FORCE = "F_support"


class Shares:
    """The force as a sum of equal shares: F(phi) is the sum of `share` at phi + each of `offsets` [rad]."""

    def __init__(self, functions: Functions) -> None:
        self.functions = functions
        share = share_of(functions, FORCE)
        self.offsets: tuple[float, ...] = (0.0,) if share is None else (0.0, -np.pi)
        self.share = functions.total(FORCE) if share is None else share

    @cached_property
    def tangent(self) -> ca.Sparsity:
        """Where the Jacobian of h in the design can be other than zero."""
        return self.functions.tangent_function.sparsity_out(1)

    @cached_property
    def dh(self) -> ca.SX:
        """The entries of that Jacobian, (entries,)."""
        return ca.SX.sym("dh", self.tangent.nnz())

    @cached_property
    def gradient(self) -> ca.SX:
        """Of the share in (phi, x), h moving along, (1 + p,)."""
        phi, x, _, h = self.functions.inputs
        along_h = ca.SX(self.tangent, self.dh).T @ ca.gradient(self.share, h)
        return ca.densify(ca.vertcat(ca.gradient(self.share, phi), ca.gradient(self.share, x) + along_h))

    def hessian(self, weight: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Of the weighted share in (phi, x), h moving along its tangent, packed; and the weighted slope in h."""
        phi, x, _, h = self.functions.inputs
        step = ca.SX.sym("step", x.numel())
        moved = ca.substitute(
            self.share, ca.vertcat(x, h), ca.vertcat(x + step, h + ca.SX(self.tangent, self.dh) @ step)
        )
        bent, _ = ca.hessian(weight * moved, ca.vertcat(phi, step))
        packed = ca.vertcat(*(bent[i, j] for i in range(bent.size1()) for j in range(i + 1)))
        slope = weight * ca.gradient(self.share, h)
        return ca.substitute(ca.densify(packed), step, ca.SX.zeros(step.numel())), ca.densify(slope)

    def kernel(self, name: str, outputs: dict[str, ca.SX], *more: str, summed: bool = False) -> Kernel:
        """Outputs over lanes of phi; `more` names further inputs: `dh`, or `weight`, one for each lane."""
        known = {"dh": self.dh, "weight": self.weight}
        names = ["phi", "x", "c", "h", *more]
        inputs = [*self.functions.inputs, *(known[name] for name in more)]
        f = ca.Function(name, inputs, ca.cse(list(outputs.values())), names, list(outputs))
        return Kernel(f, lanes=[name for name in ("phi", "weight") if name in names], summed=summed)

    @cached_property
    def weight(self) -> ca.SX:
        return ca.SX.sym("weight")


def share_of(functions: Functions, total: str) -> ca.SX | None:
    """A side's share of a total at its carrier angle; None where that is no sum of equal shares of two sides."""
    frame = functions.frame_total(total)
    one, two = ca.SX.sym("one", frame.size1_in(0)), ca.SX.sym("two", frame.size1_in(1))
    nothing, c = ca.SX.zeros(one.numel()), functions.c
    mixed = ca.jacobian(ca.gradient(frame(one, two, c), one), two)
    if mixed.nnz() or not _symmetric(frame):
        return None
    return frame(functions.side(functions.phi), nothing, c) - frame(nothing, nothing, c) / 2


def _symmetric(frame: ca.Function) -> bool:
    """Whether a function of both sides stays the same if they are exchanged, at random values."""
    rng = np.random.default_rng(1)
    one, two, c = (rng.uniform(0.5, 1.5, frame.size1_in(i)) for i in range(3))
    there, back = (float(Kernel(frame)(one=a, two=b, c=c)["force"][0, 0]) for a, b in ((one, two), (two, one)))
    return abs(there - back) <= 1e-12 * abs(there)


class Design(Protocol):
    """What the force needs of a device."""

    functions: Functions
    constants: Array

    def prologue_curvature(self, x: Array, weights: Array) -> Array:
        """Hessian (p, p) of weights . h in the design."""


class SupportForce:
    """Kernels of the force [N] at designs and angles [rad]; `at` is the prologue of a design."""

    def __init__(self, device: Design) -> None:
        self.device, self.shares = device, Shares(device.functions)
        self.size = 1 + device.functions.x.numel()
        self._entries = np.array(self.shares.tangent.get_triplet(), dtype=np.int64)

    @cached_property
    def value_kernel(self) -> Kernel:
        return self.shares.kernel("support", {"force": self.shares.share})

    @cached_property
    def slopes_kernel(self) -> Kernel:
        return self.shares.kernel("slopes", {"force": self.shares.share, "g": self.shares.gradient}, "dh")

    @cached_property
    def rate_kernel(self) -> Kernel:
        return self.shares.kernel("rate", {"force": self.shares.share, "first": self._rate})

    @cached_property
    def rates_kernel(self) -> Kernel:
        second = ca.gradient(self._rate, self.shares.functions.phi)
        return self.shares.kernel("rates", {"first": self._rate, "second": second})

    @cached_property
    def _rate(self) -> ca.SX:
        return ca.gradient(self.shares.share, self.shares.functions.phi)

    @cached_property
    def hessian_kernel(self) -> Kernel:
        return self._hessian_kernel(summed=True)

    @cached_property
    def hessian_rows_kernel(self) -> Kernel:
        return self._hessian_kernel(summed=False)

    def _hessian_kernel(self, summed: bool) -> Kernel:
        outputs = dict(zip(("packed", "slope"), self.shares.hessian(self.shares.weight), strict=True))
        return self.shares.kernel("bending" if summed else "bendings", outputs, "dh", "weight", summed=summed)

    def compile(self, refined: bool = False) -> None:
        """Compile what a search calls again and again, over samples or, `refined`, over true extremes and integrals.

        The Hessian takes longest: it is compiled in the background, and not for the few times that a search over true
        extremes needs it.
        """
        if not refined:
            self.hessian_kernel.compile(wait=False)
        kernels = [self.value_kernel, self.slopes_kernel]
        for kernel in (*kernels, self.rate_kernel, self.rates_kernel) if refined else kernels:
            kernel.compile()

    def entries(self, at: Prologue) -> Array:
        """The tangent of h as the kernels take it."""
        found: Array = at.dh[self._entries[0], self._entries[1]]
        return found

    def value(self, at: Prologue, phi: Array) -> Array:
        """The force (n,)."""
        return self._folded(self.value_kernel(**self._inputs(at, phi))["force"])[0]

    def rate(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """The force [N] and its derivative in phi [N/rad], (n,) each."""
        found = self.rate_kernel(**self._inputs(at, phi))
        return self._folded(found["force"])[0], self._folded(found["first"])[0]

    def rates(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """The force's first two derivatives in phi [N/rad, N/rad2], (n,) each."""
        found = self.rates_kernel(**self._inputs(at, phi))
        return self._folded(found["first"])[0], self._folded(found["second"])[0]

    def slopes(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """The force (n,) and its Jacobian in (phi, x), (n, 1 + p)."""
        found = self.slopes_kernel(dh=self.entries(at), **self._inputs(at, phi))
        return self._folded(found["force"])[0], self._folded(found["g"]).T

    def hessian(self, at: Prologue, phi: Array, weights: Array) -> Array:
        """Weighted sum over the angles of the Hessian in (phi, x), (1 + p, 1 + p).

        The first one waits for the compiler: else it would hang on a race which rounding a search goes on with.
        """
        self.hessian_kernel.settle()
        found = self.hessian_kernel(dh=self.entries(at), weight=self._tiled(weights), **self._inputs(at, phi))
        return self._with_prologue(at, found["packed"][:, 0], found["slope"][:, 0])

    def hessians(self, at: Prologue, phi: Array) -> Array:
        """The Hessian in (phi, x) at each angle, (n, 1 + p, 1 + p)."""
        ones = self._tiled(np.ones(len(phi)))
        found = self.hessian_rows_kernel(dh=self.entries(at), weight=ones, **self._inputs(at, phi))
        packed, slopes = self._folded(found["packed"]).T, self._folded(found["slope"]).T
        return np.array([self._with_prologue(at, *pair) for pair in zip(packed, slopes, strict=True)])

    def _inputs(self, at: Prologue, phi: Array) -> dict[str, Array]:
        lanes = np.add.outer(self.shares.offsets, np.asarray(phi, dtype=float)).reshape(1, -1)
        return {"phi": lanes, "x": at.x, "c": at.c, "h": at.h}

    def _tiled(self, weights: Array) -> Array:
        return np.tile(weights, len(self.shares.offsets)).reshape(1, -1)

    def _folded(self, rows: Array) -> Array:
        """Rows over the lanes, (k, shares n), as rows over the angles, (k, n)."""
        folded: Array = rows.reshape(len(rows), len(self.shares.offsets), -1).sum(axis=1)
        return folded

    def _with_prologue(self, at: Prologue, packed: Array, slope: Array) -> Array:
        """The whole Hessian: packed rows unpacked, and the curvature of h along its slope."""
        rows, columns = np.tril_indices(self.size)
        full = np.zeros((self.size, self.size))
        full[rows, columns] = full[columns, rows] = packed
        full[1:, 1:] += self.device.prologue_curvature(at.x, slope)
        return full
