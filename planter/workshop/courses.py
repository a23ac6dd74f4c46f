"""Places along exact pieces as a table: arc length, place, normal, curvature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.workshop.outline import Piece


@dataclass(frozen=True)
class Course:
    """Places (n, 2) [m] with outward normals (n, 2), arc lengths (n,) [m] and curvatures (n,) [1/m]; `piece` (n,)."""

    length: Array
    place: Array
    normal: Array
    curvature: Array
    piece: Array

    def columns(self) -> dict[str, Array]:
        """What a table shows, by keys that end in their units."""
        return {
            "arc_length_mm": self.length * 1e3,
            "x_mm": self.place[:, 0] * 1e3,
            "y_mm": self.place[:, 1] * 1e3,
            "normal_x": self.normal[:, 0],
            "normal_y": self.normal[:, 1],
            "curvature_per_mm": self.curvature * 1e-3,
        }


def course(pieces: Sequence[Piece], steps: int) -> Course:
    """Places along pieces that follow each other anticlockwise, each in `steps` equal steps of its parameter, ends too.

    Between two places the length is that of an arc along both tangents.
    """
    s = np.linspace(0.0, 1.0, steps + 1)
    places, tangents = np.array([piece.at(s) for piece in pieces]), np.array([piece.tangent(s) for piece in pieces])
    chords, (one, two) = np.diff(places, axis=1), (tangents[:, :-1], tangents[:, 1:])
    half = np.arctan2(one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0], (one * two).sum(axis=-1)) / 2
    lengths = np.hypot(chords[..., 0], chords[..., 1]) / np.sinc(half / np.pi)
    ends = np.cumsum(lengths.sum(axis=1))
    within = np.hstack([np.zeros((len(pieces), 1)), np.cumsum(lengths, axis=1)])
    along = within + np.concatenate([[0.0], ends[:-1]])[:, None]
    normals = np.stack([tangents[..., 1], -tangents[..., 0]], axis=-1)
    curvature = np.array([piece.curvature(s) for piece in pieces])
    return Course(
        along.ravel(), places.reshape(-1, 2), normals.reshape(-1, 2), curvature.ravel(),
        np.repeat(np.arange(len(pieces)), steps + 1),
    )  # fmt: skip
