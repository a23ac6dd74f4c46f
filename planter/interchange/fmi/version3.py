"""FMI 3.0: `modelDescription.xml`, section 2.4 of the standard, and `buildDescription.xml`, section 2.5."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from planter.interchange.fmi.model import MAIN, Model, described, numbers, role, text

NAME, INTERFACE = "3.0", "fmi3.c"
FOLDERS = {"linux64": "x86_64-linux", "win64": "x86_64-windows"}
"""How the standard calls the folders of libraries."""
SLAVE = {"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}


def files(model: Model, token: str) -> dict[str, bytes]:
    """The descriptions of the unit and of how it is built, by their paths in the archive."""
    root, _ = described(model, NAME, {"instantiationToken": token}, SLAVE)
    variables = SubElement(root, "ModelVariables")
    for place, variable in enumerate(model.variables):
        SubElement(variables, "Float64", role(place, variable) | numbers(variable))
    SubElement(variables, "Float64", name="time", valueReference=str(len(model.variables)), description="time",
               causality="independent", variability="continuous")  # fmt: skip
    structure = SubElement(root, "ModelStructure")
    for name in ("Output", "InitialUnknown"):
        for place in model.outputs:
            SubElement(structure, name, valueReference=str(place))
    return {"modelDescription.xml": text(root), "sources/buildDescription.xml": _build(model)}


def _build(model: Model) -> bytes:
    root = Element("fmiBuildDescription", fmiVersion=NAME)
    build = SubElement(root, "BuildConfiguration", modelIdentifier=model.name)
    SubElement(SubElement(build, "SourceFileSet", language="C99"), "SourceFile", name=MAIN)
    return text(root)
