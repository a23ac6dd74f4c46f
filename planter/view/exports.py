"""What commands write of a machine, so that whoever shows it can have that written too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from planter import legible
from planter.errors import InputError


@dataclass(frozen=True)
class Asked:
    """A number above zero that a command cannot do without and no machine's file holds, by its option."""

    option: str
    meaning: str
    value: float


@dataclass(frozen=True)
class Export:
    """What a command writes: `planter WORDS MACHINE OPTIONS --out FOLDER`, and `--model` where the machine has several.

    A command that writes a single file is told its name.
    """

    name: str
    meaning: str
    words: Sequence[str]
    options: Sequence[str] = ()
    asks: Sequence[Asked] = ()
    modelled: bool = False
    file: str = ""

    def command(self, machine: Path, folder: Path, model: str, numbers: Mapping[str, float]) -> list[str]:
        """The command of a machine's file, with what is asked for by option; its files go to a folder that there is.

        Raises InputError for a number that is none above zero.
        """
        told = [*self.words, str(machine), *self.options, *(("--model", model) if self.modelled else ())]
        for one in self.asks:
            value = numbers.get(one.option, one.value)
            if not (isinstance(value, int | float) and 0 < value < float("inf")):
                raise InputError(
                    f"{one.meaning} = {legible.value(value)} is not allowed: it must be a number above zero"
                )
            told += [one.option, repr(float(value))]
        return [*told, "--out", str(folder / self.file)]


ANIMATION = Export("animation", "a turn as it is seen (GIF)", ("animate",), file="moving.gif")
"""Of whatever moves."""
