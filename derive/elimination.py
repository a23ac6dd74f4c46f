"""The order in which simultaneous equations are eliminated, from which of them hold which unknowns.

The targets eliminate columns from the first to the last, and bring up the row with the largest
entry where the code runs. The order keeps zeros zero, whichever rows that are: the matrix is upper
block triangular (Dulmage and Mendelsohn, Canadian Journal of Mathematics 10, 1958), and in a block
the column comes first whose elimination fills in the least (George and Ng, SIAM Journal on
Scientific and Statistical Computing 8, 1987).
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

Unknown = TypeVar("Unknown", bound=Hashable)


def match_rows(
    rows: Sequence[Collection[Unknown]], unknowns: Sequence[Unknown]
) -> dict[Unknown, int]:
    """Match as many unknowns as possible to a row each that holds them (augmenting paths)."""
    pairs: dict[Unknown, int] = {}

    def place(row: int, visited: set[Unknown]) -> bool:
        for unknown in (u for u in unknowns if u in rows[row] and u not in visited):
            visited.add(unknown)
            if unknown not in pairs or place(pairs[unknown], visited):
                pairs[unknown] = row
                return True
        return False

    for row in range(len(rows)):
        place(row, set())
    return pairs


def find_closure(first: Unknown, needs: Mapping[Unknown, Iterable[Unknown]]) -> set[Unknown] | None:
    """Return every unknown that must be known with the first; None where one of them has no
    equation.
    """
    closure, pending = {first}, [first]
    while pending:
        needed_unknowns = needs.get(pending.pop())
        if needed_unknowns is None:
            return None
        pending += [u for u in needed_unknowns if u not in closure]
        closure.update(needed_unknowns)
    return closure if closure <= needs.keys() else None


def order_elimination(rows: Sequence[Collection[int]]) -> tuple[list[int], list[int]]:
    """Return the order of the rows and of the columns of a square matrix, from the columns that
    each row holds.

    A matrix that is singular whatever its entries keeps its order.
    """
    count = len(rows)
    row_of = match_rows(rows, range(count))
    if len(row_of) < count:
        return list(range(count)), list(range(count))
    needs = {column: rows[row] for column, row in row_of.items()}
    blocks: dict[frozenset[int], list[int]] = {}
    for column in range(count):
        # columns that need the same ones need each other: they are a block
        blocks.setdefault(frozenset(find_closure(column, needs) or ()), []).append(column)
    row_order: list[int] = []
    column_order: list[int] = []
    for block in sorted(
        blocks, key=len, reverse=True
    ):  # what needs most is found last, from behind
        columns = blocks[block]
        for row, column in _order_block(
            {row_of[column]: set(rows[row_of[column]]) for column in columns}, columns
        ):
            row_order.append(row)
            column_order.append(column)
    return row_order, column_order


def _order_block(rows: dict[int, set[int]], columns: Iterable[int]) -> Iterator[tuple[int, int]]:
    """Yield rows and columns of a block in the order of the least fill-in, whichever rows become
    the pivots.

    Each row holds its column, so that it takes part where the column is eliminated anyway.
    """
    open_columns = sorted(columns)
    while open_columns:
        column = min(open_columns, key=lambda j: (_count_fill(rows, j), j))
        candidates = [row for row, entries in rows.items() if column in entries]
        union = set().union(*(rows[row] for row in candidates)) - {column}
        rows |= {row: set(union) for row in candidates}
        first = candidates[0]
        yield first, column
        del rows[first]
        open_columns.remove(column)


def _count_fill(rows: Mapping[int, set[int]], column: int) -> int:
    candidates = [entries for entries in rows.values() if column in entries]
    return (len(candidates) - 1) * len(set().union(*candidates))
