"""What `planter doctor` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class KernelFound(Record):
    """A function of the built-in machine, the way it is evaluated, and whether it is compiled."""

    name: str
    way: str
    compiled: bool


@dataclass(frozen=True)
class Examination(Record):
    """`planter doctor`: `compiler`, `flags` and `cache` are null where there is none; `extras` maps
    optional parts to whether they are installed, `advice` what is missing to what to do.
    """

    versions: dict[str, str]
    compiler: str | None
    flags: list[str] | None
    cache: str | None
    kernels: list[KernelFound]
    extras: dict[str, bool]
    advice: dict[str, str]


COMMANDS = {"doctor": Examination}
