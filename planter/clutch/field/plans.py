"""Plans for field tests: an orthogonal array with the user's factors, as the CSV that the
evaluation reads back.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.clutch.field.trial import RESERVED, FieldColumns
from planter.clutch.results import FieldPlan
from planter.errors import InputError
from planter.files import csv_rows


@dataclass(frozen=True)
class FactorSpec:
    """A factor of a plan; without levels it takes as many as its column has, counted from 1."""

    name: str
    levels: tuple[str, ...] = ()

    @classmethod
    def parse(cls, text: str) -> FactorSpec:
        """Return the factor of `NAME` or `NAME=LEVEL,LEVEL,...`.

        Raises InputError for any other text.

        >>> FactorSpec.parse("k = 0.3, 0.4, 0.5")
        FactorSpec(name='k', levels=('0.3', '0.4', '0.5'))
        """
        name, equals, listed = text.partition("=")
        levels = tuple(level.strip() for level in listed.split(",")) if equals else ()
        _check(text, name.strip(), levels)
        return cls(name.strip(), levels)


def plan_field(
    name: str,
    factors: Sequence[FactorSpec] = (),
    responses: Sequence[str] = ("Y1",),
    seed: int | None = None,
) -> FieldPlan:
    """Return a plan on an orthogonal array by name; without factors, A, B, ... fill its columns.

    The runs are in the array's order, or shuffled by `seed`; `run` counts them as they are to be
    made. Columns that no factor takes are blank ones.

    Raises InputError for an unknown array, factors that do not fit its columns, and names that mean
    something else.
    """
    chosen = build_array(name)
    if not factors:
        letters = (chr(ord("A") + i) for i in range(len(chosen.levels)))
        factors = [FactorSpec(letter) for letter in letters]
    _check_names(factors, responses)
    taken = _assigned(chosen, factors)
    codes = chosen.codes if seed is None else np.random.default_rng(seed).permutation(chosen.codes)
    free = [index for index in range(len(chosen.levels)) if index not in taken]
    blanks = ["blank"] if len(free) == 1 else [f"blank{count}" for count in range(1, len(free) + 1)]
    columns = {"run": [str(run) for run in range(1, len(codes) + 1)]}
    for factor, index in zip(factors, taken, strict=True):
        levels = factor.levels or _counted(chosen.levels[index])
        columns[factor.name] = [levels[code] for code in codes[:, index]]
    columns |= {
        blank: [str(code + 1) for code in codes[:, i]]
        for blank, i in zip(blanks, free, strict=True)
    }
    columns |= {response: [""] * len(codes) for response in responses}
    comments = [
        f"Plan {chosen.name}, "
        f"{'in standard order' if seed is None else f'shuffled by seed {seed}'}."
    ]
    comments += [
        f"factor {f.name}: = {', '.join(f.levels)}" for f in factors if not _numeric(f.levels)
    ]
    return FieldPlan(
        chosen.name,
        [f.name for f in factors],
        blanks,
        columns,
        csv_rows.format_csv(comments, columns, zip(*columns.values(), strict=True)),
    )


def _assigned(chosen: OrthogonalArray, factors: Sequence[FactorSpec]) -> list[int]:
    """The column that each factor takes: the first free one, in the array's order, with as many
    levels.
    """
    taken: list[int] = []
    for factor in factors:
        free = (
            i
            for i in chosen.order
            if i not in taken and len(factor.levels) in (0, chosen.levels[i])
        )
        index = next(free, None)
        if index is None:
            raise InputError(
                f"--factor {factor.name} finds no column in {chosen.name}, which has "
                f"{_described(chosen)} for "
                f"{len(factors)} factors: each must have as many levels as its column"
            )
        taken.append(index)
    return taken


def _described(chosen: OrthogonalArray) -> str:
    counts = {levels: chosen.levels.count(levels) for levels in sorted(set(chosen.levels))}
    return " and ".join(
        f"{n} column{'s' * (n > 1)} of {levels} levels" for levels, n in counts.items()
    )


def _counted(levels: int) -> tuple[str, ...]:
    return tuple(str(level) for level in range(1, levels + 1))


def _numeric(levels: Sequence[str]) -> bool:
    return all(csv_rows.is_finite_number(level) for level in levels)


def _check(text: str, name: str, levels: Sequence[str]) -> None:
    if (
        not name
        or any(mark in name for mark in ':,#"\n\r')
        or any(mark in text for mark in '"\n\r')
    ):
        raise InputError(f"--factor {text!r}: must be NAME or NAME=LEVEL,LEVEL,... in plain words")
    if not levels:
        return
    same = [float(level) for level in levels] if _numeric(levels) else list(levels)
    mixed = not _numeric(levels) and any(
        csv_rows.parse_number(level) is not None for level in levels
    )
    if (
        "" in levels
        or len(levels) < 2
        or len(set(same)) < len(levels)
        or mixed
        or any("=" in level for level in levels)
    ):
        raise InputError(
            f"--factor {text}: levels must be two or more that differ, all finite numbers or all "
            f"words"
        )


def _check_names(factors: Sequence[FactorSpec], responses: Sequence[str]) -> None:
    names = [factor.name for factor in factors] + list(responses)
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise InputError(f"{twice} is given twice, but names of factors and responses must differ")
    for role, role_names in (
        ("factor", [factor.name for factor in factors]),
        ("response", list(responses)),
    ):
        for name in role_names:
            meant = FieldColumns().role(name)
            if meant != role or RESERVED.get(name) == role:
                raise InputError(
                    f"--{role} {name}: a column of that name is "
                    f"{'needed for results' if meant == role else f'read back as a {meant}'}, it "
                    f"must have another"
                )


Codes = NDArray[np.intp]

LINEAR = {"L4": (2, 2), "L8": (2, 3), "L9": (3, 2), "L25": (5, 2), "L27": (3, 3)}
"""Arrays with p^k runs over the integers modulo a prime p: name, p, k."""
NAMES = ("L4", "L8", "L9", "L18", "L25", "L27")

# Differences modulo 3 of any two columns hold 0, 1 and 2 twice each.
_SCHEME = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [0, 0, 1, 1, 2, 2],
        [0, 1, 0, 2, 1, 2],
        [0, 2, 2, 1, 1, 0],
        [0, 1, 2, 0, 2, 1],
        [0, 2, 1, 2, 0, 1],
    ]
)


@dataclass(frozen=True)
class OrthogonalArray:
    """Codes (runs, columns) that count from 0, and the columns in the order in which factors take
    them.
    """

    name: str
    codes: Codes
    order: tuple[int, ...]

    @property
    def levels(self) -> tuple[int, ...]:
        """Number of levels of each column."""
        return tuple(int(column.max()) + 1 for column in self.codes.T)


def build_array(name: str) -> OrthogonalArray:
    """Return the orthogonal array of a name such as `L9`. Raises InputError for an unknown one."""
    if name.upper() not in NAMES:
        raise InputError(
            f"{name}: there is no plan of that name, it must be one of {', '.join(NAMES)}"
        )
    return _mixed() if name.upper() == "L18" else _linear(name.upper(), *LINEAR[name.upper()])


def _linear(name: str, p: int, k: int) -> OrthogonalArray:
    """One column for each point of the projective space over the field.

    Factors take the basis first, then the columns that mix most of it: their main effects are then
    free of two-factor interactions for as many factors as can be (all in L27 for 4, in L8 for 4).
    """
    runs = np.array(list(itertools.product(range(p), repeat=k)))
    vectors = [v[::-1] for v in itertools.product(range(p), repeat=k) if _leads_with_one(v)]
    vectors.sort(key=lambda v: (max(i for i, x in enumerate(v) if x), v[::-1]))
    weights = [sum(x != 0 for x in v) for v in vectors]
    order = sorted(range(len(vectors)), key=lambda i: (weights[i] != 1, -weights[i]))
    return OrthogonalArray(name, runs @ np.array(vectors).T % p, tuple(order))


def _leads_with_one(vector: tuple[int, ...]) -> bool:
    return next((x for x in vector if x), 0) == 1


def _mixed() -> OrthogonalArray:
    """L18: a column of two levels and seven of three."""
    rows = [
        (half, third, *((x + shift) % 3 for x in scheme))
        for (half, third), scheme in zip(
            itertools.product(range(2), range(3)), _SCHEME, strict=True
        )
        for shift in range(3)
    ]
    return OrthogonalArray("L18", np.array(rows), tuple(range(8)))
