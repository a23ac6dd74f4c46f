"""FMI 2.0: `modelDescription.xml`, section 2.2 of the standard."""

from __future__ import annotations

from xml.etree.ElementTree import SubElement

from planter.interchange.fmi.model import MAIN, Model, described, numbers, role, text

NAME, INTERFACE = "2.0", "fmi2.c"
FOLDERS = {"linux64": "linux64", "win64": "win64"}
"""How the standard calls the folders of libraries."""
SLAVE = {
    "canNotUseMemoryManagementFunctions": "true", "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
}  # fmt: skip


def files(model: Model, token: str) -> dict[str, bytes]:
    """The description, by its path in the archive."""
    root, slave = described(model, NAME, {"guid": token}, SLAVE)
    SubElement(SubElement(slave, "SourceFiles"), "File", name=MAIN)
    variables = SubElement(root, "ModelVariables")
    for place, variable in enumerate(model.variables):
        SubElement(SubElement(variables, "ScalarVariable", role(place, variable)), "Real", numbers(variable))
    structure = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        listed = SubElement(structure, name)
        for place in model.outputs:
            SubElement(listed, "Unknown", index=str(place + 1))
    return {"modelDescription.xml": text(root)}
