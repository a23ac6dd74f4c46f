"""Derives equations and writes them as code: `python -m derive` the project's own,
`python -m derive FILE` yours.
"""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Sequence
from pathlib import Path

from .generated_folder import (
    GENERATED,
    OwnError,
    add_files,
    list_changes,
    list_differences,
    write_folder,
)

WHAT = """code (the default): the models and families of this project; audit: what their papers claim, judged; or a FILE
or FOLDER of your own, or the name of what an installed package offers; or a text (.tex, .md, .rst, .ipynb) to compare
--against a file. A file of your own is run as Python, with all that Python may do: derive only files that you trust."""
OUT = (
    "folder to write to; else generated/, of this project or beside your file. Nothing else in "
    "it is touched"
)
OVERWRITE = "replace files there that were not derived, or were edited since"
TARGET = """also write this language (repeatable): matlab (MATLAB and Octave), latex (the derivation as a document), or
one of an installed package. Our own models are written in it to --out alone"""
AGAINST = "Python file with the mechanism or the formulas that a text is compared with"
NAMES = (
    "TOML file that says what names of a text mean; without it a skeleton is written as names.toml"
)
BENCHMARK = "score the audit of texts on a corpus, which is a folder, and write benchmark.json"
SLIPS = "number of slips in all texts together"
SEED = "what is drawn depends on it"
ANSWERS = "JSON lines with the answers of another checker"
CHECK = "derive everything, write nothing, and compare with what was written"


def main(argv: Sequence[str] | None = None) -> int:
    """Derive or compare what the arguments name, and return the exit status; an error of the user's
    is printed.
    """
    arguments = _parser().parse_args(argv)
    try:
        if arguments.benchmark:
            return _score_corpus(arguments)
        if arguments.against is not None:
            return _judge_text(
                Path(arguments.what),
                arguments.against,
                arguments.names,
                arguments.out,
                arguments.overwrite,
            )
        return _derived(
            arguments.what, arguments.out, arguments.check, arguments.target, arguments.overwrite
        )
    except OwnError as error:
        print(error, file=sys.stderr)
    except ModuleNotFoundError as error:
        if error.name not in ("sympy", "mpmath"):
            raise
        print(
            f"deriving needs {error.name}, which is not installed: pip install 'planter[derive]'",
            file=sys.stderr,
        )
    return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m derive", description=__doc__)
    parser.add_argument("what", nargs="?", default="code", metavar="WHAT", help=WHAT)
    parser.add_argument("--check", action="store_true", help=CHECK)
    parser.add_argument("--target", action="append", default=[], metavar="NAME", help=TARGET)
    parser.add_argument("--out", type=Path, metavar="DIR", help=OUT)
    parser.add_argument("--against", type=Path, metavar="FILE", help=AGAINST)
    parser.add_argument("--names", type=Path, metavar="TOML", help=NAMES)
    parser.add_argument("--benchmark", action="store_true", help=BENCHMARK)
    parser.add_argument("--slips", type=int, default=300, metavar="N", help=SLIPS)
    parser.add_argument("--seed", type=int, default=0, metavar="N", help=SEED)
    parser.add_argument("--answers", type=Path, metavar="FILE", help=ANSWERS)
    parser.add_argument("--overwrite", action="store_true", help=OVERWRITE)
    return parser


def _derived(
    part: str, out: Path | None, check: bool, targets: Sequence[str], overwrite: bool
) -> int:
    """Write or compare one part of our own, or what the user names; the exit status."""
    from .generation import PARTS, VERDICTS, derive_code, derive_user_code

    if targets and part in PARTS:
        if part != "code" or out is None or check:
            raise OwnError(
                "--target: our own models are written in another language by `code --target NAME "
                "--out DIR`"
            )
        return _added(out, derive_code(targets), part, overwrite)
    if part not in PARTS:
        content, default_folder = derive_user_code(part, targets)
        folder = out or default_folder
        return (
            _compared(folder, list_changes(folder, content), len(content))
            if check
            else _added(folder, content, part, overwrite)
        )
    folder = out or (GENERATED if GENERATED.is_dir() else Path("generated"))
    if check:
        content = {
            name: text for derive_part in PARTS.values() for name, text in derive_part(None).items()
        }
        return _compared(folder, list_differences(folder, content), len(content))
    content = PARTS[part](folder / "audit.json")
    if folder != GENERATED:
        return _added(folder, content, part, overwrite)
    kept_files = (
        VERDICTS
        if part == "code"
        else frozenset(p.relative_to(folder).as_posix() for p in folder.rglob("*"))
    )
    write_folder(folder, content, kept_files)
    print(f"generated/: {len(content)} files of {part}")
    return 0


def _judge_text(
    text: Path, against: Path, names: Path | None, out: Path | None, overwrite: bool
) -> int:
    """Write the verdicts on a text."""
    from .generation import derive_text

    return _added(
        out or text.parent / "generated", derive_text(text, against, names), "a text", overwrite
    )


def _score_corpus(arguments: argparse.Namespace) -> int:
    """Write the scores on a corpus."""
    import json

    from .audit.texts.benchmark import run_benchmark

    result = run_benchmark(Path(arguments.what), arguments.slips, arguments.seed, arguments.answers)
    content = {"benchmark.json": json.dumps(result, indent=1) + "\n"}
    return _added(arguments.out or Path("benchmark"), content, "a benchmark", arguments.overwrite)


def _added(folder: Path, content: dict[str, str], part: str, overwrite: bool) -> int:
    add_files(folder, content, overwrite)
    print(f"{folder}/: {len(content)} files of {part}")
    return 0


def _compared(folder: Path, differences: list[str], count: int) -> int:
    print("\n".join(differences) or f"{folder.name}/ is up to date: {count} files")
    return 1 if differences else 0


if __name__ == "__main__":
    gc.disable()  # what so short a process makes, it keeps
    sys.exit(main())
