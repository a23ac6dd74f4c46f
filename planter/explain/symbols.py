"""Symbols of the generated models, with unit, meaning and source as the derivation gives them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from planter import rooms
from planter.audit import verdicts
from planter.explain.results import DefiningEquation, Meaning
from planter.files import units
from planter.gearing import families, stage
from planter.kernels import generated

SHARED = "gearing"
"""The machine that is told of symbols which several machines share."""


def found() -> Iterator[Meaning]:
    """Every symbol of every model, as often as models have it; then those that papers alone have."""
    papers = dict(_defined())
    for name in generated.names():
        machine = machine_of(name)
        for entry in _entries(generated.sidecar(name)):
            yield _meaning(machine, entry, papers.pop((machine, entry["name"]), None))
    yield from _parameters()
    for (machine, symbol), equations in papers.items():
        yield Meaning(symbol, "symbol", machine, "", equations[0].claims, equations[0].paper, equations=equations)


def machine_of(model: str) -> str:
    """The room of a generated model: what its name begins with, if that is a room."""
    first = model.partition("_")[0]
    return first if first in rooms.rooms() else SHARED


def key_of(entry: Mapping[str, str]) -> str | None:
    """Where a quantity is shown: in a file, or as a column."""
    if entry.get("shown"):
        return entry["shown"]
    return units.key(entry["name"], entry["unit"]) if units.has_key(entry["unit"]) else None


def _entries(sidecar: Mapping[str, Any]) -> Iterator[Mapping[str, str]]:
    """Quantities of all vectors and parameters; vectors whose length is open tell those that they know."""
    vectors = sidecar.get("vectors", {})
    for vector in (*vectors.values(), sidecar.get("parameters", ())):
        yield from vector if isinstance(vector, Sequence) else vector["known"].values()


def _meaning(machine: str, entry: Mapping[str, str], equations: list[DefiningEquation] | None) -> Meaning:
    return Meaning(
        name=entry["name"],
        kind="symbol",
        machine=machine,
        unit=entry["unit"],
        meaning=entry["meaning"],
        source=entry["source"],
        key=key_of(entry),
        equations=equations,
    )


def _parameters() -> Iterator[Meaning]:
    """Names of pitch curves' parameters in the design of a machine, by family and stage."""
    for name in generated.names():
        for vector in generated.sidecar(name).get("vectors", {}).values():
            if isinstance(vector, Mapping) and vector.get("suffix"):
                yield from _of_stage(machine_of(name), vector)


def _of_stage(machine: str, vector: Mapping[str, Any]) -> Iterator[Meaning]:
    for family in families.list_families():
        sidecar = families.load_sidecar(family)
        for key, entry in zip(stage.list_design_names(family, dict(vector)), sidecar["parameters"], strict=True):
            yield Meaning(
                name=key, kind="file key", machine=machine, unit=units.unit(key), source=entry["source"],
                meaning=f"{entry['meaning']} ({sidecar['title']}; {vector['meaning'].partition(',')[0]})",
                key=f"design.{key}",
            )  # fmt: skip


def _defined() -> dict[tuple[str, str], list[DefiningEquation]]:
    """Equations of the papers by the machine and the symbol that they define, with their verdicts."""
    papers = {
        file.name.removesuffix(".toml"): room for room, folder in rooms.folders("printed").items()
        for file in folder.iterdir() if file.name.endswith(".toml")
    }  # fmt: skip
    found: dict[tuple[str, str], list[DefiningEquation]] = {}
    for entry in verdicts.committed()["equations"]:
        if entry["defines"]:
            key = papers[entry["paper"]], entry["defines"]
            told = DefiningEquation(entry["paper"], entry["equation"], entry["verdict"], entry["claims"])
            found.setdefault(key, []).append(told)
    return found
