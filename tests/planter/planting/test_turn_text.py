"""The turn in C is the one in Python: `turn.c` on forces and slopes that are given, and tampered ones are seen."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest

from planter.kernels import Array, toolchain
from planter.optimise.spread import Weighed, Weights
from planter.planting.turns import FIELDS, _Turn, turn_text
from tests.support.lanes import needs_compiler

pytestmark = [pytest.mark.usefixtures("kernel_cache"), needs_compiler]

ANGLES, SHARES, PARAMETERS = 24, 2, 3
WEIGHTS = (Weights(0.75, 0.25, "paper"), Weights(2.0, 3.0, "newton"))
GIVEN = """
int prologue(const double **arg, double **res, casadi_int *iw, double *w, int mem) { return 0; }
int tangent(const double **arg, double **res, casadi_int *iw, double *w, int mem) { return 0; }
void rows(long lanes, const double *phi, const double *d, const double *h, double *force)
{ memcpy(force, d + 3, lanes * sizeof *force); }
void slopes(long lanes, const double *phi, const double *d, const double *h, const double *dh, double *force,
            double *g)
{ memcpy(force, d + 3, lanes * sizeof *force); memcpy(g, d + 3 + lanes, 4 * lanes * sizeof *g); }
"""
"""Kernels whose lanes are the machine's data: forces, then rows of slopes in (phi, x)."""
TAMPERED = {
    "no mean": ("rate * (t->force[i] - f->mean)", "rate * t->force[i]"),
    "no range": ("t->weights[low] -= t->weight_range;", ""),
    "half the rate": ("const double rate = 2.0 *", "const double rate ="),
    "first sample never the highest": ("long high = 0, low = 0;", "long high = 1, low = 0;"),
    "one share": ("i < lanes; ++i) sum += t->weights", "i < t->angles; ++i) sum += t->weights"),
    "variance of a sample": ("squares / t->angles", "squares / (t->angles - 1)"),
}  # fmt: skip


def by_c(path: Path, weights: Weights, force: Array, slopes: Array) -> tuple[Array, Array]:
    """`FIELDS` and the gradient (p,) that a library makes of lanes (shares, n) and (1 + p, shares, n)."""
    (run,) = toolchain.functions(path, "turn_gradient")
    arrays = {name: np.zeros(8 * force.size) for name in ("phi", "d", "h", "dh", "force", "g", "weights", "arg", "res")}
    arrays["c"] = np.concatenate([force.ravel(), slopes.ravel()])
    turn = _Turn(
        parameters=PARAMETERS, constants=len(arrays["c"]), angles=ANGLES, shares=SHARES,
        weight_range=weights.weight_range, weight_variance=weights.weight_variance,
        newton=int(weights.kind == "newton"), iw=0, w=0,
        **{name: array.ctypes.data for name, array in arrays.items()},
    )  # fmt: skip
    x, found, gradient = np.zeros(PARAMETERS), np.zeros(len(FIELDS)), np.zeros(PARAMETERS)
    pointers = (ctypes.c_void_p(a.ctypes.data) for a in (x, found, gradient))
    assert run(ctypes.byref(turn), *pointers) == 0
    return found, gradient


def lanes() -> tuple[Array, Array]:
    """Shares whose sum is largest at the first sample."""
    rng = np.random.default_rng(2)
    force, slopes = rng.normal(size=(SHARES, ANGLES)), rng.normal(size=(1 + PARAMETERS, SHARES, ANGLES))
    force[0, 0] += 9.0
    return force, slopes


def apart(path: Path, weights: Weights) -> float:
    """Largest difference of the library from Python, relative to the largest entry."""
    force, slopes = lanes()
    turn = Weighed(weights, force.sum(axis=0))
    expected = np.array([turn.value, turn.range, turn.variance.value, turn.variance.mean])
    gradient = turn.gradient(slopes[1:].sum(axis=1).T)
    found, along = by_c(path, weights, force, slopes)
    relative = [np.abs(a - b).max() / np.abs(b).max() for a, b in ((found, expected), (along, gradient))]
    return max(relative)


def library(text: str) -> Path:
    return toolchain.library("turn", text + GIVEN, toolchain.loop_flags(toolchain.OPTIMISED))


def test_value_and_gradient() -> None:
    path = library(turn_text())
    assert max(apart(path, weights) for weights in WEIGHTS) <= 1e-12


@pytest.mark.parametrize("what", TAMPERED)
def test_a_tampered_text_is_seen(what: str) -> None:
    old, new = TAMPERED[what]
    text = turn_text()
    assert text.count(old) == 1
    path = library(text.replace(old, new))
    assert max(apart(path, weights) for weights in WEIGHTS) > 1e-4
