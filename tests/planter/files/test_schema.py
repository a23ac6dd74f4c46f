"""The schemas of results: they are those of the types, every command's output fits its own,
tampered outputs do not.
"""

import copy
import json
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import jsonschema
import pytest

from planter.files import schema
from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema

CALLS = {
    "audit": ("yu2023",),
    "design clutch geometry": ("shi2021",),
    "about doctor": (),
    "about example": (),
    "about explain": ("F_B1x",),
    "about cite": ("optimise",),
    "new": (),
    "diff": ("yu2023", "yu2023"),
    "about help": ("units",),
    "about schema": (),
    "design clutch design": ("shi2021",),
    "design clutch optimise": ("shi2021", "--starts", "2"),
    "design clutch rotor": (),
    "design clutch engage": ("shi2021",),
    "design clutch field": (),
    "design clutch plan": ("L9",),
    "design synthesise": ("sun2019-corrected",),
    "design train": ("sun2019-curve",),
    "design pickup": ("yu2023", "--at", "0"),
    "simulate": ("wang2017-wide", "--at", "100"),
    "sensitivity": ("wang2017",),
    "optimise": ("wang2017", "--method", "ipopt", "--starts", "1", "--samples", "24"),
    "cam": ("wang2017", "--roller-mm", "5"),
    "simulate check": ("wang2017", "--set", "mass.sun_kg=100"),
}
"""A call of every command that is over soon; those of the others are held to their schemas in their
own tests.
"""
ELSEWHERE = {
    "animate",
    "audit benchmark",
    "about bench",
    "calibrate",
    "optimise all-pairs",
    "derive",
    "simulate motor",
    "export c",
    "export casadi",
    "export jax",
    "export rust",
    "export fmu",
    "export motion",
    "gears",
    "linearise",
    "optimise least",
    "prove",
    "sweep",
    "tolerance",
}


@cache
def output(command: str) -> str:
    words = command.replace(" check", " --check").split()
    return json.dumps(answer(*words, *CALLS[command]))


def fits(command: str, content: object) -> bool:
    return jsonschema.Draft202012Validator(load_schema(command)).is_valid(content)


def test_every_command_is_called_here_or_elsewhere() -> None:
    assert set(CALLS) | ELSEWHERE == set(schema.load_result_types())


@pytest.mark.parametrize("command", CALLS)
def test_outputs_fit(command: str) -> None:
    jsonschema.Draft202012Validator.check_schema(load_schema(command))
    jsonschema.validate(json.loads(output(command)), load_schema(command))


def keys(content: dict[str, Any], kind: type) -> Iterator[str]:
    return (key for key, value in content.items() if isinstance(value, kind))


TAMPERINGS: dict[str, Callable[[dict[str, Any]], object]] = {
    "a key too many": lambda result: result.update(surplus=1),
    "a key missing": lambda result: result.pop(next(iter(result))),
    "a text for a number": lambda result: result.update(
        {next(keys(result, str | float | int | bool | list | dict)): [{}]}
    ),
}


@pytest.mark.parametrize("command", CALLS)
@pytest.mark.parametrize("tampering", TAMPERINGS.values(), ids=TAMPERINGS.keys())
def test_tampered_outputs_do_not(
    command: str, tampering: Callable[[dict[str, Any]], object]
) -> None:
    result = json.loads(output(command))
    tampering(result)
    assert not fits(command, result)


def test_changed_unit_is_detected_at_depth() -> None:
    result = json.loads(output("design clutch geometry"))
    other = copy.deepcopy(result)
    other["travel"][0]["printed_cm"] = other["travel"][0].pop("printed_mm")
    assert fits("design clutch geometry", result)
    assert not fits("design clutch geometry", other)


def test_schema_command_prints_or_suggests() -> None:
    for name in ("design clutch geometry", "clutch geometry"):
        assert answer("about schema", *name.split()) == load_schema("design clutch geometry")
    assert answer("about schema")["commands"] == sorted(schema.load_result_types())
    assert "did you mean design clutch geometry" in refusal("schema", "clutch", "geometri")
