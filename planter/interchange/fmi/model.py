"""What a unit for co-simulation says of itself, and what the descriptions of all versions have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from planter.interchange.variables import Variable, powers

MAIN = "fmu.c"
"""The C file of a unit's sources that includes all others."""


@dataclass(frozen=True)
class Model:
    """A unit with inputs and parameters first among its variables, outputs after them; `name` is a C identifier.

    A variable's reference is its place in the list. It proposes to simulate a `period` [s] in `steps`.
    """

    name: str
    title: str
    meaning: str
    tool: str
    variables: tuple[Variable, ...]
    period: float
    steps: int

    @property
    def outputs(self) -> list[int]:
        """Places of the outputs, from 0."""
        return [place for place, variable in enumerate(self.variables) if variable.causality == "output"]


def described(model: Model, version: str, token: dict[str, str], slave: dict[str, str]) -> tuple[Element, Element]:
    """Return the root of a description, up to its variables, and the element of co-simulation."""
    root = Element("fmiModelDescription", {
        "fmiVersion": version, "modelName": model.title, **token, "description": model.meaning,
        "generationTool": model.tool, "variableNamingConvention": "structured",
    })  # fmt: skip
    able = {"modelIdentifier": model.name, "canHandleVariableCommunicationStepSize": "true", **slave}
    co_simulation = SubElement(root, "CoSimulation", able)
    _units(SubElement(root, "UnitDefinitions"), model.variables)
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="what went wrong")
    SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(model.period),
               stepSize=repr(model.period / model.steps))  # fmt: skip
    return root, co_simulation


def _units(parent: Element, variables: Sequence[Variable]) -> None:
    """Write each unit by its powers of base units, and its display units: display value = factor * SI value."""
    display_units: dict[str, dict[str, float]] = {}
    for variable in variables:
        units = display_units.setdefault(variable.unit, {})
        if variable.shown:
            units[variable.shown] = 1 / variable.factor
    for unit, factors in sorted(display_units.items()):
        element = SubElement(parent, "Unit", name=unit)
        SubElement(element, "BaseUnit", {base: str(power) for base, power in powers(unit).items()})
        for name, factor in sorted(factors.items()):
            SubElement(element, "DisplayUnit", name=name, factor=repr(factor))


_VARIABILITY = {"input": "continuous", "output": "continuous", "parameter": "tunable"}


def role(place: int, variable: Variable) -> dict[str, str]:
    """Return name, reference, causality and variability of a variable."""
    attributes = {
        "name": variable.name, "valueReference": str(place), "description": variable.meaning,
        "causality": variable.causality, "variability": "fixed" if variable.fixed else _VARIABILITY[variable.causality],
    }  # fmt: skip
    if variable.causality != "input":
        attributes["initial"] = "calculated" if variable.start is None else "exact"
    return attributes


def numbers(variable: Variable) -> dict[str, str]:
    """Return units, range and start of a variable."""
    limits = {"min": variable.low, "max": variable.high, "start": variable.start}
    attributes = {"unit": variable.unit} | ({"displayUnit": variable.shown} if variable.shown else {})
    return attributes | {name: repr(value) for name, value in limits.items() if value is not None}


def text(root: Element) -> bytes:
    """XML with a line for each element."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True) + b"\n"
