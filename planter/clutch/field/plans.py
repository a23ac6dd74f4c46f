"""Plans for field tests: an orthogonal array with the user's factors, as the CSV that the evaluation reads back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.clutch.field.arrays import OrthogonalArray, array
from planter.clutch.field.trial import RESERVED, Columns
from planter.clutch.results.field import Plan
from planter.errors import InputError
from planter.files import csv_rows


@dataclass(frozen=True)
class Wanted:
    """A factor to be planned; without levels it takes as many as its column has, counted from 1."""

    name: str
    levels: tuple[str, ...] = ()

    @classmethod
    def of(cls, text: str) -> Wanted:
        """The factor that `NAME` or `NAME=LEVEL,LEVEL,...` asks for. Raises InputError for anything else.

        >>> Wanted.of("k = 0.3, 0.4, 0.5")
        Wanted(name='k', levels=('0.3', '0.4', '0.5'))
        """
        name, equals, listed = text.partition("=")
        levels = tuple(level.strip() for level in listed.split(",")) if equals else ()
        _check(text, name.strip(), levels)
        return cls(name.strip(), levels)


def plan(
    name: str, factors: Sequence[Wanted] = (), responses: Sequence[str] = ("Y1",), seed: int | None = None
) -> Plan:
    """A plan on the orthogonal array of that name; without factors, A, B, ... fill its columns.

    The runs are in the array's order, or shuffled by `seed`; `run` counts them as they are to be made. Columns that no
    factor takes are blank ones.

    Raises InputError for an unknown array, factors that do not fit its columns, and names that mean something else.
    """
    chosen = array(name)
    if not factors:
        letters = (chr(ord("A") + i) for i in range(len(chosen.levels)))
        factors = [Wanted(letter) for letter in letters]
    _check_names(factors, responses)
    taken = _assigned(chosen, factors)
    codes = chosen.codes if seed is None else np.random.default_rng(seed).permutation(chosen.codes)
    free = [index for index in range(len(chosen.levels)) if index not in taken]
    blanks = ["blank"] if len(free) == 1 else [f"blank{count}" for count in range(1, len(free) + 1)]
    columns = {"run": [str(run) for run in range(1, len(codes) + 1)]}
    for factor, index in zip(factors, taken, strict=True):
        levels = factor.levels or _counted(chosen.levels[index])
        columns[factor.name] = [levels[code] for code in codes[:, index]]
    columns |= {blank: [str(code + 1) for code in codes[:, i]] for blank, i in zip(blanks, free, strict=True)}
    columns |= {response: [""] * len(codes) for response in responses}
    comments = [f"Plan {chosen.name}, {'in standard order' if seed is None else f'shuffled by seed {seed}'}."]
    comments += [f"factor {f.name}: = {', '.join(f.levels)}" for f in factors if not _numeric(f.levels)]
    return Plan(
        chosen.name,
        [f.name for f in factors],
        blanks,
        columns,
        csv_rows.written(comments, columns, zip(*columns.values(), strict=True)),
    )


def _assigned(chosen: OrthogonalArray, factors: Sequence[Wanted]) -> list[int]:
    """The column that each factor takes: the first free one, in the array's order, with as many levels."""
    taken: list[int] = []
    for factor in factors:
        free = (i for i in chosen.order if i not in taken and len(factor.levels) in (0, chosen.levels[i]))
        index = next(free, None)
        if index is None:
            raise InputError(
                f"--factor {factor.name} finds no column in {chosen.name}, which has {_described(chosen)} for "
                f"{len(factors)} factors: each must have as many levels as its column"
            )
        taken.append(index)
    return taken


def _described(chosen: OrthogonalArray) -> str:
    counts = {levels: chosen.levels.count(levels) for levels in sorted(set(chosen.levels))}
    return " and ".join(f"{n} column{'s' * (n > 1)} of {levels} levels" for levels, n in counts.items())


def _counted(levels: int) -> tuple[str, ...]:
    return tuple(str(level) for level in range(1, levels + 1))


def _numeric(levels: Sequence[str]) -> bool:
    return all(csv_rows.finite(level) for level in levels)


def _check(text: str, name: str, levels: Sequence[str]) -> None:
    if not name or any(mark in name for mark in ':,#"\n\r') or any(mark in text for mark in '"\n\r'):
        raise InputError(f"--factor {text!r} is not allowed: it must be NAME or NAME=LEVEL,LEVEL,... in plain words")
    if not levels:
        return
    same = [float(level) for level in levels] if _numeric(levels) else list(levels)
    mixed = not _numeric(levels) and any(csv_rows.number(level) is not None for level in levels)
    if (
        "" in levels
        or len(levels) < 2
        or len(set(same)) < len(levels)
        or mixed
        or any("=" in level for level in levels)
    ):
        raise InputError(
            f"--factor {text} is not allowed: levels must be two or more that differ, all finite numbers or all words"
        )


def _check_names(factors: Sequence[Wanted], responses: Sequence[str]) -> None:
    names = [factor.name for factor in factors] + list(responses)
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise InputError(f"{twice} is given twice, but every factor and response must have a name of its own")
    for role, given in (("factor", [factor.name for factor in factors]), ("response", list(responses))):
        for name in given:
            meant = Columns().role(name)
            if meant != role or RESERVED.get(name) == role:
                raise InputError(
                    f"--{role} {name} is not allowed: a column of that name is "
                    f"{'needed for results' if meant == role else f'read back as a {meant}'}, it must have another"
                )
