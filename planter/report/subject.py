"""Descriptions of commands that export a machine, so that the studio can run them."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from planter import plugins, safe_text
from planter.errors import InputError, PlanterError
from planter.files import units
from planter.files.document import Document, format_lines
from planter.files.examples import find_kind, load_part, refuse_machine
from planter.kernels import Array
from planter.kernels.programs import Program
from planter.report import labels
from planter.report.labels import DisplayName, DisplayNames
from planter.report.scene import Scene
from planter.version import __version__


@dataclass(frozen=True)
class RequiredOption:
    """A positive number that a command requires and that machine files do not have, with its
    option.
    """

    option: str
    meaning: str
    value: float


@dataclass(frozen=True)
class Export:
    """An export by `planter WORDS MACHINE OPTIONS --out FOLDER`, with `--model` if the machine has
    several models.

    `file` is the name of the file for a command that writes a single one.
    """

    name: str
    meaning: str
    words: Sequence[str]
    options: Sequence[str] = ()
    asks: Sequence[RequiredOption] = ()
    modelled: bool = False
    file: str = ""

    def command(
        self, machine: Path, folder: Path, model: str, numbers: Mapping[str, float]
    ) -> list[str]:
        """Return the command line for a machine's file, with numbers by option; `folder` must
        exist.

        Raises InputError if a number is not positive.
        """
        words = [
            *self.words,
            str(machine),
            *self.options,
            *(("--model", model) if self.modelled else ()),
        ]
        for required in self.asks:
            value = numbers.get(required.option, required.value)
            if not (isinstance(value, int | float) and 0 < value < float("inf")):
                raise InputError(
                    f"{required.meaning} = {safe_text.format_value(value)}: a positive number is "
                    f"required"
                )
            words += [required.option, repr(float(value))]
        return [*words, "--out", str(folder / self.file)]


ANIMATION = Export("animation", "a turn as it is seen (GIF)", ("animate",), file="moving.gif")
"""Export that every machine has."""


Values = Mapping[str, float]
"""Numbers by path, in the units that end their keys."""
STEPS = 512
"""Number of steps between a number and an end at which the file is validated."""
REACH = 0.5
"""Range of a number without bounds to either side, relative to its value."""


@dataclass(frozen=True)
class Control:
    """A number that a user can change: its path, meaning, unit, value and bounds, and its name,
    symbol and group.
    """

    path: str
    meaning: str
    unit: str
    value: float
    lower: float
    upper: float
    name: str
    symbol: str
    group: str

    def to_json(self) -> dict[str, Any]:
        """Return the control as a JSON object for a page."""
        return asdict(self)


@dataclass(frozen=True)
class Reading:
    """A computed number."""

    name: str
    unit: str
    value: float | None


@dataclass(frozen=True)
class RequirementCheck:
    """A requirement with its margin, and whether it is satisfied; `value` is None if only the
    margin is known.

    `lower` and `upper` are its limits in the unit, None on a side without one. `label` is its name
    on a page where that is another one, and `phi_deg` the angle at which it is closest to its
    limit, None if it belongs to no angle.
    """

    name: str
    unit: str
    value: float | None
    margin: float | None
    met: bool
    lower: float | None = None
    upper: float | None = None
    label: str = ""
    phi_deg: float | None = None


@dataclass(frozen=True)
class DetailTable:
    """A table; the first cell of a row is its heading."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]


class Shown(Protocol):
    """A machine with numbers that a user changes; all methods raise PlanterError if these are
    invalid.
    """

    name: str
    models: Sequence[str]
    controls: Sequence[Control]
    handles: Sequence[tuple[str, str]]
    """Points of the drawing that a user can drag: paths of the numbers [mm] that are their x and
    y.
    """

    exports: Sequence[Export]
    """Exports of the machine by commands."""

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Return the motion as scenes; the first is that of the machine."""

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Return the results that are displayed while numbers are changed."""

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """Return the requirements, if there are any; this may take longer."""

    def details(self, values: Values, model: str) -> Sequence[DetailTable]:
        """Return tables for sizing, if there are any; this may take a second."""

    def text(self, values: Values) -> str:
        """Return the text of the machine's file with these numbers."""


@dataclass(frozen=True)
class Sought:
    """The result of a search: numbers by path, and a sentence about it."""

    values: Values
    sentence: str

    @classmethod
    def from_answer(cls, answer: Mapping[str, Any], section: str) -> Sought:
        """Return the design in the JSON object of `planter optimise`, also of an unfinished search,
        whose numbers a file has in a section.
        """
        values = {f"{section}.{name}": value for name, value in answer["design"].items()}
        return cls(values, _describe_answer(answer))


def _describe_answer(answer: Mapping[str, Any]) -> str:
    if answer.get("met") is False:
        return "No design meets all limits yet; this one is the closest so far."
    if answer["objective"] is None:  # of a search that is on its way to the limits
        return "Best so far: a design that meets all limits."
    first, best = answer.get("start_objective"), f"{answer['objective']:.6g}"
    if not answer.get("finished", True):
        return (
            f"Best so far: objective {best}{'' if first is None else f' instead of {first:.6g}'}."
        )
    agreeing = answer.get("certificate")
    starts = (
        f" ({agreeing['agreeing_starts']} of {agreeing['starts']} starts agree)" if agreeing else ""
    )
    return f"Optimised: objective {first:.6g} to {best}{starts}."


STARTS = 8
"""Number of local searches of a page's search for an optimum, unless the user asks for others."""
MOST_STARTS = 1000
"""Maximum number of local searches that a page asks for."""


@dataclass(frozen=True)
class GoalQuantity:
    """A quantity that a search can be asked to change: its name in measures, and its name on a
    page.
    """

    name: str
    label: str


GOALS: Mapping[str, str] = {
    "largest value, as small as possible": "max {}",
    "largest size, as small as possible": "max abs {}",
    "least value, as large as possible": "-min {}",
    "variation from least to largest value, as small as possible": "range {}",
    "mean, as small as possible": "mean {}",
    "mean, as large as possible": "-mean {}",
    "root mean square, as small as possible": "rms {}",
}
"""What a search can be asked to do with a quantity, in words, and the sum that it minimises."""


@runtime_checkable
class Searching(Protocol):
    """A machine that a command can optimise."""

    @property
    def search(self) -> Sequence[str]:
        """Words of the command without the machine's file; they are empty if this machine cannot be
        optimised.
        """

    @property
    def starts(self) -> int:
        """Number of local searches of the command, 1 if it has no option for them."""

    def describe_goal(self) -> str:
        """Return what the command minimises, in words with its unit, empty if the machine states
        nothing.
        """

    @property
    def words(self) -> Mapping[str, str]:
        """Words of a page for keys that messages of the command name."""

    def sought(self, answer: Mapping[str, Any]) -> Sought:
        """Return the optimum from the JSON object that the command prints."""


@runtime_checkable
class Refining(Protocol):
    """A machine whose `readings` are those of samples, and that has true ones too."""

    def refined(self, values: Values, model: str, quickly: bool = False) -> Sequence[Reading]:
        """Return the readings by true extremes, in the same order; if `quickly`, those that take
        long are still of samples, as their names say.
        """


def refine_readings(machine: Shown, values: Values, model: str) -> Sequence[Reading]:
    """Return the readings of a machine by true extremes."""
    if isinstance(machine, Refining):
        return machine.refined(values, model)
    return machine.readings(values, model)


@runtime_checkable
class AskingSearch(Protocol):
    """A machine whose search can be asked for another goal than that of the file."""

    def list_goal_quantities(self, values: Values) -> Sequence[GoalQuantity]:
        """Return the quantities that such a goal can be about."""

    def describe_sum(self, sum_text: str) -> str:
        """Return a sum of measures in words with units. Raises InputError if it is no such sum."""


@runtime_checkable
class LockingSearch(Protocol):
    """A machine whose search can leave numbers as they are."""

    @property
    def lockable(self) -> Sequence[str]:
        """Paths of the numbers that a search varies."""

    def with_locks(self, values: Values, locked: Collection[str]) -> str:
        """Return the text of the machine's file for a search that leaves the numbers at the paths
        `locked`.
        """


@runtime_checkable
class Wishing(Protocol):
    """A machine whose tip path can be prescribed by points."""

    @property
    def wishes(self) -> bool:
        """Whether the path has no points yet, so that some can be added."""

    def wished(self, values: Values) -> str:
        """Return the text of the machine's file with points on its present path, which a user can
        drag.
        """


def build_scene(thing: object) -> Scene:
    """Return the motion of an object, by the module `show` that has it.

    Raises InputError if no package can draw it.
    """
    for module in plugins.load_modules("show"):
        scene: Scene | None = module.build_scene(thing) if hasattr(module, "build_scene") else None
        if scene is not None:
            return scene
    raise InputError(f"there is nothing to show of a {type(thing).__name__}")


def open_machine(source: str, changes: Values | None = None) -> Shown:
    """Open the machine of a file or a built-in name with changed numbers, by `open_view` of its
    kind's `show`.

    Raises InputError if it is not a machine, with the position of the error if the file is not
    valid TOML.
    """
    module = load_part(source, "show") if find_kind(source) else None
    if module is None:
        refuse_machine(source)
    view: Shown = module.open_view(source, changes or {})
    return view


def first_scene(machine: Shown, model: str | None, option: str) -> tuple[Scene, str]:
    """Return the scene of a machine in a model, by default its first, and the name of that model.

    Raises InputError, naming the `option`, if the machine has no such model.
    """
    name = machine.models[0] if model is None else model
    if name not in machine.models:
        raise InputError(
            f"{option}: {machine.name} has no such model; choose one of {', '.join(machine.models)}"
        )
    values = {control.path: control.value for control in machine.controls}
    return machine.scenes(values, name)[0].with_details(), name


def list_controls(
    document: Document,
    paths: Iterable[str],
    meanings: Mapping[str, str],
    bounds: Mapping[str, tuple[float, float]],
    names: DisplayNames | None = None,
) -> list[Control]:
    """Return controls for numbers of a file, within bounds by path if there are any, and within the
    valid range.

    They are in the order of `names`. A number without a name there is named by its meaning, or by
    the words of its key. A number with a single valid value is omitted.
    """
    numbers, result = document.numbers(), []
    for path in paths:
        value = float(numbers[path])
        ends = (
            _allowed_end(document, path, value, end) for end in bounds.get(path) or _about(value)
        )
        lower, upper = min(value, next(ends)), max(value, next(ends))
        if lower < upper:
            meaning = meanings.get(path, "")
            named = (names and names.find(path)) or _name_number(path, meaning)
            result.append(
                Control(path, meaning, units.display_unit(path), value, lower, upper, *named)
            )
    return (
        result
        if names is None
        else sorted(result, key=lambda control: names.position(control.path))
    )


def _name_number(path: str, meaning: str) -> DisplayName:
    """Return a number's name by its meaning, its symbol by its key, and its group by the section of
    its file.
    """
    section, _, key = path.rpartition(".")
    symbol = key.removesuffix(units.unit_suffix(key))
    group = labels.separate_words(section.partition("[")[0].partition(".")[0]) or "values"
    name = meaning or labels.separate_words(symbol)
    return DisplayName(to_sentence_case(name), symbol if meaning else "", to_sentence_case(group))


def to_sentence_case(text: str) -> str:
    """Return a text that begins with a capital letter."""
    return f"{text[:1].upper()}{text[1:]}"


def _allowed_end(document: Document, path: str, value: float, end: float) -> float:
    return find_farthest(value, end, lambda number: document.with_numbers({path: number}))


def find_farthest(value: float, end: float, attempt: Callable[[float], object]) -> float:
    """Return the farthest of `STEPS` numbers from a value towards an end at which an attempt
    succeeds, by bisection.

    An attempt fails if it raises PlanterError; at the value itself it must succeed.
    """
    allowed, refused, step = 0, STEPS + 1, STEPS
    while refused - allowed > 1:
        try:
            attempt(end if step == STEPS else value + (end - value) * step / STEPS)
            allowed = step
        except PlanterError:
            refused = step
        step = (allowed + refused) // 2
    return end if allowed == STEPS else value + (end - value) * allowed / STEPS


def _about(value: float) -> tuple[float, float]:
    reach = REACH * abs(value) or 1.0
    return value - reach, value + reach


def list_readings(table: Mapping[str, Any]) -> list[Reading]:
    """Return the scalar numbers of a result as readings, whose names are the words of their
    keys.
    """
    return [
        Reading(labels.format_name(key), units.display_unit(key), float(value))
        for key, value in table.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    ]


def change_numbers(document: Any, values: Values) -> Any:
    """Return a file with changed numbers, or the same file if none differs."""
    before = document.numbers()
    changes = {path: value for path, value in values.items() if before[path] != value}
    return document.with_numbers(changes) if changes else document


HAND = "assumed; set by hand"
"""Origin of a number that a user has moved, for which the origin in the file no longer holds."""


def write_numbers(original: Document, moved: Document) -> str:
    """Return the text of a file whose numbers a user has moved, with their previous values as
    comments.
    """
    before, table = original.numbers(), moved.table()
    was = {
        path: before[path]
        for path, value in moved.numbers().items()
        if path in before and before[path] != value
    }
    table["origin"] = {**moved.origins, **dict.fromkeys(was, HAND)}
    notes = {
        path: f"was {value!r} {units.display_unit(path)}".rstrip() for path, value in was.items()
    }
    head = (
        f"# The machine {json.dumps(original.name)} with numbers set by hand, by planter "
        f"{__version__}."
    )
    order = dict(sorted(table.items(), key=lambda pair: isinstance(pair[1], dict | list)))
    return "\n".join([head, "", *format_lines(order, notes)]) + "\n"


@dataclass(frozen=True)
class Input:
    """The position of a file's number in all programs: its vector and index, and the factor to SI
    units.
    """

    path: str
    vector: str
    index: int
    factor: float


@dataclass(frozen=True)
class Portable:
    """A machine in one of its models.

    `rows` are the vectors of `seen` with rows of numbers, stored one row after another, and the
    number of their rows; the vector `singles` has the named numbers of the drawing and the
    readings. `gradient`, if there is one, computes the `objective`, which is minimised, and its
    `gradient` with respect to the SI values of the numbers at the paths `design`. `assumptions` are
    those of the model, and `notes` list what a page omits.
    """

    inputs: Sequence[Input]
    seen: Program
    rows: Mapping[str, int]
    singles: Sequence[str]
    gradient: Program | None = None
    design: Sequence[str] = ()
    assumptions: Sequence[str] = ()
    notes: Sequence[str] = ()

    @property
    def programs(self) -> list[Program]:
        """All programs."""
        return [self.seen] if self.gradient is None else [self.seen, self.gradient]

    def at(self, values: Values, program: Program) -> dict[str, Array]:
        """Evaluate a program with changed numbers of the file, and return its vectors by name."""
        vectors = {number.vector: program.start[number.vector].copy() for number in self.inputs}
        for number in self.inputs:
            if number.path in values:
                vectors[number.vector][number.index] = values[number.path] * number.factor
        return program(**vectors)


@runtime_checkable
class Movable(Shown, Protocol):
    """A machine that a page can compute without Python."""

    @property
    def rigid(self) -> Movable:
        """The machine without its sensor, which the programs do not compute."""

    def portable(self, model: str) -> Portable:
        """Return the programs that compute the numbers of the first scene.

        Raises InputError, with the reason, if the model cannot be compiled.
        """

    def handed(self, values: Values) -> str:
        """Return the text of the machine's file with changed numbers, without paths of this
        computer.
        """
