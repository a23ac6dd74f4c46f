"""Functional mock-up units (FMI 2.0 and 3.0): their variables, descriptions in XML, C sources,
libraries and archives.
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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from planter.files.units import parse_unit
from planter.kernels import builds, compiler, toolchain
from planter.kernels.compiler import CompilerError, Platform, find_compiler
from planter.version import __version__

Causality = Literal["input", "parameter", "output", "local"]
MAIN = "fmu.c"
"""The C file of a unit's sources that includes all others."""
TOKEN = "TOKEN_OF_THIS"
"""Placeholder in `MAIN` for the token of the unit."""

LOG_CATEGORIES = {
    "logStatusWarning": "where results lose digits",
    "logStatusError": "what went wrong",
}
"""Categories of messages, with their descriptions."""

_FRACTION = re.compile(r"\d\.\d")
_DATE = (1980, 1, 1, 0, 0, 0)
"""Date of every file in an archive: the earliest that the format allows."""
_PERMISSIONS = 0o100644


@dataclass(frozen=True)
class Variable:
    """A number of a unit, in SI units and radians.

    `factor` is the size of `display_unit` in SI; `start` and the range from `low` to `high` are in
    SI, None without one. A `fixed` parameter does not change after the start.
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


@dataclass(frozen=True)
class UnitModel:
    """Description of a unit; `name` is a C identifier.

    The reference of a variable is its index: `states`, inputs and parameters come first, then the
    rates of the states, then outputs, of which the last `events` are event indicators. The proposed
    simulation is a `period` [s] in `steps`.
    """

    name: str
    title: str
    meaning: str
    variables: tuple[Variable, ...]
    period: float
    steps: int
    states: int = 0
    events: int = 0

    @property
    def first_rate(self) -> int:
        """The number of variables that can be set, behind which the rates stand."""
        return sum(variable.start is not None for variable in self.variables)

    @property
    def unknowns(self) -> dict[str, list[int]]:
        """Indices of variables by the part that they have in the structure of the model."""
        first, count = self.first_rate, len(self.variables)
        rates = list(range(first, first + self.states))
        causes = enumerate(variable.causality for variable in self.variables)
        return {
            "Output": [index for index, causality in causes if causality == "output"],
            "Derivative": rates,
            "InitialUnknown": list(range(first, count)),
            "EventIndicator": list(range(count - self.events, count)),
        }


@dataclass(frozen=True)
class Version:
    """A version of the interface: its C file, the attribute with the unit's token, the first
    reference in the structure of a model, abilities of all units, that of units with derivatives,
    and folders of libraries by platform.
    """

    number: str
    source: str
    token: str
    first: int
    abilities: tuple[str, ...]
    differentiable: str
    folders: Mapping[str, str]

    def describe(self, model: UnitModel, token: str) -> dict[str, bytes]:
        """Return the descriptions of a model by their paths in the archive."""
        if self.number == "2.0":
            return {"modelDescription.xml": _format_xml(_describe_fmi2(self, model, token))}
        build = Element("fmiBuildDescription", fmiVersion="3.0")
        configuration = SubElement(build, "BuildConfiguration", modelIdentifier=model.name)
        files = SubElement(configuration, "SourceFileSet", language="C99")
        SubElement(files, "SourceFile", name=MAIN)
        return {
            "modelDescription.xml": _format_xml(_describe_fmi3(self, model, token)),
            "sources/buildDescription.xml": _format_xml(build),
        }


VERSIONS = {
    "2.0": Version(
        "2.0",
        "fmi2.c",
        "guid",
        1,
        (
            "canNotUseMemoryManagementFunctions",
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
        ),
        "providesDirectionalDerivative",
        {"linux64": "linux64", "win64": "win64"},
    ),
    "3.0": Version(
        "3.0",
        "fmi3.c",
        "instantiationToken",
        0,
        ("canGetAndSetFMUState", "canSerializeFMUState"),
        "providesDirectionalDerivatives",
        {"linux64": "x86_64-linux", "win64": "x86_64-windows"},
    ),
}


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


# --- descriptions --------------------------------------------------------------------------------


def _describe_fmi2(version: Version, model: UnitModel, token: str) -> Element:
    """Return `modelDescription.xml` of FMI 2.0, sections 2.2, 3.3 and 4.3 of the standard."""
    root, uses = _begin_description(version, model, token)
    if model.events:
        root.set("numberOfEventIndicators", str(model.events))
    for use in uses:
        SubElement(SubElement(use, "SourceFiles"), "File", name=MAIN)
    variables = SubElement(root, "ModelVariables")
    for role, values in _list_attributes(version, model):
        SubElement(SubElement(variables, "ScalarVariable", role), "Real", values)
    structure = SubElement(root, "ModelStructure")
    for part in ("Output", "Derivative", "InitialUnknown"):
        if indices := model.unknowns[part]:
            unknowns = SubElement(structure, f"{part}s")
            for index in indices:
                SubElement(unknowns, "Unknown", index=str(index + version.first))
    return root


def _describe_fmi3(version: Version, model: UnitModel, token: str) -> Element:
    """Return `modelDescription.xml` of FMI 3.0, section 2.4 of the standard."""
    root, _ = _begin_description(version, model, token)
    variables = SubElement(root, "ModelVariables")
    for role, values in _list_attributes(version, model):
        SubElement(variables, "Float64", role | values)
    time = {
        "name": "time",
        "valueReference": str(len(model.variables)),
        "description": "time",
        "causality": "independent",
        "variability": "continuous",
    }
    SubElement(variables, "Float64", time)
    structure = SubElement(root, "ModelStructure")
    names = {"Derivative": "ContinuousStateDerivative"}
    for part, indices in model.unknowns.items():
        for index in indices:
            SubElement(structure, names.get(part, part), valueReference=str(index))
    return root


def _begin_description(
    version: Version, model: UnitModel, token: str
) -> tuple[Element, list[Element]]:
    """Return the root of a description, up to its variables, and the elements of its uses."""
    attributes = {
        "fmiVersion": version.number,
        "modelName": model.title,
        version.token: token,
        "description": model.meaning,
        "generationTool": f"planter {__version__}",
        "variableNamingConvention": "structured",
    }
    root = Element("fmiModelDescription", attributes)
    # only states make a model that another program can integrate
    derivatives = (version.differentiable,) if model.states else ()
    abilities = dict.fromkeys((*version.abilities, *derivatives), "true")
    identifier = {"modelIdentifier": model.name}
    steps = {"canHandleVariableCommunicationStepSize": "true"}
    uses = [SubElement(root, "ModelExchange", identifier | abilities)] if model.states else []
    uses.append(SubElement(root, "CoSimulation", identifier | steps | abilities))
    _add_units(SubElement(root, "UnitDefinitions"), model.variables)
    categories = SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=description)
    experiment = {
        "startTime": "0",
        "stopTime": repr(model.period),
        "stepSize": repr(model.period / model.steps),
    }
    SubElement(root, "DefaultExperiment", experiment)
    return root, uses


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


def _list_attributes(
    version: Version, model: UnitModel
) -> Iterator[tuple[dict[str, str], dict[str, str]]]:
    """Yield role and values of each variable."""
    rates = model.unknowns["Derivative"]
    for index, variable in enumerate(model.variables):
        values = _describe_values(variable)
        if index in rates:
            values["derivative"] = str(index - model.first_rate + version.first)
        yield _describe_role(index, variable), values


def _describe_role(index: int, variable: Variable) -> dict[str, str]:
    """Return name, reference, causality and variability of a variable."""
    is_parameter = variable.causality == "parameter"
    tunable = "fixed" if variable.fixed else "tunable"
    attributes = {
        "name": variable.name,
        "valueReference": str(index),
        "description": variable.meaning,
        "causality": variable.causality,
        "variability": tunable if is_parameter else "continuous",
    }
    if variable.causality != "input":
        attributes["initial"] = "calculated" if variable.start is None else "exact"
    return attributes


def _describe_values(variable: Variable) -> dict[str, str]:
    """Return units, range and start of a variable."""
    attributes = {"unit": variable.unit}
    if variable.display_unit:
        attributes["displayUnit"] = variable.display_unit
    limits = {"min": variable.low, "max": variable.high, "start": variable.start}
    return attributes | {name: repr(value) for name, value in limits.items() if value is not None}


def _format_xml(root: Element) -> bytes:
    """Return XML with a line for each element."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True) + b"\n"


# --- sources, libraries, archives ----------------------------------------------------------------


def complete_sources(
    version: Version, model: UnitModel, texts: Mapping[str, str]
) -> tuple[str, dict[str, str]]:
    """Return the unit's token, a hash of its description and sources, and all sources with it, by
    name.

    `texts` are the model's own sources; among them `MAIN`, which contains the word `TOKEN` and
    includes `interface.c` last.
    """
    code = dict(texts)
    for name, file in {"interface.c": version.source, "core.c": "core.c"}.items():
        code[name] = resources.files(__package__).joinpath(file).read_text(encoding="utf-8")
    parts = [*version.describe(model, TOKEN).values()]
    for name, text in sorted(code.items()):
        parts += [name.encode(), text.encode()]
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
