"""The box that all pairs of families share: mounting, mean radius, relative swing and deformation of either stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from planter.errors import InputError
from planter.gear_geometry import families
from planter.gear_geometry.families import SUFFIX
from planter.planting import file
from planter.planting.file import Machine
from planter.planting.model import Device

REFERENCE = "wang2017-wide"
"""Built-in machine whose box for the mounting, and whose requirements, serve where the machine has none."""
NARROW = "wang2017"
"""Built-in machine with the paper's own bounds."""
SIZE_MM, SWING, DEFORMATION = (24.0, 36.0), (0.02, 0.5), (0.8, 1.8)
"""Mean radius, relative swing of the ratio and deformation coefficient of a stage: assumed."""
Pair = tuple[str, str]


def pairs() -> list[Pair]:
    """Every family of the registry on the sun with every one on gear 6."""
    return [(one, two) for one in families.list_families() for two in families.list_families()]


def required(own: Machine) -> Machine:
    """The machine with requirements: its own, else those of the reference, and a speed over ground with them."""
    if own.requirements is not None:
        return own
    table, reference = own.table(), file.load(REFERENCE).table()
    table["requirements"] = reference["requirements"]
    if not own.operation.forward_speed_m_s:
        table["operation"]["forward_speed_m_s"] = reference["operation"]["forward_speed_m_s"]
    return Machine.read(table, own.source)


def narrow(own: Machine) -> Machine:
    """The machine in the paper's design and bounds, where those have its names; else in its own."""
    paper, wanted = file.load(NARROW), required(own)
    if set(paper.design) != set(own.design):
        return wanted
    table = wanted.table() | {"design": dict(paper.design), "bounds": dict(paper.bounds)}
    return Machine.read(table, own.source)


def described(own: Machine, pair: Pair) -> Machine:
    """The machine with a pair of families in the shared box, its design as near to the machine's own as that can be."""
    table = own.table()
    device = Device(own)
    wide = file.load(REFERENCE).bounds
    mounting = [entry["shown"] for entry in device.sidecar["vectors"]["mounting"]]
    bounds: dict[str, Any] = {name: _around(wide[name], own.design[name]) for name in mounting}
    design: dict[str, float] = {name: own.design[name] for name in mounting}
    for number, family in enumerate(pair, 1):
        box, start = _stage(device, number, family)
        bounds |= box
        design |= {name: float(np.clip(value, *box[name])) for name, value in start.items()}
        table[f"stage{number}"] = {"family": family + SUFFIX}
    origin = {name: text for name, text in table["origin"].items() if name.split(".")[0] in table}
    kept = {name: text for name, text in origin.items() if name.split(".")[0] not in ("design", "bounds")}
    table |= {"design": design, "bounds": bounds, "origin": {"default": "assumed", **kept}}
    return Machine.read(table, f"{own.source}, {pair[0]} and {pair[1]}")


def _around(bounds: tuple[float, float], value: float) -> tuple[float, float]:
    return min(bounds[0], value), max(bounds[1], value)


def _stage(device: Device, number: int, family: str) -> tuple[dict[str, tuple[float, float]], dict[str, float]]:
    """Box and start of a stage's description: that of the device's own curve."""
    vector = device.sidecar["vectors"][f"parameters{number}"]
    suffix, last = vector["suffix"], vector["known"]["-1"]["shown"]
    size, swing, m = curve(device, number - 1)
    shapes = families.load_sidecar(family)["shapes"]
    box = {f"size{suffix}_mm": SIZE_MM, f"swing{suffix}": SWING,
           **{f"{s['name']}{suffix}": (s["lower"], s["upper"]) for s in shapes}, last: DEFORMATION}  # fmt: skip
    start = dict(zip(box, (1e3 * size, swing, *(0.0 for _ in shapes), m), strict=True))
    return box, start


def curve(device: Device, stage: int) -> tuple[float, float, float]:
    """Mean radius [m], relative swing of the ratio and deformation coefficient of a device's own stage."""
    start = len(device.sidecar["vectors"]["mounting"]) + (len(device.stages[0].names) if stage else 0)
    gears = device.stages[stage]
    parameters = device.design[start : start + len(gears.names)]
    hoisted = gears.prologue(parameters=parameters)["hoisted"]
    ends = np.array([0.0, np.pi / parameters[-1]])
    high, low = gears.contact(t=ends, parameters=parameters, hoisted=hoisted)["ratio"][0]
    return float(hoisted[0, 0] / 2), float((high - low) / (high + low)), float(parameters[-1])


def chosen(texts: list[str] | None) -> list[Pair] | None:
    """Pairs given as `family+family`; None where none are given. Raises InputError for what is not two families."""
    if not texts:
        return None
    found = [tuple(text.split("+")) for text in texts]
    for text, pair in zip(texts, found, strict=True):
        if len(pair) != 2 or not set(pair) <= set(families.list_families()):
            allowed = f"it must be two of {', '.join(families.list_families())} with + between them"
            raise InputError(f"--pair {text} is not allowed: {allowed}")
    return [(pair[0], pair[1]) for pair in found]
