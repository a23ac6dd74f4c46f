"""Places along an outline: lengths by quadrature, normals outwards, curvatures of the pieces."""

import numpy as np

from planter.workshop.arcs import sample_outline
from tests.support.outlines import lobes


def test_lengths_normals_and_curvatures_are_those_of_the_pieces() -> None:
    pieces = lobes(5)
    found = sample_outline(pieces, 64)
    ends = np.cumsum([piece.length for piece in pieces])
    np.testing.assert_allclose(found.length[found.piece == 4][-1], ends[-1], rtol=1e-8)
    np.testing.assert_allclose(found.length[64::65], ends, rtol=1e-8)
    along = np.diff(found.place[found.piece == 2], axis=0)
    across = found.normal[found.piece == 2][:-1] + found.normal[found.piece == 2][1:]
    assert np.abs((along * across).sum(axis=1)).max() < 1e-3 * np.hypot(*along.T).max()
    outwards = found.place + 1e-6 * found.normal
    assert (pieces[0].off(outwards) > 5e-7).all()
    radius = np.hypot(*outwards.T)
    assert (radius > pieces[0].polar(np.arctan2(outwards[:, 1], outwards[:, 0]))[0]).all()
    assert set(found.columns()) == {"arc_length_mm", "x_mm", "y_mm", "normal_x", "normal_y", "curvature_per_mm"}
