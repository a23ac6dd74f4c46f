"""Every symbol, key and column can be explained, by what said so already; figures read the columns
that they claim.
"""

import csv
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.errors import InputError
from planter.explain import dictionary, mechanism, presentation
from planter.kernels import generated
from planter.records import schema
from tests.support import machines, own
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema


@cache
def named() -> set[str]:
    return {
        name
        for meaning in dictionary.collect_meanings()
        for name in (meaning.name, meaning.key)
        if name
    }


def numeric_keys(node: Any) -> Iterator[str]:
    """Keys of a schema, at any depth, below which a number may stand."""
    if isinstance(node, Mapping):
        for key, value in node.get("properties", {}).items():
            if dictionary.carries_number(value):
                yield key
        for value in node.values():
            yield from numeric_keys(value)


def test_every_numeric_schema_key_is_explained() -> None:
    keys = {
        key for command in schema.load_result_types() for key in numeric_keys(load_schema(command))
    }
    assert len(keys) > 200
    assert keys <= named()
    assert "made_up_N" not in named()


def test_every_model_symbol_is_explained() -> None:
    meanings = {(meaning.name, meaning.meaning) for meaning in dictionary.collect_meanings()}
    for name in generated.names():
        for vector in generated.sidecar(name).get("vectors", {}).values():
            for entry in vector if isinstance(vector, list) else ():
                assert (entry["name"], entry["meaning"]) in meanings


@pytest.mark.parametrize("name", ["wang2017-wide", "compact"])
def test_every_number_of_a_machine_file_is_explained(name: str) -> None:
    for path in machines.machine(name).numbers():
        key = path.partition("[")[0]
        assert {key, key.rpartition(".")[2]} & named(), path


def test_every_key_of_a_file_has_a_meaning_of_its_own() -> None:
    keys = [meaning for meaning in dictionary.collect_meanings() if meaning.kind == "file key"]
    shared = Counter((meaning.machine, meaning.source, meaning.meaning) for meaning in keys)
    assert len(keys) > 200
    assert [
        meaning.key
        for meaning in keys
        if shared[meaning.machine, meaning.source, meaning.meaning] > 1
    ] == []


def test_keys_of_a_mechanism_file_are_explained() -> None:
    source = own.file("transplanting_arm").source
    described = mechanism.explain_mechanism(source, {})

    def list_keys(key: str) -> list[str | None]:
        return [meaning.key for meaning in mechanism.find_meanings(described, source, key).meanings]

    assert list_keys("objective") == ["objective.least", "objective.samples"]
    assert list_keys("hold") == list_keys("requirements.hold") == ["requirements.hold"]
    assert list_keys("a_mm") == ["values.a_mm"]
    assert len(list_keys("genetic_algorithm")) == 6
    with pytest.raises(InputError, match="did you mean hold"):
        list_keys("holdd")


def test_every_column_of_the_planting_device_is_explained() -> None:
    for model in ("exact", "printed"):
        device = machines.device("wang2017", model)
        columns = device.columns(device.design, np.zeros(1))
        assert columns.keys() <= named()


CALLS = (
    ("train", "sun2019-curve"),
    ("synthesise", "sun2019-corrected"),
    ("pickup", "yu2023"),
    ("clutch", "field"),
    ("clutch", "geometry", "shi2021"),
    ("clutch", "engage", "shi2021", "--mode", "contact"),
)


@pytest.mark.parametrize(
    "call",
    [pytest.param(call, marks=[] if i == 0 else pytest.mark.long) for i, call in enumerate(CALLS)],
)
def test_every_written_column_is_explained(call: tuple[str, ...], tmp_path: Path) -> None:
    code, _, err = run(*call, "--out", str(tmp_path))
    assert code == 0, err
    written = list(tmp_path.rglob("*.csv"))
    assert written
    for path in written:
        head, *rows = (
            row for row in csv.reader(path.open(encoding="utf-8")) if not row[0].startswith("#")
        )
        numeric = [name for name, cell in zip(head, rows[0], strict=True) if _is_number(cell)]
        assert set(numeric) <= named(), path.name


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def test_a_name_has_unit_source_place_figures_and_verdict() -> None:
    (force,) = (
        meaning
        for meaning in dictionary.explain_name("F_B1x").meanings
        if meaning.machine == "planting"
    )
    assert (force.unit, force.key) == ("N", "F_B1x_N")
    (angle,) = (
        meaning
        for meaning in dictionary.explain_name("mu").meanings
        if meaning.machine == "planting"
    )
    assert angle.equations is not None
    assert (angle.equations[0].equation, angle.equations[0].verdict) == ("1", "confirmed")
    (ratio,) = (meaning for meaning in dictionary.explain_name("gears.poisson_ratio").meanings)
    assert ratio.allowed == "at least 0, less than 0.5, may be left out"
    (curve,) = (meaning for meaning in dictionary.explain_name("R3_mm").meanings)
    assert curve.meaning.startswith("radius of the eccentric circle")


def test_all_meanings_are_listed_with_machines() -> None:
    machines_ = {meaning.machine for meaning in dictionary.explain_name("mu").meanings}
    assert {"planting", "clutch"} <= machines_
    assert all("machine" in meaning for meaning in answer("explain", "mu")["meanings"])


def test_an_unknown_name_is_asked_back_and_all_names_are_listed() -> None:
    assert "did you mean F_B1" in refusal("explain", "F_B1z_N")
    names = answer("explain")["names"]
    assert "F_B1x" in names["planting"]
    assert "x_s" in names["mapping"]


def test_tables_fit_80_columns(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("range_N", "mu", "F_B1x"):
        presentation.show_meanings(dictionary.explain_name(name))
    presentation.show_names(dictionary.list_names())
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80
