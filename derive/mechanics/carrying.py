"""Whether joints carry what free motion needs of them, by the ranks of the balances at a random
pose.

    held actions + pushed(accelerations) = 0,    slopes accelerations = bends

A balance is a body's virtual motion: joints resist none that the constraints allow, and every other
one. A constraint whose slopes lie outside what they resist has a reaction of its own.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy import Expr

from ..evaluate import NotEvaluated, Point, UnknownNodeError, table_values
from ..model import Let
from ..quantity import Quantities, Quantity

Array = NDArray[np.float64]

RANK = 1e-8
"""Singular values below this share of the largest are zero: poses are closed to 1e-12, entries
differ by 1e3.
"""
CLOSED = 1e-12
"""Gaps below this, in SI units, are closed."""
SPREADS = (0.3, 0.1, 0.03, 0.01, 0.0)
"""Shares of a rad, or of a typical length, by which a pose differs from the start; a generic pose
has full rank.
"""
MOST_STEPS = 30
"""Newton steps onto the gaps."""


@dataclass(frozen=True)
class Pose:
    """Coordinates (k,) of a pose, and the values of all symbols there."""

    at: Array
    point: Point

    def matrix(self, rows: Sequence[Sequence[Expr]]) -> Array:
        """Return the values (m, n) of expressions."""
        values = [[float(self.point(entry)) for entry in row] for row in rows]
        return np.array(values).reshape(len(rows), -1 if rows else len(self.at))


class RandomPoses:
    """Poses of a statement near its start, at the values of its table, or random ones where it
    gives none.

    ``moving`` are its coordinates, ``parameters`` whatever else has any value, ``steps`` its named
    expressions, and ``further`` those that are evaluated at poses found.
    """

    def __init__(
        self,
        table: Quantities,
        start: Mapping[sp.Symbol, Expr],
        moving: Sequence[Quantity],
        parameters: Sequence[Quantity],
        steps: Sequence[Let],
        further: Sequence[Let],
    ) -> None:
        self._random = random.Random(0)  # one statement, one verdict
        self._steps, self._start, self._moving = steps, start, moving
        self._further = further
        self._data: dict[sp.Symbol, float] = {
            q: self._random.uniform(0.5, 1.5) for q in table.values()
        }
        self._data |= {q: float(value) for q, value in table_values(table).items()}
        lengths = [abs(self._data[q]) for q in table.values() if q.unit == "m"]
        self._length = float(np.median(lengths)) if lengths else 1.0
        self._parameters: dict[sp.Symbol, float] = {
            q: self._random.uniform(0.5, 1.5) for q in parameters
        }

    def draw(self, gaps: Sequence[Expr], slopes: Sequence[Sequence[Expr]]) -> Pose | None:
        """Return a pose that closes the gaps, whose slopes come first; None if none is found near
        the start.
        """
        for spread in SPREADS:
            try:
                return self.finish(self._close(spread, gaps, slopes[: len(gaps)]))
            except (NotEvaluated, ZeroDivisionError, OverflowError, np.linalg.LinAlgError):
                continue
            except UnknownNodeError:
                return None
        return None

    def derive_in(
        self, rates: Sequence[Quantity], pose: Pose, rows: Sequence[Expr]
    ) -> tuple[Array, Array]:
        """Return the values (m,) of rows without the ``rates``, and their slopes (m, k) in these,
        which are linear.
        """
        nothing = dict.fromkeys(rates, 0.0)
        rest, *more = (
            self.finish(self._at(pose.at, self._parameters | nothing | change)).matrix([rows])[0]
            for change in ({}, *({rate: 1.0} for rate in rates))
        )
        return rest, np.array(more).T - rest[:, None]

    def finish(self, pose: Pose) -> Pose:
        """Evaluate further expressions, also those that were stated since, and return the pose."""
        for step in self._further:
            if step.symbol not in pose.point:
                pose.point.set(step.symbol, pose.point(step.expr))
        return pose

    def _close(self, spread: float, gaps: Sequence[Expr], slopes: Sequence[Sequence[Expr]]) -> Pose:
        data = Point(self._data)
        sizes = [spread * (self._length if q.unit == "m" else 1.0) for q in self._moving]
        starts = [float(data(self._start.get(q, sp.S.Zero))) for q in self._moving]
        at = np.array(
            [self._random.gauss(start, size) for start, size in zip(starts, sizes, strict=True)]
        )
        for _ in range(MOST_STEPS):
            pose = self._at(at, self._parameters)
            values = pose.matrix([gaps])[0] if gaps else np.zeros(1)
            if np.abs(values).max() < CLOSED:
                return pose
            at = at - np.linalg.lstsq(pose.matrix(slopes), values, rcond=RANK)[0]
        raise NotEvaluated("the gaps do not close")

    def _at(self, at: Array, parameters: Mapping[sp.Symbol, float]) -> Pose:
        point = Point(
            {**self._data, **parameters, **dict(zip(self._moving, at.tolist(), strict=True))}
        )
        for step in self._steps:
            point.set(step.symbol, point(step.expr))
        return Pose(at, point)


def scale_columns(rows: Array) -> Array:
    """Return rows whose columns have length one, so that forces and moments count alike in a
    rank.
    """
    lengths = np.linalg.norm(rows, axis=0)
    return rows / np.where(lengths > 0, lengths, 1.0)


def count_rank(rows: Array) -> int:
    """Return the rank of rows (m, n)."""
    return int(np.linalg.matrix_rank(scale_columns(rows), tol=RANK)) if rows.size else 0


def null_space(rows: Array) -> Array:
    """Return an orthonormal basis (n, d) of what rows (m, n) map to zero."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, sizes, right = np.linalg.svd(rows)
    rank = int(np.sum(sizes > RANK * sizes.max(initial=0.0)))
    return right[rank:].T


def find_resistance(actions: Array, is_law: Sequence[bool], ways: Array) -> list[int]:
    """Return the indices of the actions that do work in virtual motions ``ways`` (m, d) of the
    balances.

    ``actions`` (m, n) are the slopes of the balances in the actions, with laws between these among
    the rows.
    """
    actions = scale_columns(actions)
    allowed = null_space(actions[np.array(is_law, dtype=bool)])
    work = ways.T @ actions
    if not work.size or np.abs(work @ allowed).max(initial=0.0) <= RANK * np.abs(ways).max():
        return []
    sizes = np.abs(work).max(axis=0)
    return np.flatnonzero(sizes > sizes.max() / 2).tolist()


def find_uncarried(actions: Array, columns: Sequence[Array]) -> list[int]:
    """Return the indices of the columns (m,) that ``actions`` (m, n) cannot replace.

    Columns that could replace each other all stay: what they share is statically indeterminate.
    """
    rank = count_rank(actions)
    return [
        i
        for i, column in enumerate(columns)
        if count_rank(np.column_stack([actions, column])) > rank
    ]


def find_unsupported(
    actions: Array, pushed: Array, by_acceleration: Array, slopes: Array, bends: Array
) -> Array | None:
    """Return the loads (m,) of balances that nothing carries, as far as they are; None if the
    balances can be met.

    ``pushed`` (m,) are the loads at rest and ``by_acceleration`` (m, k) their slopes in the
    accelerations, which meet ``slopes`` (c, k) and ``bends`` (c,).
    """
    ways = null_space(scale_columns(actions).T)
    rows = np.vstack([ways.T @ by_acceleration, slopes])
    right = np.concatenate([-ways.T @ pushed, bends])
    left = right - rows @ np.linalg.lstsq(rows, right, rcond=RANK)[0]
    loads: Array = ways @ left[: ways.shape[1]]
    return loads if np.abs(loads).max(initial=0.0) > RANK * np.abs(right).max(initial=0.0) else None
