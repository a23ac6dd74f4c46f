"""The generated families of pitch curves, each also described by its size and swing
(`NAME-relative`).

A family `limacon` is also there as `limacon-relative`, with the design names `size3_mm`, `swing3`,
those of its shapes if it has any, and its deformation coefficient. The size is the mean pitch
radius of both gears in the limit of a small swing; the swing is (largest - smallest) / (largest +
smallest) ratio, or close to it without a closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np

from planter import paths, safe_text
from planter.errors import InputError
from planter.kernels import Array, Kernel, generated

_PREFIX = "curve_"


def list_families() -> tuple[str, ...]:
    """Return the names of the families."""
    return tuple(name.removeprefix(_PREFIX) for name in generated.names(_PREFIX))


@cache
def load_functions(name: str) -> ModuleType:
    """Return the functions of a family, or of its description by size and swing."""
    family = find_family(name)
    if family is None:
        return generated.module(_PREFIX + name)
    return build_relative_module(name, load_functions(family), load_sidecar(family))


@cache
def load_sidecar(name: str) -> dict[str, Any]:
    """Return the sidecar of a family's functions."""
    family = find_family(name)
    return (
        generated.sidecar(_PREFIX + name)
        if family is None
        else describe_relative(load_sidecar(family))
    )


def check_family(name: str, where: str) -> str:
    """Return the name of an existing family; `where` names its file and key in errors.

    Raises InputError for an unknown family.
    """
    if (find_family(name) or name) not in list_families():
        raise InputError.for_value(
            where, safe_text.format_value(name), paths.suggest_names(name, list_families())
        )
    return name


def compute_family_parameters(family: str, description: Array) -> Array:
    """Return the parameters (q,) of a family in SI from those of its description."""
    parameters = Kernel(load_functions(f"{family}{SUFFIX}").family_parameters)
    return parameters(described=description)["parameters"][:, 0]


SUFFIX = "-relative"
SMALL_SWING = 1e-4
"""Swing at which the centre distance is that of circles up to the square of the swing."""
TERMS = 16
COMPOSED = ("prologue", "contact", "curvature", "polar", "speed", "convexity")
"""Functions of a generated module in which only the parameters are replaced."""


def find_family(name: str) -> str | None:
    """Return the family that a relative name describes, None for the name of a family."""
    return name.removesuffix(SUFFIX) if name.endswith(SUFFIX) else None


def describe_relative(family: dict[str, Any]) -> dict[str, Any]:
    """Return the sidecar of the description, from that of the family."""
    size = {
        "name": "size",
        "unit": "m",
        "meaning": "mean pitch radius",
        "source": "described",
        "shown": "size_mm",
    }
    swing = {
        "name": "swing",
        "unit": "1",
        "meaning": "relative swing of the ratio",
        "source": "described",
    }
    shapes = [{**shape, "shown": shape["name"]} for shape in family["shapes"]]
    parameters = [size, {**swing, "shown": "swing"}, *shapes, family["parameters"][-1]]
    conditions = [
        {"name": "size", "allowed": "greater than 0"},
        {"name": "swing", "allowed": "greater than 0"},
    ]
    family_conditions = [
        {**c, "name": "m" if c["name"] == "m" else "swing"} for c in family["conditions"]
    ]
    return {
        **family,
        "name": family["name"] + SUFFIX,
        "parameters": parameters,
        "conditions": [*conditions, *family_conditions],
    }


def build_relative_module(
    name: str, family: ModuleType, family_sidecar: dict[str, Any]
) -> ModuleType:
    """Return the functions of a generated module in terms of the description."""
    functions = ModuleType(name)
    lengths = [entry["unit"] == "m" for entry in family_sidecar["parameters"][:-1]]
    mapping = _build_mapping(family, lengths, len(family_sidecar["shapes"]))

    def wrap(build: Callable[..., ca.Function]) -> Callable[..., ca.Function]:
        def function(*terms: int) -> ca.Function:
            return _compose(build(*terms), mapping)

        return function

    composed = {part: wrap(getattr(family, part)) for part in COMPOSED if hasattr(family, part)}
    functions.__dict__.update(composed, family_parameters=mapping)
    functions.__dict__["conditions"] = lambda: _compose_conditions(family, mapping)
    functions.__dict__["tangent"] = lambda terms: _compose_tangent(family.tangent(terms), mapping)
    return functions


def _build_mapping(family: ModuleType, lengths: list[bool], shapes: int) -> ca.Function:
    """Return the function (size, swing, shapes, m) -> parameters of the family."""
    p = ca.SX.sym("described", 3 + shapes)
    unit = _compute_unit(family)
    relative = family.relative().call([p[1], p[2:-1]])
    parts = [
        value * p[0] / unit if length else value
        for value, length in zip(relative, lengths, strict=True)
    ]
    return ca.Function("own", [p], [ca.vertcat(*parts, p[-1])], ["described"], ["parameters"])


@cache
def _compute_unit(family: ModuleType) -> float:
    """Return half the centre distance of the family's curve of unit size and small swing."""
    relative = Kernel(family.relative())
    count = relative.function.size1_in(1)
    values = [v[0, 0] for v in relative(swing=SMALL_SWING, shape=np.zeros(count)).values()]
    prologue = Kernel(family.prologue(TERMS))
    # rounded, so that the unit does not depend on the machine's arithmetic
    return round(float(prologue(parameters=np.array([*values, 1.0]))["hoisted"][0, 0]) / 2, 6)


def _compose(f: ca.Function, mapping: ca.Function) -> ca.Function:
    """Return a function of the family with the description in place of the parameters."""
    names, sym = f.name_in(), ca.SX.sym if f.is_a("SXFunction") else ca.MX.sym
    count = mapping.size1_in(0)
    inputs: Any = [
        sym(name, count if name == "parameters" else f.size1_in(i)) for i, name in enumerate(names)
    ]
    arguments: Any = [
        mapping(v) if name == "parameters" else v for name, v in zip(names, inputs, strict=True)
    ]
    return ca.Function(f.name(), inputs, f.call(arguments), names, f.name_out())


def _compose_tangent(f: ca.Function, mapping: ca.Function) -> ca.Function:
    """Return the Jacobian of the prologue in the description, by the chain rule."""
    p, hoisted = ca.MX.sym("parameters", mapping.size1_in(0)), ca.MX.sym("hoisted", f.size1_in(1))
    v = ca.SX.sym("described", mapping.size1_in(0))
    inner = ca.Function("along", [v], [ca.jacobian(mapping(v), v)])
    return ca.Function(
        "tangent", [p, hoisted], [f(mapping(p), hoisted) @ inner(p)], f.name_in(), f.name_out()
    )


def _compose_conditions(family: ModuleType, mapping: ca.Function) -> ca.Function:
    p = ca.SX.sym("parameters", mapping.size1_in(0))
    conditions = family.conditions()
    outputs = [p[0], p[1], *conditions.call([mapping(p)])]
    return ca.Function(
        "conditions", [p], outputs, ["parameters"], [f"g{i}" for i in range(len(outputs))]
    )
