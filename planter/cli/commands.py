"""Commands that belong to no machine: files to start from, derivation, schemas, help, works, proofs,
comparisons, meanings, this installation and its speed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter import menu, paths
from planter.cli.results import (
    QUICK_WORKS,
    WORKS,
    Citable,
    Citations,
    Cited,
    Derived,
    Example,
    Examples,
    Listed,
    Templates,
    TemplateWritten,
    Topic,
)
from planter.errors import InputError
from planter.files import derivation, examples
from planter.report.completion import complete_files, complete_machines
from planter.report.console import Console
from planter.report.folder import NAME
from planter.report.options import (
    HoldOption,
    JsonOption,
    ModelName,
    ModelOption,
    OutOption,
    OverwriteOption,
    SetOption,
    SpeedOption,
    parse_changes,
    refuse_unused,
    text_option,
    writes_files,
)

if TYPE_CHECKING:
    from planter.engine.proof.objective import ProvableObjective

app = typer.Typer()


def _list_examples() -> list[str]:
    return examples.list_examples()


def _list_templates() -> list[str]:
    from planter.cli import templates

    return list(templates.TEMPLATES)


def _list_reading() -> list[str]:
    from planter.cli import guide, words

    return [*guide.list_topics(), *guide.list_pages(), *words.list_words()]


@app.command()
def example(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="a built-in machine or data file", autocompletion=_list_examples
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List built-in machines and data files, or print one."""
    console = Console(as_json)
    with console.outcome():
        if name is None:
            described = examples.describe_examples()
            rows = list(described.items())
            console.result(
                Examples(list(described), described),
                lambda: console.table("Built-in files", ("name", "content"), rows),
            )
        else:
            text = examples.example(name)
            console.result(Example(name, text), lambda: print(text, end=""))


@app.command("new")
def write_template(
    template: Annotated[
        str | None,
        typer.Argument(
            metavar="TEMPLATE", help="name of a template", autocompletion=_list_templates
        ),
    ] = None,
    file: Annotated[
        Path | None, typer.Argument(metavar="FILE", help="file to write [default: named after it]")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List files to start from, or write one.

    They are machines, statements of mechanisms in Python, data, plans, and a paper. No file is
    overwritten, and the commands to type next are printed.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli import templates

        if template is None:
            described = {name: entry.content for name, entry in templates.TEMPLATES.items()}
            console.result(
                Templates(described),
                lambda: console.table(
                    "Templates: planter new NAME", ("name", "content"), list(described.items())
                ),
            )
            return
        written, steps = templates.write_template(templates.read_template(template), file)
        lines = [*written, "", "Next:", *(f"  {step}" for step in steps)]
        console.result(TemplateWritten(template, written, steps), lambda: print("\n".join(lines)))


FileArgument = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="a Python file, a folder of such files, or a robot (.urdf)",
        autocompletion=complete_files(".py", ".urdf"),
    ),
]
FolderOption = Annotated[
    Path | None,
    typer.Option(help="folder to write to [default: generated, next to FILE]"),
]
TargetOption = Annotated[
    list[str] | None,
    text_option(
        "also write this language (repeatable): matlab (function files for MATLAB and Octave), "
        "latex (the derivation as a document with numbered equations), or one that an installed "
        "package offers",
        "NAME",
    ),
]


def _is_derived(path: Path) -> bool:
    return path.is_file() and "__pycache__" not in path.parts and path.name != NAME


@app.command()
def derive(
    source: FileArgument,
    out: FolderOption = None,
    target: TargetOption = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Derive the equations of your mechanism. FILE is run as Python: only use files you trust."""
    console = Console(as_json)
    with console.outcome():
        folder = derivation.derive_file(source, out, target or (), overwrite)
        written = sorted(str(path) for path in folder.rglob("*") if _is_derived(path))
        console.result(Derived(str(folder), written), lambda: print("\n".join(written)))


@app.command()
def schema(
    command: Annotated[
        list[str] | None,
        typer.Argument(metavar="COMMAND", help="a command, as `design clutch geometry`"),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the commands with a JSON schema, or print one schema."""
    console = Console(as_json)
    with console.outcome():
        from planter.files import schema as schemas

        kinds = schemas.load_result_types()
        name = menu.current_result(" ".join(command or ()))
        if not name:
            listed = sorted(kinds)
            console.result(Listed(listed), lambda: print("\n".join(listed)))
            return
        if name not in kinds:
            raise InputError.for_value("COMMAND", name, paths.suggest_names(name, sorted(kinds)))
        console.result(
            dict(schemas.build_schema(name, kinds[name])),
            lambda: print(schemas.format_schema(name, kinds[name]), end=""),
        )


@app.command(name="help")
def read_help(
    context: typer.Context,
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="a topic, a page, or a word of statements, such as m.pin",
            autocompletion=_list_reading,
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List what there is to read about, or print a page of it.

    These are topics that concern all commands, pages of the documentation, and the words that
    mechanisms, formulas and papers of your own are stated with.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli import guide

        if name is None:
            listed = guide.describe_guide()
            console.result(listed, lambda: print(guide.format_guide(listed)))
        else:
            root: Any = context.find_root().command
            is_made = name == guide.COMMANDS
            text = guide.describe_commands(root) if is_made else guide.read_guide(name)
            console.result(Topic(name, text), lambda: print(text.rstrip("\n")))


@app.command()
def cite(
    name: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="a command, as `optimise` or `design clutch engage`, or a work, as wang2017",
        ),
    ] = None,
    bibtex: Annotated[
        bool, typer.Option("--bibtex", help="entries for BibTeX instead of lines")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """List the works to cite for a command's result.

    For example: planter about cite optimise --bibtex
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli.references import cite_works, load_references

        if not name:
            refuse_unused("without a NAME", "--bibtex")
            index = load_references()
            listed = Citable(sorted(index.works), dict(sorted(index.commands.items())))
            lines = [
                f"works: {', '.join(listed.works)}",
                *(f"{k}: {', '.join(v)}" for k, v in listed.commands.items()),
            ]
            console.result(listed, lambda: print("\n".join(lines)))
            return
        title = menu.current_result(" ".join(name))
        result = Citations(title, cite_works(title))
        console.result(
            result,
            lambda: print("\n\n".join(w.bibtex if bibtex else _wrap(w) for w in result.works)),
        )


def _wrap(work: Cited) -> str:
    return fill(
        f"{work.key} ({work.behind}): {work.text}",
        80,
        subsequent_indent="  ",
        break_on_hyphens=False,
    )


def _rebuild_objective(
    file: Path, source: str | None, document: Mapping[str, Any]
) -> ProvableObjective:
    """Return the objective of the machine of a proof, as it is generated here.

    Its file may also lie beside that of the proof, or in the folder above.
    """
    stated = Path(document["machine"]["source"])
    places = [stated, file.parent / stated.name, file.parent.parent / stated.name]
    source = source or str(next((place for place in places if place.is_file()), stated))
    part = examples.load_part(source, "proof")
    if part is None:
        raise InputError(f"{source}: there is no such machine; --machine names its file")
    objective: ProvableObjective = part.rebuild_objective(source, document)
    return objective


@app.command("prove")
def check_proof(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="a proof.json of optimise --prove",
            autocompletion=complete_files(".json"),
        ),
    ],
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="compute each bound again (done in any case)", show_default=False
        ),
    ] = True,
    machine: Annotated[
        str | None, text_option("the machine, if it is not where the proof says", "MACHINE")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compute the bounds of a proof again, and check its machine.

    Its programs are compared with those of the machine.

    Exit code 1 if a bound does not follow, or the machine is another. `check_proof.py` beside the
    file computes the bounds without planter.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.engine.proof.certificate_file import check_document, read_document

        result = check_document(read_document(file), partial(_rebuild_objective, file, machine))
        console.result(result, lambda: print(result.describe()))
    if not result.valid:
        raise typer.Exit(1)


@app.command()
@writes_files("summary.json", "curves.csv", "report.html")
def diff(
    machines: Annotated[
        list[str],
        typer.Argument(
            metavar="A B [C ...]",
            help="two or more machines of one kind: files, or names of built-in ones",
            autocompletion=complete_machines,
        ),
    ],
    model: ModelOption = ModelName.exact,
    quantity: Annotated[
        list[str] | None, text_option("also compare this curve (repeatable)", "NAME")
    ] = None,
    hold: HoldOption = None,
    until: Annotated[
        float | None, typer.Option(metavar="S", min=1e-9, help="end of free motions [s]")
    ] = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compare designs of one kind of machine side by side.

    Values, results, requirements and curves have their differences from A.

    The objective of A and the limits of all files are evaluated for every machine. `--set` and
    `--speed-rpm` apply to all of them. For example: planter diff wang2017 out/optimum.toml --out
    compared

    What moves freely is compared over a time: planter diff a.toml b.toml --until 2
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli.comparison_page import present_comparison
        from planter.cli.machine_comparison import ComparisonOptions, compare_machines

        options = ComparisonOptions(
            parse_changes(set_), speed_rpm, model.value, hold or (), quantity or (), until
        )
        present_comparison(compare_machines(machines, options)).show(console, out)


DRAWN_DEG = 50.0
"""Angle of the drive at which bodies are cut free unless another one is named."""


@app.command()
@writes_files("summary.json", "symbols.csv", "report.html")
def explain(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="a symbol or key, as F_B1x, mass.sun_kg, range_N, tip_x_mm; or a machine",
            autocompletion=complete_machines,
        ),
    ] = None,
    key: Annotated[
        str | None,
        typer.Argument(metavar="KEY", help="with a machine: a symbol or key of it alone"),
    ] = None,
    bodies: Annotated[
        bool, typer.Option("--bodies", help="cut each body of a machine free, with its forces")
    ] = False,
    at: Annotated[
        float | None, typer.Option(help="with --bodies: angle of the drive [deg] [default: 50]")
    ] = None,
    out: OutOption = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Explain a symbol or a key: meaning, unit, source.

    Of a machine, every value with its bounds, every quantity, and the functions; `--out` writes
    its drawings with the symbols on them: `planter about explain wang2017 --out drawn`. With
    `--bodies` free-body diagrams: `planter about explain wang2017 --bodies --at 40 --out bodies`.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli import dictionary, explanation
        from planter.files.examples import find_kind

        if bodies:
            from planter.cli.free_bodies import cut_bodies, present_bodies

            if name is None or key is not None:
                raise InputError(
                    "--bodies: name one machine, as `planter about explain wang2017 --bodies`"
                )
            cut = cut_bodies(name, parse_changes(set_), DRAWN_DEG if at is None else at)
            present_bodies(cut, out is not None).show(console, out)
            return
        refuse_unused("without --bodies", "--at")
        if name is None:
            refuse_unused("without a NAME", "--out", "--set")
            names = dictionary.list_names()
            console.result(names, lambda: explanation.show_names(names))
        elif key is not None:
            refuse_unused("with a KEY", "--out")
            explained = explanation.explain_machine(name, parse_changes(set_))
            meanings = explanation.find_meanings(explained, key)
            console.result(meanings, lambda: explanation.show_meanings(meanings))
        elif find_kind(name) or out is not None or set_:
            sheets = explanation.draw_sheets(name, parse_changes(set_))
            explained = explanation.explain_machine(name, parse_changes(set_), sheets)
            explanation.present_machine(explained, sheets, out is not None).show(console, out)
        else:
            meanings = dictionary.explain_name(name)
            console.result(meanings, lambda: explanation.show_meanings(meanings))


@app.command()
def doctor(
    build: Annotated[
        bool, typer.Option("--build", help="compile the functions of the built-in machine first")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what is installed, and what would make it faster."""
    console = Console(as_json)
    with console.outcome():
        from planter.cli.installation import MACHINE, examine_installation

        result = examine_installation(build)
        facts = result.versions | {"compiler": result.compiler, "cache": result.cache}
        kernels = [(kernel.name, kernel.way, kernel.compiled) for kernel in result.kernels]

        def print_tables() -> None:
            console.table("This installation", ["", "result"], list(facts.items()))
            console.table(f"Functions of {MACHINE}", ["function", "way", "compiled"], kernels)
            title = "Optional parts: pip install 'planter[NAME]'"
            console.table(title, ["name", "installed"], list(result.extras.items()))
            console.table("What would help", ["missing", "what to do"], list(result.advice.items()))

        console.result(result, print_tables)


@app.command()
@writes_files("bench.json", "bench.md")
def bench(
    quick: Annotated[
        bool, typer.Option("--quick", help="under 45 s: cycle, cycle+gradient, optimise")
    ] = False,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Time all ways to evaluate a cycle, once they agree."""
    console = Console(as_json)
    with console.outcome():
        from planter.cli import benchmark
        from planter.report.files import write_bundle

        result = benchmark.run_benchmark(QUICK_WORKS if quick else WORKS, console.progress)
        tables = benchmark.tabulate_benchmark(result)
        if out is not None:
            content = json.dumps(result.table(), indent=2, allow_nan=False) + "\n"
            markdown = benchmark.format_markdown(tables)
            write_bundle(out, {"bench.json": content, "bench.md": markdown}, {})

        def print_tables() -> None:
            for title, (head, rows) in tables.items():
                console.table(title, head, rows)

        console.result(result, print_tables)
