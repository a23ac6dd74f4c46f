"""A model as CasADi functions in a file, with a Python module that loads them without planter."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from planter.exports.dynamics_c import build_name
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.version import __version__

FUNCTIONS = ("f", "f_jacobian", "y", "y_jacobian", "curvature")
MODULE = '''"""The dynamics of {title}: x' = f(t, x, u, p) and y = g(t, x, u, p), in SI units and radians.

Written by planter {version}; do not edit. It needs CasADi {casadi} or newer, and {file} beside it.

    functions = load()
    xdot, pivot = functions["f"](0, START, U, P)

Functions: f -> xdot, pivot; f_jacobian -> A, B, F; y -> y; y_jacobian -> C, D, G; curvature(t, x, u, p,
weights, direction) -> derivative along the direction of the gradient of weights^T xdot by x, u, p.
Where pivot is near 0 the constraints that are kept, {constraints}, depend on each other.
"""

from pathlib import Path

import casadi

STATES = {states}
INPUTS = {inputs}
PARAMETERS = {parameters}
OUTPUTS = {outputs}
START = {start}
U = {u}
P = {p}
LOWER_U = {lower}
UPPER_U = {upper}


def load():
    """Return the CasADi functions by name."""
    text = Path(__file__).with_suffix(".casadi").read_text()
    file = casadi.StringDeserializer(text)
    functions = [file.unpack() for _ in {names}]
    return {{function.name(): function for function in functions}}
'''
"""Names, units and meanings are lists of triples."""


def build_casadi_files(model: DynamicsModel) -> dict[str, str]:
    """Return the content of `NAME.casadi` and `NAME.py` by file name."""
    name = build_name(model)
    variables = {
        "states": model.states,
        "inputs": model.inputs,
        "parameters": model.parameters,
        "outputs": model.outputs,
    }
    numbers: dict[str, Sequence[float]] = {
        "start": model.start.tolist(),
        "u": model.u.tolist(),
        "p": model.p.tolist(),
        "lower": [variable.low for variable in model.inputs],
        "upper": [variable.high for variable in model.inputs],
    }
    text = MODULE.format(
        title=model.name.replace('"""', '"'),
        version=__version__,
        casadi=ca.CasadiMeta.version(),
        file=f"{name}.casadi",
        constraints=", ".join(model.constraints) or "none",
        names=FUNCTIONS,
        **{key: _list_variables(part) for key, part in variables.items()},
        **{key: _list_numbers(part) for key, part in numbers.items()},
    )
    return {f"{name}.casadi": _serialise(model), f"{name}.py": text}


def _list_variables(variables: Sequence[DynamicsVariable]) -> str:
    rows = [f"    {(x.name, x.unit, x.meaning)!r},\n" for x in variables]
    return f"[\n{''.join(rows)}]" if rows else "[]"


def _list_numbers(numbers: Sequence[float]) -> str:
    values = [float(number) for number in numbers]
    texts = [repr(x) if abs(x) < float("inf") else f'float("{x}")' for x in values]
    return f"[{', '.join(texts)}]"


def _serialise(model: DynamicsModel) -> str:
    file = ca.StringSerializer()
    for name in FUNCTIONS:
        file.pack(getattr(model, name))
    return str(file.encode())
