"""The dictionary of all meanings by name, and suggestions for unknown names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from planter import paths, plugins
from planter.audit import verdicts
from planter.cli.results import DefiningEquation, Explained, KnownNames, Meaning
from planter.engine.machine import describe_vector
from planter.errors import InputError
from planter.files import fields, schema, units
from planter.files.document import Document
from planter.files.fields import LARGEST
from planter.files.spelling import find_spelled, list_spellings
from planter.gears.geometry import families, stage
from planter.kernels import generated
from planter.report.labels import FILE, load_names


@cache
def collect_meanings() -> tuple[Meaning, ...]:
    """Return all meanings: symbols, keys of files and results, columns."""
    symbols = list(list_symbols())
    symbols += _list_vectors({(meaning.machine, meaning.name): meaning for meaning in symbols})
    by_key = {(meaning.machine, meaning.key): meaning.meaning for meaning in symbols if meaning.key}
    unique: dict[tuple[str, ...], Meaning] = {}
    for meaning in (*symbols, *list_input_keys(by_key), *list_result_keys(), *list_columns()):
        entry = (meaning.kind, meaning.machine, meaning.name, meaning.unit, meaning.meaning)
        unique.setdefault(entry, meaning)
    return tuple(unique.values())


def explain_name(name: str) -> Explained:
    """Return every meaning of a symbol or key, as `select_meanings`."""
    return select_meanings(
        collect_meanings(),
        name,
        "NAME",
        "is not a symbol or key",
        "`planter about explain` lists all names",
    )


def list_meanings(package: str) -> list[Meaning]:
    """Return all meanings of a kind of machine."""
    return [meaning for meaning in collect_meanings() if meaning.machine == package]


def select_meanings(
    meanings: Sequence[Meaning], name: str, label: str, reason: str, otherwise: str
) -> Explained:
    """Return the meanings of a name, of a file's key by its last part as well, or else of all keys
    of a section.

    Raises InputError for an unknown name: `label` and `reason`, then similar names or, without one,
    `otherwise`.
    """
    selected = [m for m in meanings if name in (m.name, m.key, paths.last_part(m.key or ""))]
    if not selected:
        matches = find_spelled(
            name, {index: _list_spellings(meaning) for index, meaning in enumerate(meanings)}
        )
        selected = [meanings[index] for index in matches]
    selected = selected or [
        m for m in meanings if m.kind == "file key" and (m.key or "").startswith(f"{name}.")
    ]
    if not selected:
        names = sorted({key for meaning in meanings for key in (meaning.name, meaning.key) if key})
        raise InputError.for_value(
            label, name, f"it {reason}: {paths.suggest_names(name, names, otherwise)}"
        )
    return Explained(name, selected)


def _list_spellings(meaning: Meaning) -> tuple[str, ...]:
    key = paths.last_part(meaning.key or meaning.name)
    return list_spellings(meaning.name, key, meaning.meaning, tuple(meaning.components or ()))


def list_names() -> KnownNames:
    """Return all names by machine or command."""
    by_machine: dict[str, set[str]] = {}
    for meaning in collect_meanings():
        by_machine.setdefault(meaning.machine, set()).add(meaning.name)
    return KnownNames(
        {machine: sorted(machine_names) for machine, machine_names in sorted(by_machine.items())}
    )


def list_columns() -> Iterator[Meaning]:
    """Yield the columns of CSV files that the names of packages have."""
    for package, module in plugins.find_packages().items():
        if resources.files(module).joinpath(FILE).is_file():
            for name, meaning in load_names(module).list_columns().items():
                unit = units.display_unit(name)
                yield Meaning(name, "column", package, unit, meaning, "CSV files")


SHARED_ROOM = "gearing"
"""Machine name of the symbols that several machines share."""


def list_symbols() -> Iterator[Meaning]:
    """Yield every symbol of every model, then those that only papers define."""
    papers = dict(_load_definitions())
    for name in generated.names():
        machine = find_model_package(name)
        for entry in _list_entries(generated.sidecar(name)):
            yield _describe_symbol(machine, entry, papers.pop((machine, entry["name"]), None))
    yield from _list_parameters()
    for (machine, symbol), equations in papers.items():
        yield Meaning(
            symbol,
            "symbol",
            machine,
            "",
            equations[0].claims,
            equations[0].paper,
            equations=equations,
        )


def _list_vectors(symbols: Mapping[tuple[str, str], Meaning]) -> Iterator[Meaning]:
    """Yield the sizes of the vectors that machines report; `symbols` are meanings by machine and
    name.
    """
    for module in (*plugins.load_modules("model"), *plugins.load_modules("machines")):
        package = plugins.name_package(module)
        for name, components in getattr(module, "VECTORS", {}).items():
            first = symbols.get((package, components[0]))
            if first is not None and (package, name) not in symbols:
                meaning = f"size of {', '.join(components)}: {describe_vector(name, first.meaning)}"
                key = units.display_key(name, first.unit)
                yield Meaning(
                    name,
                    "symbol",
                    package,
                    first.unit,
                    meaning,
                    first.source,
                    key,
                    components=list(components),
                )


def find_model_package(model: str) -> str:
    """Return the machine of a generated model by the first part of its name."""
    first = model.partition("_")[0]
    return first if first in plugins.find_packages() else SHARED_ROOM


def find_display_key(entry: Mapping[str, str]) -> str | None:
    """Return the key of a quantity in a file or as a column, or None."""
    if entry.get("shown"):
        return entry["shown"]
    return units.display_key(entry["name"], entry["unit"]) if units.has_key(entry["unit"]) else None


def _list_entries(sidecar: Mapping[str, Any]) -> Iterator[Mapping[str, str]]:
    """Yield the quantities of all vectors and parameters; of vectors with open length the declared
    ones. Those of loads on bodies have no names of their own.
    """
    if "loads" in sidecar:
        return
    vectors = sidecar.get("vectors", {})
    for vector in (*vectors.values(), sidecar.get("parameters", ())):
        yield from vector if isinstance(vector, Sequence) else vector["known"].values()


def _describe_symbol(
    machine: str, entry: Mapping[str, str], equations: list[DefiningEquation] | None
) -> Meaning:
    return Meaning(
        name=entry["name"],
        kind="symbol",
        machine=machine,
        unit=entry["unit"],
        meaning=entry["meaning"],
        source=entry["source"],
        key=find_display_key(entry),
        equations=equations,
    )


def _list_parameters() -> Iterator[Meaning]:
    """Yield the names of pitch-curve parameters in the design of a machine, by family and stage."""
    for name in generated.names():
        for vector in generated.sidecar(name).get("vectors", {}).values():
            if isinstance(vector, Mapping) and vector.get("suffix"):
                yield from _describe_stage(find_model_package(name), vector)


def _describe_stage(machine: str, vector: Mapping[str, Any]) -> Iterator[Meaning]:
    for family in families.list_families():
        sidecar = families.load_sidecar(family)
        for key, entry in zip(
            stage.list_design_names(family, dict(vector)), sidecar["parameters"], strict=True
        ):
            yield Meaning(
                name=key,
                kind="file key",
                machine=machine,
                unit=units.display_unit(key),
                source=entry["source"],
                meaning=f"{entry['meaning']} ({sidecar['title']}; "
                f"{vector['meaning'].partition(',')[0]})",
                key=f"design.{key}",
            )


def _load_definitions() -> dict[tuple[str, str], list[DefiningEquation]]:
    """Return the equations of the papers with their verdicts, by machine and defined symbol."""
    papers = {
        file.name.removesuffix(".toml"): package
        for package, folder in plugins.find_folders("printed").items()
        for file in folder.iterdir()
        if file.name.endswith(".toml")
    }
    equations: dict[tuple[str, str], list[DefiningEquation]] = {}
    for entry in verdicts.load_verdicts()["equations"]:
        if entry["defines"]:
            key = papers[entry["paper"]], entry["defines"]
            definition = DefiningEquation(
                entry["paper"], entry["equation"], entry["verdict"], entry["claims"]
            )
            equations.setdefault(key, []).append(definition)
    return equations


BOUNDS = {
    Gt: ("greater than", "gt"),
    Ge: ("at least", "ge"),
    Lt: ("less than", "lt"),
    Le: ("at most", "le"),
}
TIGHTEST: dict[str, Callable[..., float]] = {
    "greater than": max,
    "at least": max,
    "less than": min,
    "at most": min,
}


def list_input_keys(symbols: Mapping[tuple[str, str], str]) -> Iterator[Meaning]:
    """Yield every key with a value; `symbols` has meanings by machine and path of the value in the
    file.
    """
    for module in plugins.load_modules("file"):
        package = plugins.name_package(module)
        for kind in vars(module).values():
            if isinstance(kind, type) and issubclass(kind, Document) and kind is not Document:
                yield from _list_section(package, kind, "", symbols)


def _list_section(
    package: str, kind: type[BaseModel], before: str, symbols: Mapping[tuple[str, str], str]
) -> Iterator[Meaning]:
    for key, field in fields.list_fields(kind).items():
        path = f"{before}.{key}" if before else key
        inner = fields.find_section(field.annotation)
        if inner is not None:
            yield from _list_section(package, inner, path, symbols)
        else:
            yield _describe_key(package, kind, path, field, symbols)


def _describe_key(
    package: str,
    kind: type[BaseModel],
    path: str,
    field: FieldInfo,
    symbols: Mapping[tuple[str, str], str],
) -> Meaning:
    meaning = symbols.get((package, path)) or "; ".join(
        text
        for (owner, place), text in symbols.items()
        if owner == package and place.startswith(f"{path}[")
    )
    section = " ".join((kind.__doc__ or "").split()).partition(". ")[0].rstrip(".")
    return Meaning(
        name=paths.last_part(path),
        kind="file key",
        machine=package,
        unit=units.display_unit(path),
        meaning=meaning or field.description or section,
        source=f"[{path.rpartition('.')[0]}]" if "." in path else "top of the file",
        key=path,
        allowed=_describe_bounds(field),
    )


def _describe_bounds(field: FieldInfo) -> str | None:
    """Return the tightest bounds of the field's type, and whether it may be left out."""
    bounds = list(_list_bounds(field.metadata, field.annotation))
    limits = [
        f"{words} {tightest(value for word, value in bounds if word == words):g}"
        for words, tightest in TIGHTEST.items()
        if any(word == words and abs(value) < LARGEST for word, value in bounds)
    ]
    if not field.is_required():
        limits.append("may be left out")
    return ", ".join(limits) or None


def _list_bounds(metadata: Sequence[Any], annotation: Any) -> Iterator[tuple[str, float]]:
    """Yield kind and value of each bound in a type, including those of a list's items."""
    for item in metadata:
        if type(item) in BOUNDS:
            words, name = BOUNDS[type(item)]
            yield words, float(getattr(item, name))
        elif isinstance(item, FieldInfo):
            yield from _list_bounds(item.metadata, None)
    if get_origin(annotation) is not None:
        for inner in get_args(annotation):
            yield from _list_bounds(
                getattr(inner, "__metadata__", ()), getattr(inner, "__origin__", inner)
            )


NUMBERS = {"number", "integer"}
_SENTENCE = re.compile(r"(?<=[.!?])\s+")


def list_result_keys() -> Iterator[Meaning]:
    """Yield every numeric key, once for each record that has it, with the commands that return it."""
    for module in plugins.load_modules("results"):
        package = plugins.name_package(module)
        places: dict[tuple[str, str], list[str]] = {}
        for command, kind in module.COMMANDS.items():
            for key, meaning in _list_numbers(command, kind):
                places.setdefault((key, meaning), []).append(command)
        for (key, meaning), commands in places.items():
            source = f"planter {', '.join(dict.fromkeys(commands))} --json"
            yield Meaning(key, "result key", package, units.display_unit(key), meaning, source)


def _list_numbers(command: str, kind: Any) -> Iterator[tuple[str, str]]:
    """Yield the numeric keys of a command's schema with the descriptions of their records."""
    root = schema.build_schema(command, kind)
    for table in (*root.get("$defs", {}).values(), root):
        for key, value in table.get("properties", {}).items():
            if carries_number(value):
                yield key, find_description(key, table["description"])


def carries_number(value: Mapping[str, Any]) -> bool:
    """Return whether a key's schema allows a number, directly or within lists and tables of plain
    values.
    """
    if value.get("type") in NUMBERS:
        return True
    inner = [*value.get("anyOf", ()), *value.get("prefixItems", ())]
    inner += [
        value[name]
        for name in ("items", "additionalProperties")
        if isinstance(value.get(name), Mapping)
    ]
    return any(carries_number(option) for option in inner)


def find_description(key: str, text: str) -> str:
    """Return the sentences of a record's description that name a key, else the first with the words
    of the key.

    >>> find_description("spread", "A certificate. `spread` is how far starts end apart.")
    '`spread` is how far starts end apart.'
    >>> find_description("mean_N", "Samples of a force: extremes and mean.")
    'mean: samples of a force: extremes and mean'
    """
    sentences = _SENTENCE.split(" ".join(text.split()))
    naming = [sentence for sentence in sentences if f"`{key}`" in sentence]
    if naming:
        return " ".join(naming)
    words = key.removesuffix(units.unit_suffix(key)).replace("_", " ")
    first = sentences[0].rstrip(".")
    return f"{words}: {first[:1].lower()}{first[1:]}"
