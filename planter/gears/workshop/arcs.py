"""Curves of exact pieces, and of circular arcs that follow them within a tolerance.

An arc is given as in drawings by the bulge at its first vertex: a quarter of the central angle has
this tangent, positive to the left, zero for a straight line. A biarc is two arcs with a common
tangent where they meet, from point and tangent to point and tangent. There is one for each ratio of
the two outer tangents, as far as they meet the tangent at the joint (Bolton, Biarc curves,
Computer-Aided Design 7, 1975). Here the ratio is the one that preserves the area next to the curve.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planter.errors import ComputationError
from planter.gears.geometry.pieces import Piece
from planter.kernels import Array
from planter.numerics.arrays import rotation_matrix


def tabulate_outline(pieces: Sequence[Piece], steps: int) -> dict[str, Array]:
    """Return columns (n,) of consecutive pieces, anticlockwise, by keys that end in their units:
    each piece in `steps` equal steps of its parameter, ends included; normals are outwards.

    The length between two points is that of an arc along both tangents.
    """
    s = np.linspace(0.0, 1.0, steps + 1)
    rows = np.array([piece.rows(s) for piece in pieces])
    x, y, dx, dy, curvature = rows.swapaxes(0, 1)
    across = dx[:, :-1] * dy[:, 1:] - dy[:, :-1] * dx[:, 1:]
    half = np.arctan2(across, dx[:, :-1] * dx[:, 1:] + dy[:, :-1] * dy[:, 1:]) / 2
    lengths = np.hypot(np.diff(x), np.diff(y)) / np.sinc(half / np.pi)
    on_piece = np.hstack([np.zeros((len(pieces), 1)), np.cumsum(lengths, axis=1)])
    before = np.cumsum(lengths.sum(axis=1)) - lengths.sum(axis=1)
    columns = {
        "arc_length_mm": 1e3 * (on_piece + before[:, None]),
        "x_mm": 1e3 * x,
        "y_mm": 1e3 * y,
        "normal_x": dy,
        "normal_y": -dx,
        "curvature_per_mm": 1e-3 * curvature,
    }
    return {key: values.ravel() for key, values in columns.items()}


_SMALL = 1e-3
"""Half angle [rad] below which the area of a segment is a series, whose next term is below
rounding.
"""


@dataclass(frozen=True)
class Arcs:
    """A curve of arcs: `vertices` (n, 2) [m], `bulges` (n,); the last arc of a closed one leads to
    the first vertex.

    An open one has a bulge of 0 at its last vertex. `deviation` is the largest from a curve that
    the arcs follow [m].
    """

    vertices: Array
    bulges: Array
    closed: bool = True
    deviation: float = 0.0

    @property
    def chords(self) -> Array:
        """Vectors from each vertex to the next, (n, 2) [m] if closed, else (n - 1, 2)."""
        if self.closed:
            return np.roll(self.vertices, -1, axis=0) - self.vertices
        return np.diff(self.vertices, axis=0)

    @property
    def half_angles(self) -> Array:
        """Half the central angle of each arc [rad], which is also the angle between chord and
        tangent at its start.
        """
        return 2 * np.arctan(self.bulges[: len(self.chords)])

    @property
    def lengths(self) -> Array:
        """Length of each arc [m]."""
        return np.hypot(*self.chords.T) / np.sinc(self.half_angles / np.pi)

    @property
    def area(self) -> float:
        """Area of a closed curve [m2], positive where it runs anticlockwise."""
        x, y = self.vertices.T
        polygon = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
        return float(
            polygon + (np.hypot(*self.chords.T) ** 2 * _segment_area(self.half_angles)).sum()
        )

    def points(self, tolerance: float) -> Array:
        """Return points (k, 2) [m] on the curve with chords within `tolerance` [m] of its arcs,
        including all vertices.

        The first point of a closed curve is not repeated.
        """
        half, chords = self.half_angles, self.chords
        counts = np.maximum(
            1, np.ceil(np.sqrt(self.lengths * np.abs(half) / (4 * tolerance)))
        ).astype(int)
        arc = np.repeat(np.arange(len(chords)), counts)
        step = np.arange(len(arc)) - np.repeat(np.cumsum(counts) - counts, counts)
        points = interpolate_arcs(self.vertices[arc], chords[arc], half[arc], step / counts[arc])
        return points if self.closed else np.vstack([points, self.vertices[-1]])

    def moved(self, turn: float, shift: tuple[float, float] | Array = (0.0, 0.0)) -> Arcs:
        """Return the curve rotated about the origin by `turn` [rad], then shifted [m]."""
        return replace(self, vertices=self.vertices @ rotation_matrix(-turn) + np.asarray(shift))


def interpolate_arcs(start: Array, chord: Array, half: Array, share: Array) -> Array:
    """Return points (n, 2) [m] at shares (n,) of the lengths of n arcs with chords (n, 2) [m], half
    angles (n,) " "[rad].
    """
    angle = half * share
    size = share * np.sinc(angle / np.pi) / np.sinc(half / np.pi)
    turn = angle - half
    c, s = size * np.cos(turn), size * np.sin(turn)
    x, y = chord.T
    return start + np.column_stack([c * x - s * y, s * x + c * y])


def build_circle(radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> Arcs:
    """Return a circle [m] as two half circles, anticlockwise."""
    x, y = centre
    return Arcs(np.array([[x - radius, y], [x + radius, y]]), np.ones(2))


def _segment_area(half: Array) -> Array:
    """Return the area between arc and chord over the chord's square, positive to the right of the
    chord.
    """
    safe = np.where(np.abs(half) < _SMALL, _SMALL, half)
    exact = (2 * safe - np.sin(2 * safe)) / (8 * np.sin(safe) ** 2)
    return np.where(np.abs(half) < _SMALL, half / 6 * (1 + 2 * half**2 / 15), exact)


Indices = NDArray[np.intp]

SAMPLES = 16
"""Steps of a biarc, at whose ends the deviation is measured."""
SEEN_SHARE = 0.95
"""Smallest share of the largest deviation that these points see if the curvature changes evenly."""
_GRID = 4 * SAMPLES
"""Steps of a piece per evaluation: it can be halved twice before the next one."""
_MAX_CALLS = 4
_MERGE_SHARE = 1e-3
"""Share of the tolerance below which the two arcs of a biarc are merged."""


def fit_arcs(pieces: Sequence[Piece], tolerance: float, closed: bool = True) -> Arcs:
    """Return arcs within `tolerance` [m] of consecutive pieces, on either side and as seen from
    either.

    Raises ComputationError, naming the piece, if no arcs follow it.
    """
    keys, parts = zip(*_fit_spans(pieces, SEEN_SHARE * tolerance), strict=True)
    # spans are fitted by size; the outline needs them in its direction
    order = np.lexsort(np.hstack(keys)[::-1])
    biarcs = Biarcs(
        *(
            np.concatenate(rows)[order]
            for rows in zip(*(vars(part).values() for part in parts), strict=True)
        )
    )
    # circles and lines become single arcs, as a workshop expects
    single = biarcs.merge_deviation < _MERGE_SHARE * tolerance
    needed = np.ravel(np.column_stack([np.ones_like(single), ~single]))
    vertices = np.stack([biarcs.start, biarcs.joint], axis=1).reshape(-1, 2)
    halves = np.where(single[:, None], biarcs.half.sum(axis=1, keepdims=True), biarcs.half).ravel()
    vertices, bulges = vertices[needed], np.tan(halves[needed] / 2)
    if not closed:
        vertices, bulges = np.vstack([vertices, pieces[-1].at(np.ones(1))]), np.append(bulges, 0.0)
    return Arcs(vertices, bulges, closed, float(biarcs.deviation.max()) / SEEN_SHARE)


def _fit_spans(pieces: Sequence[Piece], limit: float) -> Iterator[tuple[Array, Biarcs]]:
    """Yield keys (2, m), piece and parameter, and biarcs whose measured deviation is at most
    `limit` [m].
    """
    number, low, width = np.arange(len(pieces)), np.zeros(len(pieces)), 1.0
    for _ in range(_MAX_CALLS):
        places, tangents = _evaluate_spans(pieces, number, low, width)
        row, first = np.arange(len(number)), np.zeros(len(number), dtype=int)
        for steps in (4, 2, 1):
            index = row[:, None], first[:, None] + steps * np.arange(SAMPLES + 1)
            biarcs = join_biarcs(places[index], tangents[index])
            good = biarcs.deviation <= limit
            yield (
                np.array([number[row], low[row] + width * first / _GRID])[:, good],
                biarcs.select(good),
            )
            row, first = np.repeat(row[~good], 2), np.repeat(first[~good], 2)
            first[1::2] += steps * SAMPLES // 2
        if not len(row):
            return
        number, low, width = (
            number[row],
            low[row] + width * first / _GRID,
            width / (2 * _GRID // SAMPLES),
        )
    piece = pieces[int(number[0])]
    raise ComputationError(
        f"piece {number[0]}, {piece.kind}, turns too sharply for arcs within {limit * 1e6:g} um"
    )


def _evaluate_spans(
    pieces: Sequence[Piece], number: Indices, low: Array, width: float
) -> tuple[Array, Array]:
    """Return points [m] and unit tangents (m, _GRID + 1, 2) of m spans of pieces."""
    share = np.linspace(0.0, 1.0, _GRID + 1)
    spans = [
        (pieces[i], start + width * share)
        for i, start in zip(number.tolist(), low.tolist(), strict=True)
    ]
    return np.array([piece.at(s) for piece, s in spans]), np.array(
        [piece.tangent(s) for piece, s in spans]
    )


MIN_COSINE = 0.5
"""Smallest cosine between a curve and its arcs: above it, a deviation across is valid as seen from
either.
"""
MAX_HALF_ANGLE = np.pi / 4
"""Largest half angle of an arc [rad]."""
_SECOND_RATIO = 1.1
"""Second ratio; from it and the first, 1, secants lead to the ratio without area."""
_SECANTS = 2
_MAX_RATIO = 3.0
"""Largest ratio, and the inverse of the smallest."""


@dataclass(frozen=True)
class Biarcs:
    """m biarcs: starts, joints and ends (m, 2) [m], half angles of their arcs (m, 2) [rad].

    `deviation` (m,) is the largest distance from the curves [m], infinite if a biarc does not
    follow its curve; `area` (m,) lies between the two, positive where the curve is to the left
    [m2].
    """

    start: Array
    joint: Array
    end: Array
    half: Array
    deviation: Array
    area: Array

    def select(self, mask: NDArray[np.bool_]) -> Biarcs:
        """Return the biarcs of a mask (m,)."""
        return Biarcs(*(rows[mask] for rows in vars(self).values()))

    @property
    def merge_deviation(self) -> Array:
        """Deviation of one common arc from the two arcs of each biarc (m,) [m], by the difference
        of their " "curvatures.
        """
        squares = np.column_stack(
            [compute_products(arc, arc) for arc in (self.joint - self.start, self.end - self.joint)]
        )
        curvature = 2 * np.sin(self.half) / np.sqrt(squares)
        return np.abs(curvature[:, 1] - curvature[:, 0]) * squares.max(axis=1) / 8


@np.errstate(divide="ignore", invalid="ignore")
def join_biarcs(places: Array, tangents: Array) -> Biarcs:
    """Return biarcs of m spans of curves, from points [m] and unit tangents (m, k, 2) of each."""
    last, ratio = np.ones(len(places)), np.full(len(places), _SECOND_RATIO)
    equal = before = _build_biarcs(places, tangents, last)
    pairs = _build_biarcs(places, tangents, ratio)
    for _ in range(_SECANTS):
        target = ratio - pairs.area * (ratio - last) / (pairs.area - before.area)
        last, before = ratio, pairs
        ratio = np.clip(np.where(np.isfinite(target), target, 1.0), 1 / _MAX_RATIO, _MAX_RATIO)
        pairs = _build_biarcs(places, tangents, ratio)
    # the ratio without area may be no better where secants failed
    better = pairs.deviation <= equal.deviation
    return Biarcs(
        *(
            np.where(better.reshape(-1, *[1] * (old.ndim - 1)), new, old)
            for old, new in zip(vars(equal).values(), vars(pairs).values(), strict=True)
        )
    )


def _build_biarcs(places: Array, tangents: Array, ratio: Array) -> Biarcs:
    """Return biarcs whose second outer tangent is `ratio` (m,) times as long as the first."""
    start, end, first, last = places[:, 0], places[:, -1], tangents[:, 0], tangents[:, -1]
    chord = end - start
    square, forward = (
        compute_products(chord, chord),
        compute_products(chord, first + ratio[:, None] * last),
    )
    reach = square / (
        forward + np.sqrt(forward**2 + 2 * ratio * (1 - compute_products(first, last)) * square)
    )
    first_corner, second_corner = (
        start + reach[:, None] * first,
        end - (ratio * reach)[:, None] * last,
    )
    joint = (ratio[:, None] * first_corner + second_corner) / (1 + ratio)[:, None]
    half = np.column_stack(
        [_compute_angles(first, joint - start), _compute_angles(end - joint, last)]
    )
    across = (joint - first_corner) / np.sqrt(
        compute_products(joint - first_corner, joint - first_corner)
    )[:, None]
    arcs = ((start, first, half[:, 0], joint - start), (joint, across, half[:, 1], end - joint))
    (first_offset, first_cosine), (second_offset, second_cosine) = (
        _offsets(places, tangents, *arc) for arc in arcs
    )
    beyond = compute_products(places - joint[:, None], across[:, None]) > 0
    offset, cosine = (
        np.where(beyond, second_offset, first_offset),
        np.where(beyond, second_cosine, first_cosine),
    )
    valid = (
        (forward > 0)
        & (cosine.min(axis=1) > MIN_COSINE)
        & (np.abs(half).max(axis=1) < MAX_HALF_ANGLE)
    )
    steps = np.sqrt(compute_products(np.diff(places, axis=1), np.diff(places, axis=1)))
    area = ((offset[:, 1:] + offset[:, :-1]) / 2 * steps).sum(axis=1)
    return Biarcs(
        start, joint, end, half, np.where(valid, np.abs(offset).max(axis=1), np.inf), area
    )


def _offsets(
    places: Array, tangents: Array, start: Array, tangent: Array, half: Array, chord: Array
) -> tuple[Array, Array]:
    """Return distances [m] of points (m, k, 2) from m arcs, positive to the left, and cosines of
    their directions.
    """
    curvature = (2 * np.sin(half) / np.sqrt(compute_products(chord, chord)))[:, None]
    normal, from_start = (
        np.column_stack([-tangent[:, 1], tangent[:, 0]])[:, None],
        places - start[:, None],
    )
    left, square = compute_products(from_start, normal), compute_products(from_start, from_start)
    root = np.sqrt(np.maximum(1 - 2 * curvature * left + curvature**2 * square, 0.0))
    inward = normal - curvature[..., None] * from_start
    onwards = np.stack([inward[..., 1], -inward[..., 0]], axis=-1)
    return (2 * left - curvature * square) / (1 + root), compute_products(onwards, tangents) / root


def compute_products(a: Array, b: Array) -> Array:
    """Return scalar products (...) of vectors (..., 2)."""
    return np.einsum("...i,...i", a, b)


def _compute_angles(a: Array, b: Array) -> Array:
    """Return angles (m,) from vectors a to vectors b (m, 2), in (-pi, pi]."""
    return np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], compute_products(a, b))
