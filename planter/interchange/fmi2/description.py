"""`modelDescription.xml` of a co-simulation unit: FMI 2.0, section 2.2.

A variable's value reference is its place in the list; inputs and parameters come first, outputs after them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from planter.interchange.variables import Variable, powers

GUID = "guid"
"""Stands in the description until the hash of everything else is known."""


@dataclass(frozen=True)
class Model:
    """What a unit says of itself; `name` is a C identifier.

    It proposes to simulate a `period` [s] in `steps`.
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


def xml(model: Model, sources: Sequence[str], guid: str = GUID) -> bytes:
    """The description, with the names of the C files that are to be compiled."""
    root = Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=model.title, guid=guid, description=model.meaning,
        generationTool=model.tool, variableNamingConvention="structured",
    )  # fmt: skip
    slave = SubElement(
        root, "CoSimulation", modelIdentifier=model.name, canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true", canGetAndSetFMUstate="true", canSerializeFMUstate="true",
    )  # fmt: skip
    files = SubElement(slave, "SourceFiles")
    for source in sources:
        SubElement(files, "File", name=source)
    _units(SubElement(root, "UnitDefinitions"), model.variables)
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="what went wrong")
    SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(model.period),
               stepSize=repr(model.period / model.steps))  # fmt: skip
    variables = SubElement(root, "ModelVariables")
    for place, variable in enumerate(model.variables):
        _variable(variables, place, variable)
    structure = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        listed = SubElement(structure, name)
        for place in model.outputs:
            SubElement(listed, "Unknown", index=str(place + 1))
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True) + b"\n"


def _units(parent: Element, variables: Sequence[Variable]) -> None:
    """Each unit by its powers of base units, and the units that people see it in: shown = factor * SI."""
    shown: dict[str, dict[str, float]] = {}
    for variable in variables:
        units = shown.setdefault(variable.unit, {})
        if variable.shown:
            units[variable.shown] = 1 / variable.factor
    for unit, others in sorted(shown.items()):
        element = SubElement(parent, "Unit", name=unit)
        SubElement(element, "BaseUnit", {base: str(power) for base, power in powers(unit).items()})
        for name, factor in sorted(others.items()):
            SubElement(element, "DisplayUnit", name=name, factor=repr(factor))


VARIABILITY = {"input": "continuous", "output": "continuous", "parameter": "tunable"}


def _variable(parent: Element, place: int, variable: Variable) -> None:
    attributes = {
        "name": variable.name, "valueReference": str(place), "description": variable.meaning,
        "causality": variable.causality, "variability": "fixed" if variable.fixed else VARIABILITY[variable.causality],
    }  # fmt: skip
    if variable.causality != "input":
        attributes["initial"] = "calculated" if variable.start is None else "exact"
    numbers = {"min": variable.low, "max": variable.high, "start": variable.start}
    real = {"unit": variable.unit} | ({"displayUnit": variable.shown} if variable.shown else {})
    real |= {name: repr(value) for name, value in numbers.items() if value is not None}
    SubElement(SubElement(parent, "ScalarVariable", attributes), "Real", real)
