"""Scalar operations as text of languages that have one operation a line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from planter.kernels.lane_graph import ArrayElement, Assignment, ScalarOperation

_SELECT = re.compile(r"\(?([^\s(]+ (?:[<>]=?|[!=]=) [^\s)]+) \? (\S+) : ([^\s)]+)\)?")
_CALL = re.compile(r"\b([a-z_]\w*)\(")
_LANES = {"turned_sin": "sin", "turned_cos": "cos", "whole_floor": "floor"}
"""Functions of lanes, with those of libraries."""


@dataclass(frozen=True)
class OperationDialect:
    """`select` has a condition and two values, `statement` a name and a value; `call` stands before
    the names of functions, of which `names` has those that differ.
    """

    select: str
    call: str
    statement: str
    names: Mapping[str, str]

    def express(self, operation: ScalarOperation, arguments: Sequence[str]) -> str:
        """Return an operation on names and numbers."""
        text = operation.text.format(*arguments)
        text = _CALL.sub(lambda match: f"{self._find_function(match[1])}(", text)
        return _SELECT.sub(lambda match: self.select.format(*match.groups()), text)

    def _find_function(self, name: str) -> str:
        """Return the name of a function; those of the module itself begin with a line."""
        name = self.names.get(name, name)
        return name if name.startswith("_") else f"{self.call}{name}"

    def assign(self, assignment: Assignment, arguments: Sequence[str]) -> str:
        """Return the statement of an assignment whose arguments are texts."""
        source = assignment.source
        if not isinstance(source, ArrayElement):
            value = self.express(source, arguments)
        else:
            value = "t" if source.name == "t" else f"{source.name}[{source.index}]"
        return self.statement.format(assignment.name, value)


RUST = OperationDialect(
    "(if {0} {{ {1} }} else {{ {2} }})", "libm::", "    let {0}: f64 = {1};", _LANES
)
JAX = OperationDialect(
    "jnp.where({0}, {1}, {2})",
    "jnp.",
    "    {0} = {1}",
    _LANES
    | {
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
