"""What the commands of all packages share: options, and how their parts are put together."""

from __future__ import annotations

import enum
import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperArgument, TyperCommand, TyperOption

from planter import safe_text
from planter.errors import InputError, Interrupted
from planter.report import folder
from planter.report.completion import complete_changes, complete_machines
from planter.report.console import Console


class ModelName(enum.StrEnum):
    """Models of a machine that a paper describes."""

    exact = "exact"
    printed = "printed"


def text_option(help_: str, metavar: str) -> typer.models.OptionInfo:
    """Return an option with a name for its value."""
    option: typer.models.OptionInfo = typer.Option(metavar=metavar, help=help_)
    return option


MachineArgument = Annotated[
    str,
    typer.Argument(
        metavar="MACHINE",
        help="a machine file, the name of a built-in machine, or your mechanism's file: "
        "NAME.toml, or NAME of one here "
        "or in generated/",
        autocompletion=complete_machines,
    ),
]
ModelOption = Annotated[
    ModelName,
    typer.Option(
        help="first principles, or the paper's equations as printed, of machines that have both"
    ),
]
SamplesOption = Annotated[
    int | None,
    typer.Option(help="angles of the cycle [default: the machine file's]"),
]
JsonOption = Annotated[bool, typer.Option("--json", help="print one JSON object instead of tables")]
OutOption = Annotated[Path | None, typer.Option(help="folder for result files")]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="change a number for this call (repeatable). NAME is a key of the file, as `planter "
        "example` shows one: "
        "in full, as mass.sun_kg or nozzle.hinge_A_mm[0], or its last part if that is unique",
        autocompletion=complete_changes,
    ),
]
SpeedOption = Annotated[
    float | None,
    typer.Option(help="change the speed of the drive for this call [r/min]"),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(
        min=1,
        max=1024,
        help="number of worker processes [default: one per core if that is faster]",
    ),
]
ClusterOption = Annotated[
    str | None,
    text_option("Dask scheduler whose workers run the jobs (planter[cluster])", "ADDRESS"),
]
SeedOption = Annotated[int, typer.Option(min=0, help="random seed")]
LeastOption = Annotated[
    str | None,
    text_option(
        "instead of the objective in the file: a sum to minimise, such as "
        '"range F_Ox + 0.5 rms M_in" (max, min, range, mean, variance, std, rms, work, jump, or '
        "NAME at DEG, or NAME "
        "where NAME is least; most also while NAME <= NUMBER); -min NAME makes a least value "
        "greater",
        "SUM",
    ),
]
HoldOption = Annotated[
    list[str] | None,
    text_option(
        'limit in addition to those of the file, such as "abs F_Ax <= 300 N" or "min '
        "distance tip to ground__D "
        '>= 20 mm" (repeatable)',
        "LIMIT",
    ),
]
VaryOption = Annotated[
    list[str] | None,
    text_option(
        "vary this value of the file within these bounds, instead of the values with bounds "
        "(repeatable)",
        "PATH=LOW:HIGH",
    ),
]


_GIVEN: ContextVar[frozenset[str]] = ContextVar("given options", default=frozenset())
"""Options of the running command whose values are not their defaults."""


def record_options(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that refuses numbers that are not finite, and knows which of its options are
    given.

    Raises InputError for an option with a number that is not finite, since infinity may lie within
    its limits.
    """
    parameters = inspect.signature(command, eval_str=True).parameters
    options = {name: _spell_option(parameter) for name, parameter in parameters.items()}

    @wraps(command)
    def recorded(**values: Any) -> None:
        for name, value in values.items():
            for number in value if isinstance(value, list | tuple) else (value,):
                if isinstance(number, float) and not math.isfinite(number):
                    raise InputError.for_value(options[name], number, "it must be a finite number")
        present = [
            name
            for name, value in values.items()
            if value not in ([], (), parameters[name].default)
        ]
        token = _GIVEN.set(frozenset(options[name] for name in present))
        try:
            command(**values)
        finally:
            _GIVEN.reset(token)

    return recorded


def _spell_option(parameter: inspect.Parameter) -> str:
    """Return how a command's parameter is written on the command line."""
    for information in getattr(parameter.annotation, "__metadata__", ()):
        # In an annotation Typer keeps the first name where the default would stand.
        names = getattr(information, "param_decls", None) or ()
        for name in (getattr(information, "default", None), *names):
            if isinstance(name, str) and name.startswith("-"):
                return name.partition("/")[0]
    return f"--{parameter.name.strip('_').replace('_', '-')}"


def find_unused(*options: str) -> list[str]:
    """Return which of some options of the running command are given."""
    return [option for option in options if option in _GIVEN.get()]


def refuse_unused(mode: str, *options: str) -> None:
    """Raise InputError for an option that is given but has no effect in a mode, as "without
    --ensemble".
    """
    if unused := find_unused(*options):
        raise InputError(f"{unused[0]} has no effect {mode}: leave {unused[0]} out")


def parse_changes(
    texts: Sequence[str] | None, options: Mapping[str, float | None] | None = None
) -> dict[str, float]:
    """Return the changed numbers by name, from texts of `--set NAME=VALUE` and from separate
    `options`.

    Raises InputError if a text is not NAME=VALUE with a number.
    """
    numbers: dict[str, float] = {}
    for assignment in texts or ():
        name, equals, text = assignment.partition("=")
        try:
            numbers[name.strip()] = float(text)
        except ValueError:
            pointed = safe_text.replace_decimal_comma(text)
            hint = f" (with a decimal point: {pointed})" if pointed else ""
            allowed = (
                f"it must be NAME=VALUE with a number{hint}" if equals else "it must be NAME=VALUE"
            )
            raise InputError(
                f"--set {safe_text.sanitise_line(assignment, 200)}: {allowed}"
            ) from None
    return numbers | {name: value for name, value in (options or {}).items() if value is not None}


def read_ranges(option: str, texts: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the ends of each range `PATH=LOW:HIGH` of an option, by path.

    Raises InputError for other texts.
    """
    ranges: dict[str, tuple[float, float]] = {}
    for text in texts:
        name, _, ends = text.partition("=")
        try:
            low, high = map(float, ends.split(":"))
        except ValueError:
            allowed = "it must be PATH=LOW:HIGH, as mass.planet_kg=0.8:1.6"
            raise InputError(f"{option} {safe_text.sanitise_line(text, 200)}: {allowed}") from None
        ranges[name.strip()] = (low, high)
    return ranges


class SectionedCommand(TyperCommand):
    """A command whose help has a section for each `rich_help_panel` of its options."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments, options that belong to no section, then the sections."""
        sections: dict[str, list[Any]] = {"Arguments": [], "Options": []}
        for parameter in self.get_params(ctx):
            if (record := parameter.get_help_record(ctx)) is not None:
                kind = "Arguments" if parameter.param_type_name == "argument" else "Options"
                title = getattr(parameter, "rich_help_panel", None) or kind
                sections.setdefault(title, []).append(record)
        for title, records in sections.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


def list_allowed(**values: Callable[[], Iterable[str]]) -> type[TyperCommand]:
    """Return a command whose help lists the allowed values of its parameters, looked up at that
    time.
    """

    class Listing(SectionedCommand):
        def format_help(self, ctx: Any, formatter: Any) -> None:
            parameters = {
                item.name: item
                for item in self.params
                if isinstance(item, TyperArgument | TyperOption)
            }
            before = {name: parameters[name].help for name in values}
            for name, list_values in values.items():
                parameters[name].help = f"{before[name]}: {', '.join(list_values())}"
            try:
                super().format_help(ctx, formatter)
            finally:
                for name, text in before.items():
                    parameters[name].help = text

    return Listing


def join_applications(*parts: typer.Typer) -> typer.Typer:
    """Return an application with the commands and groups of several."""
    app = typer.Typer()
    for part in parts:
        app.registered_commands += part.registered_commands
        app.registered_groups += part.registered_groups
    return app


class MotionFormat(enum.StrEnum):
    """Formats by their names in commands, each with its purpose in words and the files that are
    written.

    `planter.exports.motion_tables` has the function of each.
    """

    purpose: str
    files: str

    def __new__(cls, name: str, purpose: str, files: str) -> MotionFormat:
        member = str.__new__(cls, name)
        member._value_, member.purpose, member.files = name, purpose, files
        return member

    csv = "csv", "as CSV", "motion.csv"
    adams = (
        "adams",
        "for Adams",
        "motion.cmd, which makes splines for AKISPL and CUBSPL (mm, N, N mm, deg, s)",
    )
    solidworks = (
        "solidworks",
        "for SolidWorks Motion",
        "a CSV file of time and value for each quantity, for motors and forces by data points",
    )
    simulink = "simulink", "for Simulink", "motion.mat for the block From File (SI, rad)"


def describe_motion_formats() -> str:
    """Return a sentence for each format."""
    return " ".join(f"{entry}: {entry.files}." for entry in MotionFormat)


OverwriteOption = Annotated[
    bool,
    typer.Option(
        "--overwrite", help="replace files that planter did not write, or that were edited since"
    ),
]


def figure_files(*names: str) -> list[str]:
    """Return the SVG and PNG paths of figures by name, below the output folder."""
    return [f"figures/{name}.{kind}" for name in names for kind in ("svg", "png")]


PROOF = "proof.json"
"""Name of the file of a proof."""


def find_proof(out: Path | None) -> tuple[Path | None, Callable[[str], None]]:
    """Return the file of a proof in the folder of a result, and the function that writes its text
    there.
    """

    def write(text: str) -> None:
        if out is not None:
            folder.write_file(folder.output_folder(out) / PROOF, text.encode())

    return None if out is None else out / PROOF, write


@contextmanager
def interruptible_result(result: dict[str, Any]) -> Iterator[None]:
    """Report a result that is already there if the user interrupts the block."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(result) from None


def _find_change(path: Path) -> int | None:
    """Return the time [ns] at which a file was changed last, None if there is none."""
    return path.stat().st_mtime_ns if path.is_file() else None


def writes_files(
    *names: str, figures: tuple[str, ...] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorate a command that writes into the folder of its parameter `out` with the option
    `--overwrite`.

    The files `names` and the `figures` that it always writes are checked before it begins; every
    file is checked again when it is written (`planter.report.folder`). If it wrote a page there, a
    note on standard error names it, unless the output is JSON.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def guarded(*args: Any, overwrite: bool, **kwargs: Any) -> None:
            with folder.allow_overwriting(overwrite):
                out = kwargs.get("out")
                if not isinstance(out, Path):
                    command(*args, **kwargs)
                    return
                console = Console(kwargs.get("as_json", False))
                with console.outcome():
                    folder.check_files(out, (*names, *figure_files(*figures)))
                page = out / "report.html"
                before = _find_change(page)
                command(*args, **kwargs)
                if not console.as_json and _find_change(page) != before:
                    console.say(f"report: {page}")

        signature = inspect.signature(command, eval_str=True)
        option = inspect.Parameter(
            "overwrite", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=OverwriteOption
        )
        guarded.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[*signature.parameters.values(), option]
        )
        return guarded

    return decorate
