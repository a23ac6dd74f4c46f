"""A device as C that stands alone: a header with units and equations, the kernels, and a small program.

The templates stand beside this file: `machine.h`, `machine.c`, `main.c`.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from string import Template
from typing import Any

import casadi as ca

from planter.kernels import Array, loops
from planter.kernels.loops import functions
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.quantities import Quantity, quantities
from planter.version import __version__

WIDTH = 116


def name(device: Device) -> str:
    """The machine's name as a C identifier, with the model where that is not the exact one.

    >>> _identifier("My machine 2!"), _identifier("2nd")
    ('my_machine_2', 'm_2nd')
    """
    own = _identifier(device.machine.name)
    return own if device.model == "exact" else f"{own}_{device.model}"


def _identifier(text: str) -> str:
    plain = re.sub(r"\W+", "_", text.lower(), flags=re.ASCII).strip("_")
    return plain if re.match(r"[a-z]", plain) else f"m_{plain}"


def source_files(device: Device) -> dict[str, str]:
    """The texts by file name: `NAME.h`, `NAME.c`, `NAME_main.c`."""
    own = name(device)
    values = _values(device, own)
    targets = {f"{own}.h": "machine.h", f"{own}.c": "machine.c", f"{own}_main.c": "main.c"}
    return {target: Template(template(source)).substitute(values) for target, source in targets.items()}


def template(file: str) -> str:
    """The text of a file beside this one."""
    return resources.files(__package__).joinpath(file).read_text(encoding="utf-8")


def turn_text() -> str:
    """The turn in C: to stand behind a device's kernels, or to be linked with them."""
    return template("weighed.c") + template("turn.c")


def _values(device: Device, own: str) -> dict[str, Any]:
    """What the templates ask for."""
    objective, offsets = weights(device.machine), device.force.offsets
    samples = device.machine.objective.samples
    angles = angles_of(device, samples)
    count = angles * len(offsets)
    response = device.force.response
    both: list[ca.Function] = [response.hoisting_kernel.function, response.prologue_kernel.function]
    work = {key: max(int(getattr(f, f"sz_{key}")()) for f in both) + 1 for key in ("arg", "res", "iw", "w")}
    found = quantities(device.sidecar)
    spread = "variance" if objective.kind == "paper" else "standard deviation"
    return {
        **description(device), "name": own, "NAME": own.upper(),
        "equations": _equations(device.sidecar),
        "half": ", half a turn: the other half is the same" * (angles < samples),
        "objective": f"{objective.weight_range!r} range + {objective.weight_variance!r} {spread}, wang2017 (31)",
        "parameters": len(device.design), "constants": len(device.constants), "samples": samples, "angles": angles,
        "values": len(device.data), "lanes": count, "slopes": (1 + len(device.design)) * count, "shares": len(offsets),
        "hoisted": both[1].nnz_out(0), "tangent": both[1].nnz_out(1), **work,
        "prologue": casadi_text(f"{own}_prologue", both), "kernels": _kernels(device, own),
        "renamed": _renamed(own, turn_text()), "turn": turn_text(),
        "own": _numbers(device.design), "lower": _numbers(device.lower), "upper": _numbers(device.upper),
        "data": _numbers(device.constants), "offsets": _numbers(offsets),
        "weight_range": repr(objective.weight_range), "weight_variance": repr(objective.weight_variance),
        "newton": int(objective.kind == "newton"), "names": _quoted(device.names),
        "side": device.cycle_kernel.function.size1_out(0), "totals": device.cycle_kernel.function.size1_out(2),
        "quantities": _listing("Quantities q:", _numbered(found)), "quantity": _quoted(q.name for q in found),
    }  # fmt: skip


def angles_of(device: Device, samples: int) -> int:
    """Samples that differ: where all shares of the force are equal, a part of the turn stands for all of it."""
    shares = len(device.force.offsets)
    return samples // shares if samples % shares == 0 else samples


def description(device: Device) -> dict[str, str]:
    """What this is, as lines of a comment: `headline`, `version`, and each number of `design` and `machine`."""
    return {
        "headline": _plain(headline(device)), "version": __version__,
        "design": _listing("Design x:", _named(device.names, device.entries, "x")),
        "machine": _listing("Machine:", _named(None, device.sidecar["vectors"]["machine"], "machine")),
    }  # fmt: skip


def headline(device: Device) -> str:
    """The machine, its model and its gear stages in a line."""
    families = " and ".join(stage.sidecar["title"] for stage in device.stages)
    return f"{device.machine.name}: {device.sidecar['title']}; {families}"


def casadi_text(file: str, both: Iterable[ca.Function]) -> str:
    """CasADi's C of functions; its helpers carry the file's name, so that they meet no others."""
    generator = ca.CodeGenerator(f"{file}.c")
    for function in both:
        generator.add(function)
    return str(generator.dump())


def _kernels(device: Device, own: str) -> str:
    """Force, slopes and all quantities as lane kernels of this file alone."""
    response = device.force.response
    works = [kernel.work for kernel in (response.values_kernel, response.slopes_kernel, device.cycle_kernel)]
    graphs = [loops.Graph.of(work.function, work.varying) for work in works]
    printed = [f"static {loops.function(graph, summed=False)}" for graph in graphs]
    return "\n".join([functions.source(own), *printed])


def _renamed(own: str, turn: str) -> str:
    """The turn's functions under the machine's name."""
    found = re.findall(r"^(?:int|long) (turn_\w+)\(", turn, flags=re.MULTILINE)
    return "".join(f"#define {function} {own}_{function}\n" for function in found)


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _numbers(values: Array | Sequence[float]) -> str:
    return ", ".join(repr(float(value)) for value in values)


def _named(names: Sequence[str] | None, entries: Sequence[Mapping[str, str]], vector: str) -> Iterable[str]:
    for index, entry in enumerate(entries):
        shown = names[index] if names else entry["shown"]
        yield f"{vector}[{index}] {shown}: {entry['name']} [{entry['unit']}] {entry['meaning']} ({entry['source']})"


def _numbered(found: Sequence[Quantity]) -> Iterable[str]:
    for index, q in enumerate(found):
        yield f"q[{index}] {q.name} [{q.unit}] {q.meaning}{f'; side {q.side}' if q.side else ''} ({q.source})"


def _equations(sidecar: Mapping[str, Any]) -> str:
    """Where the model comes from, what it assumes, and the equations that each line of the kernels is part of."""
    parts = [f"Source: {sidecar['source']}.", f"Assumes: {'; '.join(sidecar['assumptions'])}."]
    return "\n".join([*map(_wrapped, parts), _listing("Equations:", sidecar["equations"])])


def _listing(title: str, lines: Iterable[str]) -> str:
    return "\n".join([f" * {title}", *(_wrapped(line, "    ") for line in lines)])


def _wrapped(text: str, indent: str = "") -> str:
    return textwrap.fill(
        _plain(text), WIDTH, initial_indent=f" * {indent}", subsequent_indent=f" *   {indent}",
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _plain(text: str) -> str:
    """Text that ends no comment and starts none."""
    return " ".join(text.replace("*/", "* /").replace("/*", "/ *").split())
