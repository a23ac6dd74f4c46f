"""Linear models of mechanisms that move freely: A, B, C, D, and the same without the constraints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from planter.kernels import Array
from planter.mechanism.dynamics import RANK
from planter.mechanism.motion import equilibrium
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.mechanism.state_space.results import (
    ConstraintResult,
    LinearModelResult,
    MinimalForm,
    VariableResult,
)


def linearise_model(model: DynamicsModel, at_rest: bool = False) -> LinearModelResult:
    """Return the linear model at the start, or `at_rest` at the equilibrium nearest to it.

    Raises ComputationError if no equilibrium is nearby.
    """
    state = equilibrium(model.dynamics, model.start) if at_rest else model.start
    a, b, _ = model.linearised(0.0, state)
    c, d, _ = model.linearised_outputs(0.0, state)
    basis, chosen = find_basis(model, state)
    back = np.linalg.pinv(basis)
    minimal = back @ a @ basis
    roots = scipy.linalg.eigvals(minimal)
    roots = roots[np.lexsort((-roots.imag, -roots.real))]
    outputs = model.outputs_at(0.0, state)
    return LinearModelResult(
        machine=model.name,
        at="rest" if at_rest else "start",
        state=_describe(model.states, state),
        inputs=_describe(model.inputs, model.u),
        outputs=_describe(model.outputs, outputs),
        A=a.tolist(),
        B=b.tolist(),
        C=c.tolist(),
        D=d.tolist(),
        eigenvalues=[(float(root.real), float(root.imag)) for root in roots],
        constraints=ConstraintResult(model.constraints, model.left_out, model.pivot(0.0, state)),
        basis=basis.tolist(),
        minimal=MinimalForm(
            [model.states[index].name for index in chosen],
            minimal.tolist(),
            (back @ b).tolist(),
            (c @ basis).tolist(),
        ),
        drift=float(np.abs(model.rates(0.0, state)).max()),
    )


def find_basis(model: DynamicsModel, state: Array) -> tuple[Array, list[int]]:
    """Return changes of the state (2k, n) that keep the constraints, as columns, and the states
    (n,) of which each column changes one by one.
    """
    slopes = model.constraint_slopes(0.0, state)
    null = scipy.linalg.null_space(slopes, RANK) if len(slopes) else np.eye(len(state))
    _, _, order = scipy.linalg.qr(null.T, mode="economic", pivoting=True)
    chosen = np.sort(order[: null.shape[1]])
    basis = null @ np.linalg.inv(null[chosen])
    basis[chosen] = np.eye(len(chosen))
    return basis, chosen.tolist()


def _describe(variables: Sequence[DynamicsVariable], values: Array) -> list[VariableResult]:
    return [
        VariableResult(variable.name, variable.unit, variable.meaning, float(value))
        for variable, value in zip(variables, values, strict=True)
    ]
