"""A model in Rust and for JAX: one scalar operation a line, printed by a dialect."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from planter.exports.dynamics_c import FUNCTIONS, build_name, densify_by_rows
from planter.kernels.lane_graph import ArrayElement, Assignment, LaneGraph, ScalarOperation
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.version import __version__

_SELECT = re.compile(r"\(?([^\s(]+ (?:[<>]=?|[!=]=) [^\s)]+) \? (\S+) : ([^\s)]+)\)?")
_CALL = re.compile(r"\b([a-z]\w*)\(")
_NAMES = {"turned_sin": "sin", "turned_cos": "cos", "whole_floor": "floor"}
"""Functions of lanes, with those of libraries."""


@dataclass(frozen=True)
class _Dialect:
    """`select` has a condition and two values, `call` the name of a function."""

    select: str
    call: str
    statement: str
    names: Mapping[str, str]

    def express(self, operation: ScalarOperation, arguments: Sequence[str]) -> str:
        """Return an operation on names and numbers."""
        text = operation.text.format(*arguments)
        text = _CALL.sub(lambda match: self._call(match[1]), text)
        return _SELECT.sub(lambda match: self.select.format(*match.groups()), text)

    def _call(self, name: str) -> str:
        name = _NAMES.get(name, name)
        return f"{self.call.format(self.names.get(name, name))}("

    def assign(self, assignment: Assignment, element: Callable[[ArrayElement], str]) -> str:
        """Return a statement that names a value."""
        source = assignment.source
        value = (
            element(source)
            if isinstance(source, ArrayElement)
            else self.express(source, assignment.arguments)
        )
        return self.statement.format(assignment.name, value)


RUST = _Dialect("(if {0} {{ {1} }} else {{ {2} }})", "libm::{0}", "    let {0}: f64 = {1};", {})
JAX = _Dialect(
    "jnp.where({0}, {1}, {2})",
    "jnp.{0}",
    "    {0} = {1}",
    {
        "fabs": "abs",
        "asin": "arcsin",
        "acos": "arccos",
        "atan": "arctan",
        "atan2": "arctan2",
        "asinh": "arcsinh",
        "acosh": "arccosh",
        "atanh": "arctanh",
        "pow": "power",
    },
)
_LIBM_ARGUMENTS = {"pow": 2, "atan2": 2, "fmin": 2, "fmax": 2, "copysign": 2, "hypot": 2, "fmod": 2}


def build_rust_files(model: DynamicsModel) -> dict[str, str]:
    """Return `NAME.rs`, a crate without the standard library whose functions of libm are linked."""
    name = build_name(model)
    functions = [
        _print_rust(label, densify_by_rows(label, getattr(model, member)))
        for label, member in FUNCTIONS.items()
    ]
    body = "\n\n".join(functions)
    used = sorted(set(re.findall(r"libm::(\w+)\(", body)))
    lines = [
        f"//! The dynamics of {model.name}: x' = f(t, x, u, p) and y = g(t, x, u, p), SI and radians.",
        "//!",
        f"//! Written by planter {__version__}; do not edit. Matrices are row by row.",
        *(f"//! {line}" for line in _list_variables(model)),
        "#![no_std]",
        "#![allow(clippy::all, unused_variables, unused_parens, non_snake_case)]",
        "",
        *_list_rust_constants(model),
        "",
        "mod libm {",
        *(f"    {_print_rust_import(function)}" for function in used),
        '    extern "C" {' if used else "",
        *(f'        #[link_name = "{f}"] fn {f}_({_rust_arguments(f)}) -> f64;' for f in used),
        "    }" if used else "",
        "}",
        "",
        body,
    ]
    return {f"{name}.rs": "\n".join(lines) + "\n"}


def _rust_arguments(function: str) -> str:
    return ", ".join(f"{letter}: f64" for letter in "ab"[: _LIBM_ARGUMENTS.get(function, 1)])


def _print_rust_import(function: str) -> str:
    names = ", ".join("ab"[: _LIBM_ARGUMENTS.get(function, 1)])
    head = f"pub fn {function}({_rust_arguments(function)}) -> f64"
    return f"{head} {{ unsafe {{ {function}_({names}) }} }}"


def _list_rust_constants(model: DynamicsModel) -> list[str]:
    lines = []
    for key, variables in _name_variables(model).items():
        names = ", ".join(f'"{variable.name}"' for variable in variables)
        lines.append(f"pub const {key}: [&str; {len(variables)}] = [{names}];")
    for key, numbers in (("START", model.start), ("U", model.u), ("P", model.p)):
        values = ", ".join(repr(float(number)) for number in numbers)
        lines.append(f"pub const {key}: [f64; {len(numbers)}] = [{values}];")
    return lines


def _print_rust(label: str, function: ca.Function) -> str:
    graph = LaneGraph.from_function(function, ())
    inputs = [
        f"{name}: f64" if name == "t" else f"{name}: &[f64; {function.numel_in(index)}]"
        for index, name in enumerate(function.name_in())
    ]
    outputs = [
        f"{name}: &mut [f64; {function.numel_out(index)}]"
        for index, name in enumerate(function.name_out())
    ]

    def element(place: ArrayElement) -> str:
        return "t" if place.name == "t" else f"{place.name}[{place.index}]"

    lines = [RUST.assign(assignment, element) for assignment in graph.assignments]
    lines += [f"    {s.place.name}[{s.place.index}] = {s.value};" for s in graph.stores]
    return "\n".join([f"pub fn {label}({', '.join([*inputs, *outputs])}) {{", *lines, "}"])


def build_jax_files(model: DynamicsModel) -> dict[str, str]:
    """Return `NAME.py`: functions for `jax.jit`, `jax.vmap` and derivatives, which need JAX alone."""
    functions = [
        _print_jax(label, densify_by_rows(label, getattr(model, FUNCTIONS[label])))
        for label in ("rates", "outputs_at")
    ]
    lines = [
        f'"""The dynamics of {model.name}: x\' = f(t, x, u, p) and y = g(t, x, u, p), SI and radians.',
        "",
        f"Written by planter {__version__}; do not edit. `rates` returns x' and the least pivot of the",
        "constraints over the largest, near 0 where they depend on each other; `outputs_at` returns y.",
        "They take jax.jit, jax.vmap, jax.jacfwd; double precision needs",
        'jax.config.update("jax_enable_x64", True).',
        '"""',
        "",
        "import jax.numpy as jnp",
        "",
    ]
    for key, variables in _name_variables(model).items():
        rows = [(variable.name, variable.unit, variable.meaning) for variable in variables]
        lines.append(f"{key} = {rows!r}")
    for key, numbers in (("START", model.start), ("U", model.u), ("P", model.p)):
        lines.append(f"{key} = {[float(number) for number in numbers]!r}")
    return {f"{build_name(model)}.py": "\n".join([*lines, "", "", *functions])}


def _print_jax(label: str, function: ca.Function) -> str:
    graph = LaneGraph.from_function(function, ())

    def element(place: ArrayElement) -> str:
        return "t" if place.name == "t" else f"{place.name}[{place.index}]"

    lines = [f"def {label}({', '.join(function.name_in())}):"]
    lines += [JAX.assign(assignment, element) for assignment in graph.assignments]
    results = []
    for name in function.name_out():
        values = [store.value for store in graph.stores if store.place.name == name]
        results.append(values[0] if name == "pivot" else f"jnp.stack([{', '.join(values)}])")
    return "\n".join([*lines, f"    return {', '.join(results)}", "", ""])


def _name_variables(model: DynamicsModel) -> dict[str, Sequence[DynamicsVariable]]:
    return {
        "STATES": model.states,
        "INPUTS": model.inputs,
        "PARAMETERS": model.parameters,
        "OUTPUTS": model.outputs,
    }


def _list_variables(model: DynamicsModel) -> list[str]:
    symbols = zip("xupy", _name_variables(model).values(), strict=True)
    return [
        f"{symbol}[{index}] {variable.name} [{variable.unit}] {variable.meaning}"
        for symbol, variables in symbols
        for index, variable in enumerate(variables)
    ]
