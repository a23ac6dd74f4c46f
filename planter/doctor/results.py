"""What `planter doctor` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class Versions(Record):
    """Versions of what functions are made and run with."""

    planter: str
    python: str
    casadi: str
    numpy: str
    c_library: str | None


@dataclass(frozen=True)
class Processor(Record):
    """Kind of processor, and how many cores."""

    machine: str
    cores: int | None


@dataclass(frozen=True)
class CompilerFound(Record):
    """The C compiler; `bundled` if it is the one of the extra `compiler`."""

    path: str
    version: str
    flags: list[str]
    vector_bits: int
    bundled: bool


@dataclass(frozen=True)
class NoCompilerFound(Record):
    """Why there is no C compiler."""

    problem: str


@dataclass(frozen=True)
class Cache(Record):
    """The folder of compiled functions, and what is wrong with it; null if it is missing or
    intact.
    """

    folder: str | None
    exists: bool
    files: int
    bytes: int
    damaged: int
    problem: str | None


@dataclass(frozen=True)
class KernelFound(Record):
    """A function of the built-in machine, the way it is evaluated, and whether it is compiled
    already.
    """

    model: str
    name: str
    instructions: int
    way: str
    compiled: bool


@dataclass(frozen=True)
class Extra(Record):
    """An optional part of the package: `pip install 'planter[NAME]'`."""

    name: str
    installed: bool
    purpose: str


@dataclass(frozen=True)
class Advice(Record):
    """A missing part, and how to install it."""

    missing: str
    do: str


@dataclass(frozen=True)
class Examination(Record):
    """`planter doctor`: what this installation has, and what would make it faster."""

    versions: Versions
    processor: Processor
    compiler: CompilerFound | NoCompilerFound
    cache: Cache
    machine: str
    kernels: list[KernelFound]
    extras: list[Extra]
    advice: list[Advice]


COMMANDS = {"doctor": Examination}
