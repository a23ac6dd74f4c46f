"""Results of the commands of this room, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.engine.proof.proof_results import ProofCheck
from planter.files.record import Record


@dataclass(frozen=True)
class Cited(Record):
    """A work: its key, what it is behind, in words, and as an entry of BibTeX."""

    key: str
    behind: str
    text: str
    bibtex: str


@dataclass(frozen=True)
class Citations(Record):
    """`planter about cite NAME`: the works behind a command, or one work."""

    name: str
    works: list[Cited]


@dataclass(frozen=True)
class Citable(Record):
    """`planter about cite`: keys of the works, and of works by the command that rests on them."""

    works: list[str]
    commands: dict[str, list[str]]


@dataclass(frozen=True)
class Examples(Record):
    """`planter example`: names of the built-in files, and what each has, by name."""

    examples: list[str]
    descriptions: dict[str, str]


@dataclass(frozen=True)
class Example(Record):
    """`planter example NAME`: a built-in file."""

    name: str
    text: str


@dataclass(frozen=True)
class Derived(Record):
    """`planter derive FILE`: the folder that was written to, and the files there."""

    folder: str
    files: list[str]


@dataclass(frozen=True)
class Listed(Record):
    """`planter about schema`: commands whose results have a schema."""

    commands: list[str]


@dataclass(frozen=True)
class Templates(Record):
    """`planter new`: what each template is, by name."""

    templates: dict[str, str]


@dataclass(frozen=True)
class TemplateWritten(Record):
    """`planter new TEMPLATE`: the files that were written, and the commands to type next."""

    template: str
    files: list[str]
    next: list[str]


@dataclass(frozen=True)
class Topics(Record):
    """`planter help`: what there is to read; titles of pages and meanings of words by name."""

    topics: list[str]
    pages: dict[str, str]
    words: dict[str, str]


@dataclass(frozen=True)
class Topic(Record):
    """`planter help NAME`: the text of a topic, a page or a word."""

    topic: str
    text: str


@dataclass(frozen=True)
class ComparedMachine(Record):
    """A machine of a comparison, and the kind that all machines share."""

    name: str
    file: str
    kind: str


@dataclass(frozen=True)
class ComparedValue(Record):
    """A value of the files that differs, for each machine; null where a file has none."""

    name: str
    unit: str
    values: list[bool | float | str | None]


@dataclass(frozen=True)
class ComparedResult(Record):
    """A result of each machine, by true extremes and integrals over a cycle.

    `difference` is that of each further machine from the first. `better` is the index of the best
    machine where a direction is stated (the objective and its terms, margins of requirements), null
    if none is or none is best.
    """

    name: str
    unit: str
    values: list[float | None]
    difference: list[float | None]
    better: int | None


@dataclass(frozen=True)
class ComparedRequirement(Record):
    """A limit on each machine: the values, and whether they satisfy it; null where a machine has no
    such value.
    """

    limit_on: str
    limit: float
    unit: str
    values: list[float | None]
    met: list[bool | None]


@dataclass(frozen=True)
class ComparedCurve(Record):
    """A quantity of each machine (m, n) at the angles of the drive (n,) [deg], or, of what moves
    freely, at times (n,) [s].
    """

    name: str
    unit: str
    phi_deg: list[float] | None
    values: list[list[float]]
    t_s: list[float] | None = None


@dataclass(frozen=True)
class MachineComparison(Record):
    """`planter diff`: machines of one kind, values that differ, results, requirements and curves
    side by side.
    """

    machines: list[ComparedMachine]
    values: list[ComparedValue]
    results: list[ComparedResult]
    requirements: list[ComparedRequirement]
    curves: list[ComparedCurve]


@dataclass(frozen=True)
class DefiningEquation(Record):
    """A printed equation that defines a symbol, its verdict in the audit, and its claim."""

    paper: str
    equation: str
    verdict: str
    claims: str


@dataclass(frozen=True)
class Meaning(Record):
    """The meaning of a name in a machine: kind, unit, description, source, key and verdicts.

    `kind` is symbol, file key, result key or column; `allowed` are the bounds of a file's number; `key` is
    the name under which files and results show a symbol. Of one machine `kind` is value, quantity
    or check; `value` is in the unit of its key, and `origin` is its source. `components` are those
    of a vector, whose size the name means.
    """

    name: str
    kind: str
    machine: str
    unit: str
    meaning: str
    source: str
    key: str | None = None
    allowed: str | None = None
    equations: list[DefiningEquation] | None = None
    value: float | None = None
    origin: str | None = None
    components: list[str] | None = None


@dataclass(frozen=True)
class Explained(Record):
    """`planter about explain NAME`: every meaning of a name."""

    name: str
    meanings: list[Meaning]


@dataclass(frozen=True)
class KnownNames(Record):
    """`planter about explain`: all names by machine."""

    names: dict[str, list[str]]


@dataclass(frozen=True)
class DrawnSheet(Record):
    """A drawing of a machine: its name, its title, and the symbols on it."""

    name: str
    title: str
    symbols: list[Meaning]


@dataclass(frozen=True)
class ExplainedFunction(Record):
    """A function of a machine: its inputs, and the numbers of its results and operations."""

    name: str
    inputs: list[str]
    outputs: int
    operations: int | None


@dataclass(frozen=True)
class ExplainedMachine(Record):
    """`planter about explain MACHINE`: its values, quantities, functions and drawings; `files` were
    written by `--out`.
    """

    machine: str
    kind: str
    title: str
    source: str
    assumptions: list[str]
    values: list[Meaning]
    quantities: list[Meaning]
    functions: list[ExplainedFunction]
    sheets: list[DrawnSheet]
    files: list[str]


@dataclass(frozen=True)
class BodyLoadFound(Record):
    """A force and a moment on a body at a point, along the axes x, y, z of the world; `by` is null
    for weight and inertia.
    """

    name: str
    by: str | None
    at: str
    place_mm: list[float]
    force_N: list[float]
    moment_Nm: list[float]


@dataclass(frozen=True)
class FreeBodyFound(Record):
    """A body that is cut free, with its loads and their sums, moments about the place of the first."""

    name: str
    loads: list[BodyLoadFound]
    force_sum_N: list[float]
    moment_sum_Nm: list[float]


@dataclass(frozen=True)
class FreeBodiesFound(Record):
    """`planter about explain MACHINE --bodies --at DEG`: all bodies with their loads; `files` were written
    by `--out`.
    """

    machine: str
    at_deg: float
    bodies: list[FreeBodyFound]
    files: list[str]


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


WORKS = ("cycle", "cycle+gradient", "hessian", "batch", "optimise", "derive", "cold start")
QUICK_WORKS = ("cycle", "cycle+gradient", "optimise")


@dataclass(frozen=True)
class WayTimes(Record):
    """Median duration of a way to do a task, and its ratio to that of the reference."""

    way: str
    median_us: float
    ratio: float
    calls: int


@dataclass(frozen=True)
class TaskTimes(Record):
    """A task with the times of its ways; `skipped` has the reasons why others take no part."""

    name: str
    unit: str
    ways: list[WayTimes]
    skipped: dict[str, str]


@dataclass(frozen=True)
class Benchmark(Record):
    """All tasks of one run; `skipped` has the reasons why tasks were not done."""

    work: list[TaskTimes]
    machine: dict[str, str | int | None]
    versions: dict[str, str]
    skipped: dict[str, str]


COMMANDS = {
    "new": Templates | TemplateWritten,
    "about example": Examples | Example,
    "derive": Derived,
    "about schema": Listed,
    "about help": Topics | Topic,
    "about cite": Citations | Citable,
    "prove": ProofCheck,
    "diff": MachineComparison,
    "about explain": Explained | KnownNames | ExplainedMachine | FreeBodiesFound,
    "about doctor": Examination,
    "about bench": Benchmark,
}
