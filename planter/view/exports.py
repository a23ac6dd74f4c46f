"""Descriptions of commands that export a machine, so that the studio can run them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from planter import safe_text
from planter.errors import InputError


@dataclass(frozen=True)
class RequiredOption:
    """A positive number that a command requires and that machine files do not have, with its option."""

    option: str
    meaning: str
    value: float


@dataclass(frozen=True)
class Export:
    """An export by `planter WORDS MACHINE OPTIONS --out FOLDER`, with `--model` if the machine has several models.

    `file` is the name of the file for a command that writes a single one.
    """

    name: str
    meaning: str
    words: Sequence[str]
    options: Sequence[str] = ()
    asks: Sequence[RequiredOption] = ()
    modelled: bool = False
    file: str = ""

    def command(self, machine: Path, folder: Path, model: str, numbers: Mapping[str, float]) -> list[str]:
        """Return the command line for a machine's file, with numbers by option; `folder` must exist.

        Raises InputError if a number is not positive.
        """
        words = [*self.words, str(machine), *self.options, *(("--model", model) if self.modelled else ())]
        for required in self.asks:
            value = numbers.get(required.option, required.value)
            if not (isinstance(value, int | float) and 0 < value < float("inf")):
                raise InputError(f"{required.meaning} = {safe_text.format_value(value)}: a positive number is required")
            words += [required.option, repr(float(value))]
        return [*words, "--out", str(folder / self.file)]


ANIMATION = Export("animation", "a turn as it is seen (GIF)", ("animate",), file="moving.gif")
"""Export that every machine has."""
