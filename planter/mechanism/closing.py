"""Closed loops as a function of CasADi's: Newton's method from angle to angle, a fixed number of steps at each."""

from __future__ import annotations

import casadi as ca

from planter.kernels.formulas import Formulas

STEPS = 8
"""Of Newton's method at an angle, from where the angle before has led."""
STARTS = 6
"""How many times as many at the first."""


def closed(model: Formulas, name: str, angles: int) -> ca.Function:
    """(angles (n,), data) -> loops (n, k), open (n,), sense (n,).

    `loops` are the coordinates, `open` is what the next step would change, in parts of their size, and `sense` the
    Jacobian's determinant: where that changes its sign the walk has come into another assembly.
    """
    closure, assembly = model.function("closure"), model.function("assembly")
    at = _at(closure, assembly.numel_out(0))
    phi, data = ca.MX.sym("angles", angles), ca.MX.sym("data", closure.numel_in(1))
    start = assembly(data)
    for _ in range(STARTS):
        start = at(start, phi[0], data)[0]
    walk = at.mapaccum("walk", angles, [0], [0])
    found, left, sense = walk(start, phi.T, ca.repmat(data, 1, angles))
    return ca.Function(name, [phi, data], [found.T, left.T, sense.T], ["angles", "data"], ["loops", "open", "sense"])


def _at(closure: ca.Function, count: int) -> ca.Function:
    """(loops (k,), angle, data) -> those after all steps, what another would change, the determinant."""
    q, phi, data = ca.SX.sym("q", count), ca.SX.sym("phi"), ca.SX.sym("data", closure.numel_in(1))
    gaps = closure(phi, data, q)
    jacobian = ca.reshape(gaps[count:], count, count).T
    change = -ca.solve(jacobian, gaps[:count])
    left = ca.mmax(ca.fabs(change) / (1 + ca.fabs(q)))
    step = ca.Function("step", [q, phi, data], [q + change, left, ca.det(jacobian)])
    found, angle, known = ca.MX.sym("q", count), ca.MX.sym("phi"), ca.MX.sym("data", closure.numel_in(1))
    at = found
    for _ in range(STEPS):
        at = step(at, angle, known)[0]
    return ca.Function("at", [found, angle, known], [at, *step(at, angle, known)[1:]])
