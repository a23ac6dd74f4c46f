"""A machine's name and what texts in C say of it: comments that list its numbers, quantities and equations."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import resources
from string import Template

from planter.engine.machine import Machine, Quantity, Value
from planter.files import units
from planter.kernels import Array
from planter.version import __version__

WIDTH = 116


@dataclass(frozen=True)
class SideQuantity:
    """A quantity of side 1, 2, .. of a machine or, with side 0, of all sides together.

    `name` is a plain word, beyond side 1 with the side's number behind it, as `key`, which ends in the unit of tables.
    `sides` is the number of the machine's sides.
    """

    name: str
    key: str
    side: int
    sides: int
    quantity: Quantity

    @property
    def meaning(self) -> str:
        """The meaning, with the side if there are several."""
        return f"{self.quantity.meaning}{f', side {self.side}' if self.side and self.sides > 1 else ''}"


def list_quantities(machine: Machine) -> list[SideQuantity]:
    """Return the results side by side, then those of all sides together."""
    sides = len(machine.offsets)
    found = [_of_side(q, side, sides) for side in range(1, sides + 1) for q in machine.results if not q.total]
    return found + [SideQuantity(q.name, q.key, 0, sides, q) for q in machine.results if q.total]


def _of_side(quantity: Quantity, side: int, sides: int) -> SideQuantity:
    name, key = quantity.name, quantity.key
    if side > 1:
        suffix = units.suffix(key)
        name, key = f"{name}_{side}", f"{key.removesuffix(suffix)}_{side}{suffix}"
    return SideQuantity(name, key, side, sides, quantity)


def list_fixed(machine: Machine) -> list[int]:
    """Return the indices of the values that a search does not move."""
    return [index for index in range(len(machine.values)) if index not in machine.moved]


def build_name(machine: Machine) -> str:
    """Return the machine's name as a C identifier, with the model where that is not the usual one."""
    name, variant = to_identifier(machine.name), machine.documentation.variant
    return f"{name}_{variant}" if variant else name


def to_identifier(text: str) -> str:
    """Return a text as a C identifier.

    >>> to_identifier("My machine 2!"), to_identifier("2nd")
    ('my_machine_2', 'm_2nd')
    """
    plain = re.sub(r"\W+", "_", text.lower(), flags=re.ASCII).strip("_")
    return plain if re.match(r"[a-z]", plain) else f"m_{plain}"


def read_template(file: str) -> Template:
    """Return a file beside this one."""
    return Template(resources.files(__package__).joinpath(file).read_text(encoding="utf-8"))


def describe(machine: Machine) -> dict[str, str]:
    """Return lines of comments: `headline`, `version`, and each number of `design` and `machine`."""
    fixed = [machine.values[index] for index in list_fixed(machine)]
    moved = [machine.values[index] for index in machine.moved]
    return {
        "headline": to_plain(build_headline(machine)),
        "version": __version__,
        "design": list_lines("Design x:", _number_values(moved, [value.key for value in moved], "x")),
        "machine": list_lines("Machine:", _number_values(fixed, [value.path for value in fixed], "machine")),
    }


def build_headline(machine: Machine) -> str:
    """Return the machine and its model in a line."""
    title = machine.documentation.title
    return f"{machine.name}: {title}" if title else machine.name


def describe_quantities(machine: Machine) -> str:
    """Return a line of comment for each quantity."""
    return list_lines("Quantities q:", _number_quantities(list_quantities(machine)))


def describe_equations(machine: Machine) -> str:
    """Return where the model comes from, what it assumes, and its equations, as lines of comments."""
    reference, assumptions = machine.documentation.reference, "; ".join(machine.assumptions)
    parts = [*([f"Source: {reference}."] if reference else []), *([f"Assumes: {assumptions}."] if assumptions else [])]
    return "\n".join([*map(wrap, parts), list_lines("Equations:", machine.documentation.equations)])


def list_lines(title: str, lines: Iterable[str]) -> str:
    """Return lines of a comment below a title."""
    wrapped = [wrap(line, "    ") for line in lines]
    return "\n".join([f" * {title}{'' if wrapped else ' none'}", *wrapped])


def wrap(text: str, indent: str = "") -> str:
    """Return a text as lines of a comment."""
    return textwrap.fill(
        to_plain(text), WIDTH, initial_indent=f" * {indent}", subsequent_indent=f" *   {indent}",
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def to_plain(text: str) -> str:
    """Return a text that ends no comment and starts none."""
    return " ".join(text.replace("*/", "* /").replace("/*", "/ *").split())


def quote(names: Iterable[str]) -> str:
    """Return names as C strings."""
    return ", ".join('"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"' for name in names)


def join_numbers(values: Array | Sequence[float]) -> str:
    """Return numbers as they read back, a zero if there are none."""
    return ", ".join(repr(float(value)) for value in values) or "0.0"


def join_integers(numbers: Iterable[int]) -> str:
    """Return integers for an array, a zero if there are none."""
    return ", ".join(str(int(number)) for number in numbers) or "0"


def _number_values(values: Sequence[Value], shown: Sequence[str], vector: str) -> Iterable[str]:
    for index, (value, path) in enumerate(zip(values, shown, strict=True)):
        source = f" ({value.source})" if value.source else ""
        yield f"{vector}[{index}] {path}: {value.name} [{value.unit}] {value.meaning}{source}"


def _number_quantities(quantities: Sequence[SideQuantity]) -> Iterable[str]:
    for index, one in enumerate(quantities):
        q = one.quantity
        side = f"; side {one.side}" if one.side and one.sides > 1 else ""
        source = f" ({q.source})" if q.source else ""
        yield f"q[{index}] {one.name} [{q.unit}] {q.meaning}{side}{source}"
