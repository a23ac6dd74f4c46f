"""Derivation of a file of a user, which runs as Python in a separate process that returns text."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from planter import workers
from planter.errors import ComputationError, InputError
from planter.progress import name_step
from planter.text_files import check_regular

GENERATED = "generated"
BENCHMARK = "benchmark.json"
"""Name of the file with the scores on a corpus."""


def derive_file(
    source: Path, out: Path | None = None, targets: Iterable[str] = (), overwrite: bool = False
) -> Path:
    """Derive a file or folder and return the folder of the results: `out`, else ``generated`` next
    to the file.

    ``targets`` are additional languages; ``overwrite`` replaces files that were not derived, or
    were edited since. Raises InputError for an error in the file, with its line, and
    ComputationError for any other failure.
    """
    if not source.exists():
        raise InputError(f"{source}: there is no such file or folder")
    if not source.is_dir():
        check_regular(source)
    folder = out or (source if source.is_dir() else source.parent) / GENERATED
    options = ["--overwrite"] if overwrite else []
    options += [part for name in targets for part in ("--target", name)]
    _run_derive(source, folder, options)
    return folder


def judge_text(text: Path, against: Path, names: Path | None, folder: Path) -> None:
    """Compare a text with the mechanism of a Python file, and write verdicts and functions into a
    folder.

    ``names`` says what names of the text mean. Raises InputError for an error in one of the files,
    ComputationError for any other failure.
    """
    for path in (text, against, *([] if names is None else [names])):
        if not path.exists():
            raise InputError(f"{path}: there is no such file")
        check_regular(path)
    options = ["--against", str(against)] + ([] if names is None else ["--names", str(names)])
    _run_derive(text, folder, options)


def score_corpus(corpus: Path, folder: Path, slips: int, seed: int, answers: Path | None) -> None:
    """Score the audit, and the answers of another checker, on a corpus, and write the scores into a
    folder.

    Raises InputError for an error in one of the files, ComputationError for any other failure.
    """
    options = ["--benchmark", "--slips", str(slips), "--seed", str(seed)]
    _run_derive(corpus, folder, options + ([] if answers is None else ["--answers", str(answers)]))


def _run_derive(source: Path, folder: Path, options: list[str]) -> None:
    with name_step(f"deriving {source}"):
        done = workers.run_command(
            workers.program_command("derive", str(source), "--out", str(folder), *options)
        )
    messages = done.stderr.strip().splitlines() or [
        f"{source}: deriving ended with code {done.returncode}"
    ]
    if done.returncode == InputError.exit_code:
        raise InputError(messages[0])
    if done.returncode:
        raise ComputationError(messages[-1])
