"""Units for co-simulation (FMI): their variables, descriptions in XML, C sources, libraries and
archives.
"""

from __future__ import annotations

import hashlib
import io
import platform
import re
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from planter.files.units import parse_unit
from planter.kernels import builds, compiler, toolchain
from planter.kernels.compiler import CompilerError, Platform, find_compiler

Causality = Literal["input", "parameter", "output", "local"]
MAIN = "fmu.c"
"""The C file of a unit's sources that includes all others."""
TOKEN = "TOKEN_OF_THIS"
"""Placeholder in `MAIN` for the token of the unit."""
INTERFACE = "interface.c"
"""The file that `MAIN` includes last."""

_FRACTION = re.compile(r"\d\.\d")
_VARIABILITY = {
    "input": "continuous",
    "output": "continuous",
    "local": "continuous",
    "parameter": "tunable",
}
_DATE = (1980, 1, 1, 0, 0, 0)
"""Date of every file in an archive: the earliest that the format allows."""
_PERMISSIONS = 0o100644


@dataclass(frozen=True)
class Variable:
    """A number of a unit, in SI units and radians.

    `factor` is the size of `display_unit` in SI; `start` and the range from `low` to `high` are in
    SI, None without one. A `fixed` parameter does not change after the start. `rate_of` is the index
    of the state whose rate it is.
    """

    name: str
    unit: str
    meaning: str
    causality: Causality
    start: float | None = None
    low: float | None = None
    high: float | None = None
    display_unit: str = ""
    factor: float = 1.0
    fixed: bool = False
    rate_of: int | None = None


@dataclass(frozen=True)
class UnitModel:
    """A unit with inputs and parameters first among its variables, outputs after them; `name` is a
    C identifier.

    The reference of a variable is its index. The proposed simulation is a `period` [s] in `steps`.
    For model exchange states come first, then their rates; there are `events` event indicators.
    """

    name: str
    title: str
    meaning: str
    tool: str
    variables: tuple[Variable, ...]
    period: float
    steps: int
    events: int = 0

    @property
    def outputs(self) -> list[int]:
        """Indices of the outputs, from 0."""
        return [
            index for index, variable in enumerate(self.variables) if variable.causality == "output"
        ]


@dataclass(frozen=True)
class Version:
    """A version of the interface: its C file, if the model's own does not have it, its folders of
    libraries by platform, and a function that returns the descriptions of a model with a token by
    their paths in the archive.
    """

    source: str | None
    folders: Mapping[str, str]
    describe: Callable[[UnitModel, str], dict[str, bytes]]


def decompose_unit(unit: str) -> dict[str, int]:
    """Return the powers of the base units kg, m, s and rad in an SI unit.

    Raises ValueError for another unit.

    >>> decompose_unit("N m"), decompose_unit("rad/s2"), decompose_unit("1")
    ({'kg': 1, 'm': 2, 's': -2}, {'s': -2, 'rad': 1}, {})
    """
    parsed = parse_unit(unit)
    if parsed.factor != 1:
        raise ValueError(f"{unit} is not a unit of the SI without a prefix")
    powers = zip(("kg", "m", "s", "rad"), parsed.dimension, strict=True)
    return {base: int(power) for base, power in powers if power}


def _describe_fmi2(model: UnitModel, token: str) -> dict[str, bytes]:
    """Return `modelDescription.xml` of FMI 2.0, section 2.2 of the standard."""
    abilities = (
        "canNotUseMemoryManagementFunctions",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
    )
    root, unit = _begin_description(model, "2.0", {"guid": token}, abilities)
    SubElement(SubElement(unit, "SourceFiles"), "File", name=MAIN)
    variables = SubElement(root, "ModelVariables")
    for index, variable in enumerate(model.variables):
        scalar = SubElement(variables, "ScalarVariable", _describe_role(index, variable))
        SubElement(scalar, "Real", _describe_values(variable))
    structure = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(structure, name)
        for index in model.outputs:
            SubElement(unknowns, "Unknown", index=str(index + 1))
    return {"modelDescription.xml": _format_xml(root)}


def _describe_fmi3(model: UnitModel, token: str) -> dict[str, bytes]:
    """Return `modelDescription.xml` and `buildDescription.xml` of FMI 3.0, sections 2.4 and 2.5 of
    the standard.
    """
    abilities = ("canGetAndSetFMUState", "canSerializeFMUState")
    root, _ = _begin_description(model, "3.0", {"instantiationToken": token}, abilities)
    variables = SubElement(root, "ModelVariables")
    for index, variable in enumerate(model.variables):
        SubElement(
            variables, "Float64", _describe_role(index, variable) | _describe_values(variable)
        )
    SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(len(model.variables)),
        description="time",
        causality="independent",
        variability="continuous",
    )
    structure = SubElement(root, "ModelStructure")
    for name in ("Output", "InitialUnknown"):
        for index in model.outputs:
            SubElement(structure, name, valueReference=str(index))
    build = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(build, "BuildConfiguration", modelIdentifier=model.name)
    SubElement(SubElement(configuration, "SourceFileSet", language="C99"), "SourceFile", name=MAIN)
    return {
        "modelDescription.xml": _format_xml(root),
        "sources/buildDescription.xml": _format_xml(build),
    }


def _describe_exchange(model: UnitModel, token: str) -> dict[str, bytes]:
    """Return `modelDescription.xml` of model exchange in FMI 2.0, section 3.3 of the standard."""
    abilities = (
        "canNotUseMemoryManagementFunctions",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
        "providesDirectionalDerivative",
    )
    root, unit = _begin_description(model, "2.0", {"guid": token}, abilities, "ModelExchange")
    root.set("numberOfEventIndicators", str(model.events))
    SubElement(SubElement(unit, "SourceFiles"), "File", name=MAIN)
    variables = SubElement(root, "ModelVariables")
    for index, variable in enumerate(model.variables):
        scalar = SubElement(variables, "ScalarVariable", _describe_role(index, variable))
        SubElement(scalar, "Real", _describe_values(variable))
    rates = [
        index for index, variable in enumerate(model.variables) if variable.rate_of is not None
    ]
    calculated = [index for index in model.outputs if model.variables[index].start is None]
    unknowns = {
        "Outputs": model.outputs,
        "Derivatives": rates,
        "InitialUnknowns": [*rates, *calculated],
    }
    structure = SubElement(root, "ModelStructure")
    for name, indices in unknowns.items():
        element = SubElement(structure, name)
        for index in indices:
            SubElement(element, "Unknown", index=str(index + 1))
    return {"modelDescription.xml": _format_xml(root)}


EXCHANGE = Version(None, {"linux64": "linux64", "win64": "win64"}, _describe_exchange)
"""Model exchange in FMI 2.0."""
VERSIONS = {
    "2.0": Version("fmi2.c", {"linux64": "linux64", "win64": "win64"}, _describe_fmi2),
    "3.0": Version(
        "fmi3.c", {"linux64": "x86_64-linux", "win64": "x86_64-windows"}, _describe_fmi3
    ),
}


def _begin_description(
    model: UnitModel,
    version: str,
    token: dict[str, str],
    abilities: Sequence[str],
    kind: str = "CoSimulation",
) -> tuple[Element, Element]:
    """Return the root of a description, up to its variables, and the element of its kind."""
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": model.title,
            **token,
            "description": model.meaning,
            "generationTool": model.tool,
            "variableNamingConvention": "structured",
        },
    )
    flags = dict.fromkeys(abilities, "true")
    if kind == "CoSimulation":
        flags = {"canHandleVariableCommunicationStepSize": "true", **flags}
    unit = SubElement(root, kind, {"modelIdentifier": model.name, **flags})
    _add_units(SubElement(root, "UnitDefinitions"), model.variables)
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="what went wrong")
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=repr(model.period),
        stepSize=repr(model.period / model.steps),
    )
    return root, unit


def _add_units(parent: Element, variables: Sequence[Variable]) -> None:
    """Add each unit with its powers of base units, and its display units: display value = factor *
    SI value.
    """
    display_units: dict[str, dict[str, float]] = {}
    for variable in variables:
        units = display_units.setdefault(variable.unit, {})
        if variable.display_unit:
            units[variable.display_unit] = 1 / variable.factor
    for unit, factors in sorted(display_units.items()):
        element = SubElement(parent, "Unit", name=unit)
        if not _FRACTION.search(unit):  # FMI has whole powers alone
            powers = decompose_unit(unit)
            SubElement(element, "BaseUnit", {base: str(power) for base, power in powers.items()})
        for name, factor in sorted(factors.items()):
            SubElement(element, "DisplayUnit", name=name, factor=repr(factor))


def _describe_role(index: int, variable: Variable) -> dict[str, str]:
    """Return name, reference, causality and variability of a variable."""
    attributes = {
        "name": variable.name,
        "valueReference": str(index),
        "description": variable.meaning,
        "causality": variable.causality,
        "variability": "fixed" if variable.fixed else _VARIABILITY[variable.causality],
    }
    if variable.causality != "input":
        attributes["initial"] = "calculated" if variable.start is None else "exact"
    return attributes


def _describe_values(variable: Variable) -> dict[str, str]:
    """Return units, range and start of a variable."""
    limits = {"min": variable.low, "max": variable.high, "start": variable.start}
    attributes = {"unit": variable.unit} | (
        {"displayUnit": variable.display_unit} if variable.display_unit else {}
    )
    if variable.rate_of is not None:
        attributes["derivative"] = str(variable.rate_of + 1)
    return attributes | {name: repr(value) for name, value in limits.items() if value is not None}


def _format_xml(root: Element) -> bytes:
    """Return XML with a line for each element."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True) + b"\n"


def complete_sources(
    version: Version, model: UnitModel, texts: Mapping[str, str]
) -> tuple[str, dict[str, str]]:
    """Return the unit's token, a hash of its description and sources, and all sources with it, by
    name.

    `texts` are the model's own sources; among them `MAIN`, which contains the word `TOKEN`.
    """
    folder = resources.files(__package__)
    interface = {INTERFACE: version.source, "core.c": "core.c"} if version.source else {}
    code = dict(texts) | {
        name: folder.joinpath(file).read_text(encoding="utf-8") for name, file in interface.items()
    }
    parts = [
        *version.describe(model, TOKEN).values(),
        *(part.encode() for pair in sorted(code.items()) for part in pair),
    ]
    digest = hashlib.sha256(b"\0".join(parts)).hexdigest()
    token = "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]))
    return token, code | {MAIN: code[MAIN].replace(TOKEN, token)}


PLATFORMS: dict[str, tuple[str, Platform]] = {
    "linux64": ("x86_64-linux-gnu.2.17", compiler.LINUX),
    "win64": ("x86_64-windows-gnu", compiler.WINDOWS),
}
"""Target of the bundled compiler, and properties of libraries, by platform."""
FLAGS = ("-O2", "-fvisibility=hidden", "-Werror=implicit-function-declaration")


def build_library(platform_name: str, texts: Mapping[str, str], name: str) -> tuple[str, bytes]:
    """Return file name and content of a unit's library for any processor of a platform, from its
    sources.

    This system's compiler builds for this system, the bundled one for others. Raises CompilerError.
    """
    target, system = PLATFORMS[platform_name]
    is_here = (
        platform_name == "linux64" and sys.platform == "linux" and platform.machine() == "x86_64"
    )
    native = is_here and not find_compiler().bundled
    file = f"{name}{system.suffix}"
    with tempfile.TemporaryDirectory(prefix="planter-") as temporary:
        folder = Path(temporary)
        for source, text in texts.items():
            (folder / source).write_text(text, encoding="utf-8")
        command = find_compiler().command if native else compiler.bundled_command(target)
        if not command:
            raise CompilerError(
                "planter[compiler] is not installed, which builds for other systems"
            )
        compiled = folder / "fmu.o"
        steps = (
            system.compile(command, FLAGS, folder / MAIN, compiled),
            [*system.link(command, compiled, folder / file, folder / file), "-s"],
        )
        try:
            for step in steps:
                if native:
                    builds.run_program(step, toolchain.TIMEOUT_S, folder)
                else:
                    toolchain.run_bundled(target, step, folder)
            return file, (folder / file).read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise CompilerError(
                f"{command[0]} did not build {file}: {toolchain.summarise_error(error)}"
            ) from error


def pack_unit(
    version: Version,
    model: UnitModel,
    texts: Mapping[str, str],
    token: str,
    libraries: Mapping[str, tuple[str, bytes]],
) -> bytes:
    """Return a unit's file, a zip archive with the same bytes for the same content.

    `texts` and `token` are those of `complete_sources`, `libraries` are file names and contents by
    platform.
    """
    files = version.describe(model, token)
    files |= {f"sources/{name}": text.encode() for name, text in sorted(texts.items())}
    files |= {
        f"binaries/{version.folders[place]}/{name}": data
        for place, (name, data) in sorted(libraries.items())
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.external_attr = _PERMISSIONS << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return stream.getvalue()
