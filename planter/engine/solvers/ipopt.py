"""Interface to IPOPT through CasADi, for nonlinear programmes with exact first and second
derivatives.

CasADi receives the functions (`grad_f`, `jac_g`, `hess_lag`) as callbacks, so that it
differentiates nothing itself. The linear solver is MUMPS, which comes with CasADi.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca
import numpy as np

from planter.kernels import Array

IPOPT_OPTIONS: dict[str, Any] = {
    "print_level": 0,
    "sb": "yes",
    "linear_solver": "mumps",
    "mu_strategy": "adaptive",
    "nlp_scaling_method": "none",
    "bound_relax_factor": 0.0,
    "tol": 1e-10,
    "dual_inf_tol": 1e-9,
    "constr_viol_tol": 1e-10,
    "compl_inf_tol": 1e-10,
    "acceptable_iter": 0,
}

CASADI_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "show_eval_warnings": False,
    "error_on_fail": False,
    "calc_lam_p": False,
    "no_nlp_grad": True,
}
"""Options of CasADi: no output, and no derivatives of its own."""
Shapes = dict[str, ca.Sparsity]
Run = Callable[..., Sequence[Any]]


class NonlinearProgram(Protocol):
    """Minimise f(z) with z in [lower, upper] and g(z) in [g_lower, g_upper]; z is (n,), g (m,)."""

    lower: Array
    upper: Array
    g_lower: Array
    g_upper: Array

    def f(self, z: Array) -> float:
        """Return the objective at z (n,)."""

    def gradient(self, z: Array) -> Array:
        """Return the gradient (n,) of the objective at z (n,)."""

    def g(self, z: Array) -> Array:
        """Return the constraints (m,) at z (n,)."""

    def jacobian(self, z: Array) -> Array:
        """Return the Jacobian (m, n) of g at z (n,)."""

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        """Return the Hessian (n, n) of weight * f + multipliers . g at z (n,)."""


@dataclass(frozen=True)
class IpoptSolution:
    """Last point z (n,) of IPOPT, with the multipliers of the constraints (m,), positive at upper
    bounds.
    """

    z: Array
    multipliers: Array
    converged: bool
    iterations: int


class _Function(ca.Callback):
    """CasADi callback of a Python function, whose exceptions are appended to `failures`."""

    def __init__(
        self, name: str, inputs: Shapes, outputs: Shapes, run: Run, failures: list[BaseException]
    ) -> None:
        ca.Callback.__init__(self)
        self._inputs, self._outputs = list(inputs.items()), list(outputs.items())
        self._run, self._failures = run, failures
        self.construct(name, {})

    def get_n_in(self) -> int:
        return len(self._inputs)

    def get_n_out(self) -> int:
        return len(self._outputs)

    def get_name_in(self, i: int) -> str:
        return self._inputs[i][0]

    def get_name_out(self, i: int) -> str:
        return self._outputs[i][0]

    def get_sparsity_in(self, i: int) -> Any:
        return self._inputs[i][1]

    def get_sparsity_out(self, i: int) -> Any:
        return self._outputs[i][1]

    def eval(self, arguments: Sequence[ca.DM]) -> list[Any]:
        try:
            if self._failures:
                raise self._failures[0]
            return list(self._run(*(np.asarray(a, dtype=float).reshape(-1) for a in arguments)))
        except (
            BaseException
        ) as error:  # CasADi turns any exception into a failed evaluation; `solve` raises it again
            self._failures.append(error)
            return [ca.DM.nan(sparsity) for _, sparsity in self._outputs]


def _build_functions(p: NonlinearProgram, failures: list[BaseException]) -> dict[str, _Function]:
    n, m = len(p.lower), len(p.g_lower)
    dense, upper = ca.Sparsity.dense, ca.Sparsity.upper(n)
    x = {"x": dense(n, 1), "p": ca.Sparsity(0, 0)}
    lam = {"lam_f": dense(1, 1), "lam_g": dense(m, 1)}
    f, g = {"f": dense(1, 1)}, {"g": dense(m, 1)}
    return {
        "nlp": _Function("nlp", x, f | g, lambda z, _: (p.f(z), p.g(z)), failures),
        "grad_f": _Function(
            "nlp_grad_f",
            x,
            f | {"grad_f_x": dense(n, 1)},
            lambda z, _: (p.f(z), p.gradient(z)),
            failures,
        ),
        "jac_g": _Function(
            "nlp_jac_g",
            x,
            g | {"jac_g_x": dense(m, n)},
            lambda z, _: (p.g(z), ca.DM(p.jacobian(z))),
            failures,
        ),
        "hess_lag": _Function(
            "nlp_hess_l",
            x | lam,
            {"triu_hess_gamma_x_x": upper},
            lambda z, _, a, b: (ca.triu(ca.DM(p.hessian(z, float(a[0]), b))),),
            failures,
        ),
    }


def solve_program(
    programme: NonlinearProgram,
    start: Array,
    most_iterations: int = 100,
    tolerance: float | None = None,
) -> IpoptSolution:
    """Return the local minimum from `start` (n,), or the last point if `converged` is false.

    Raises the exceptions of the functions, including KeyboardInterrupt.
    """
    failures: list[BaseException] = []
    functions = _build_functions(programme, failures)
    derivatives = {key: function for key, function in functions.items() if key != "nlp"}
    tolerances = ("tol", "constr_viol_tol", "compl_inf_tol")
    coarse = (
        {} if tolerance is None else {**dict.fromkeys(tolerances, tolerance), "dual_inf_tol": 1.0}
    )
    settings: dict[str, Any] = {
        **derivatives,
        **CASADI_OPTIONS,
        "ipopt": {**IPOPT_OPTIONS, **coarse, "max_iter": most_iterations},
    }
    solver = ca.nlpsol("solver", "ipopt", functions["nlp"], settings)
    bounds = {
        "lbx": programme.lower,
        "ubx": programme.upper,
        "lbg": programme.g_lower,
        "ubg": programme.g_upper,
    }
    solution = solver(x0=start, **bounds)
    if failures:
        raise failures[0]
    stats = solver.stats()
    z, constraints = (np.asarray(solution[key], dtype=float)[:, 0] for key in ("x", "lam_g"))
    return IpoptSolution(z, constraints, bool(stats["success"]), int(stats["iter_count"]))
