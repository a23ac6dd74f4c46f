"""The machine file of a model: the values that its statement gives, with units, meanings and bounds, as TOML."""

from __future__ import annotations

import json

from ..model import System
from ..quantity import Quantity, Vector

DATA = "data"
"""The packed input that holds what the statement gives values of."""


def of_system(system: System) -> dict[str, str]:
    """`NAME.toml` of a model whose statement gives values; nothing of any other."""
    return {f"{system.name}.toml": _text(system)} if system.data else {}


def _text(system: System) -> str:
    data = next(v.quantities for v in system.vectors if isinstance(v, Vector) and v.name == DATA)
    bounds = {q: system.data[q.name].bounds for q in data if q.name in system.data and system.data[q.name].bounds}
    lines = [
        f"# Values of {system.title}, as its statement gives them; copy this file to change them.",
        "",
        f"name = {json.dumps(system.name)}",
        f"description = {json.dumps(system.title, ensure_ascii=False)}",
        f"functions = {json.dumps(system.name)}",
        "",
        "[values]",
        *(_value(q, system) for q in data),
    ]
    if bounds:
        lines += ["", "[bounds]", *(f"{_key(q)} = [{pair[0]}, {pair[1]}]" for q, pair in bounds.items() if pair)]
    return "\n".join((*lines, "", "[turn]", "samples = 360", "", "[origin]", 'default = "assumed"', ""))


def _value(quantity: Quantity, system: System) -> str:
    datum, note = system.data.get(quantity.name), f"# {quantity.meaning}"
    return f"{_key(quantity)} = {datum.value}  {note}" if datum else f"# {_key(quantity)} =  {note}; not given"


def _key(quantity: Quantity) -> str:
    return quantity.shown.rpartition(".")[2]
