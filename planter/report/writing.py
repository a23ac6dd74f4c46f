"""The option `--overwrite` of commands that write files, checked before anything is computed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from planter.errors import Interrupted
from planter.report import folder
from planter.report.console import Console

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


def writes_files(
    *names: str, figures: tuple[str, ...] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorate a command that writes into the folder of its parameter `out` with the option
    `--overwrite`.

    The files `names` and the `figures` that it always writes are checked before it begins; every
    file is checked again when it is written (`planter.report.folder`).
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def guarded(*args: Any, overwrite: bool, **kwargs: Any) -> None:
            with folder.allow_overwriting(overwrite):
                out = kwargs.get("out")
                if isinstance(out, Path):
                    with Console(kwargs.get("as_json", False)).outcome():
                        folder.check_files(out, (*names, *figure_files(*figures)))
                command(*args, **kwargs)

        signature = inspect.signature(command, eval_str=True)
        option = inspect.Parameter(
            "overwrite", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=OverwriteOption
        )
        guarded.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[*signature.parameters.values(), option]
        )
        return guarded

    return decorate
