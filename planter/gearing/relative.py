"""Pitch curves described alike for every family: mean radius, relative swing of the ratio, deformation.

A family `limacon` is also there as `limacon-relative`, with the design names `size3_mm`, `swing3`, those of its shapes
if it has any, and its deformation coefficient. The size is the mean pitch radius of both gears in the limit of a small
swing; the swing is (largest - least) / (largest + least) ratio, or close to it where that has no closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Kernel

SUFFIX = "-relative"
SMALL = 1e-4
"""A swing at which the centre distance is that of circles to its square."""
TERMS = 16
COMPOSED = ("prologue", "contact", "curvature", "polar", "speed", "convexity")
"""Functions of a generated module whose parameters are replaced and nothing else."""


def family_of(name: str) -> str | None:
    """The family that a name describes, None for a family's own name."""
    return name.removesuffix(SUFFIX) if name.endswith(SUFFIX) else None


def sidecar(own: dict[str, Any]) -> dict[str, Any]:
    """The sidecar of the description, from the family's own."""
    size = {"name": "size", "unit": "m", "meaning": "mean pitch radius", "source": "described", "shown": "size_mm"}
    swing = {"name": "swing", "unit": "1", "meaning": "relative swing of the ratio", "source": "described"}
    shapes = [{**shape, "shown": shape["name"]} for shape in own["shapes"]]
    parameters = [size, {**swing, "shown": "swing"}, *shapes, own["parameters"][-1]]
    conditions = [{"name": "size", "allowed": "greater than 0"}, {"name": "swing", "allowed": "greater than 0"}]
    inherited = [{**c, "name": "m" if c["name"] == "m" else "swing"} for c in own["conditions"]]
    return {**own, "name": own["name"] + SUFFIX, "parameters": parameters, "conditions": [*conditions, *inherited]}


def module(name: str, family: ModuleType, own: dict[str, Any]) -> ModuleType:
    """What a generated module of a family holds, in terms of its description."""
    made = ModuleType(name)
    lengths = [entry["unit"] == "m" for entry in own["parameters"][:-1]]
    described = _mapping(family, lengths, len(own["shapes"]))

    def wrapped(build: Callable[..., ca.Function]) -> Callable[..., ca.Function]:
        def function(*terms: int) -> ca.Function:
            return _composed(build(*terms), described)

        return function

    composed = {part: wrapped(getattr(family, part)) for part in COMPOSED if hasattr(family, part)}
    made.__dict__.update(composed, own_parameters=described)
    made.__dict__["conditions"] = lambda: _conditions(family, described)
    made.__dict__["tangent"] = lambda terms: _tangent(family.tangent(terms), described)
    return made


def _mapping(family: ModuleType, lengths: list[bool], shapes: int) -> ca.Function:
    """(size, swing, shapes, m) -> parameters of the family."""
    p = ca.SX.sym("described", 3 + shapes)
    unit = _unit(family)
    relative = family.relative().call([p[1], p[2:-1]])
    parts = [value * p[0] / unit if length else value for value, length in zip(relative, lengths, strict=True)]
    return ca.Function("own", [p], [ca.vertcat(*parts, p[-1])], ["described"], ["parameters"])


@cache
def _unit(family: ModuleType) -> float:
    """Half the centre distance of the family's curve of unit size and hardly any swing."""
    relative = Kernel(family.relative())
    count = relative.function.size1_in(1)
    values = [v[0, 0] for v in relative(swing=SMALL, shape=np.zeros(count)).values()]
    prologue = Kernel(family.prologue(TERMS))
    return round(float(prologue(parameters=np.array([*values, 1.0]))["hoisted"][0, 0]) / 2, 6)


def _composed(f: ca.Function, described: ca.Function) -> ca.Function:
    """A function of the family as one of its description, which takes the parameters' place."""
    names, sym = f.name_in(), ca.SX.sym if f.is_a("SXFunction") else ca.MX.sym
    count = described.size1_in(0)
    inputs: Any = [sym(name, count if name == "parameters" else f.size1_in(i)) for i, name in enumerate(names)]
    given: Any = [described(v) if name == "parameters" else v for name, v in zip(names, inputs, strict=True)]
    return ca.Function(f.name(), inputs, f.call(given), names, f.name_out())


def _tangent(f: ca.Function, described: ca.Function) -> ca.Function:
    """Jacobian of the prologue in the description: the family's, times that of its parameters."""
    p, hoisted = ca.MX.sym("parameters", described.size1_in(0)), ca.MX.sym("hoisted", f.size1_in(1))
    v = ca.SX.sym("described", described.size1_in(0))
    inner = ca.Function("along", [v], [ca.jacobian(described(v), v)])
    return ca.Function("tangent", [p, hoisted], [f(described(p), hoisted) @ inner(p)], f.name_in(), f.name_out())


def _conditions(family: ModuleType, described: ca.Function) -> ca.Function:
    p = ca.SX.sym("parameters", described.size1_in(0))
    own = family.conditions()
    outputs = [p[0], p[1], *own.call([described(p)])]
    return ca.Function("conditions", [p], outputs, ["parameters"], [f"g{i}" for i in range(len(outputs))])
