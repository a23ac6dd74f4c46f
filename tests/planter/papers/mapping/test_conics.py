"""Common points of two conics: all four, real and complex, in general and special positions."""

import numpy as np
import pytest

from planter.papers.mapping.dyads import common_points, eliminant


def pencil(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two conics (3, 3) through four points (4, 3): the null space of their conditions on a
    conic.
    """
    a, b, c = points.T
    rows = np.column_stack([a**2, b**2, c**2, 2 * a * b, 2 * a * c, 2 * b * c])
    stacked = np.vstack([rows.real, rows.imag])
    null = np.linalg.svd(stacked)[2][-2:]
    return tuple(
        np.array([[k[0], k[3], k[4]], [k[3], k[1], k[5]], [k[4], k[5], k[2]]]) for k in null
    )


def matched(common: list, points: np.ndarray) -> float:
    """Largest distance of a given point from the nearest one found."""
    rays = [p / np.linalg.norm(p) for p in points.astype(complex)]
    return max(min(np.linalg.norm(f.point - r * np.vdot(r, f.point)) for f in common) for r in rays)


@pytest.mark.parametrize("seed", range(20))
def test_four_real_points_are_recovered(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(4, 3))
    common = common_points(*pencil(points))
    assert [f.is_real for f in common] == [True] * 4
    assert matched(common, points) < 1e-10


@pytest.mark.parametrize("seed", range(20))
def test_complex_points_come_in_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, other = rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))
    points = np.array([first, first.conj(), other, other.conj()])
    common = common_points(*pencil(points))
    assert [f.is_real for f in common] == [False] * 4
    assert matched(common, points) < 1e-10


@pytest.mark.parametrize("column", [0, 1, 2])
def test_points_on_the_axes_of_the_plane_are_no_exception(column: int) -> None:
    """gamma = 0 is one of them: division by it would lose the point."""
    points = np.random.default_rng(7).normal(size=(4, 3))
    points[:2, column] = 0
    assert matched(common_points(*pencil(points)), points) < 1e-10


def test_vertical_points_are_distinguished() -> None:
    points = np.array([[0.3, 1, 1], [0.3, -2, 1], [1, 0.4, 1], [1, 5, 1.0]])
    assert matched(common_points(*pencil(points)), points) < 1e-10


def test_tangent_circles_touch_in_a_double_point() -> None:
    """x^2 + y^2 = 1 and (x - 3)^2 + y^2 = 4 touch at (1, 0); the circular points at infinity are
    the others.
    """
    first = np.diag([1.0, 1, -1])
    second = np.array([[1, 0, -3], [0, 1, 0], [-3, 0, 5.0]])
    points = {f.multiplicity: f for f in common_points(first, second) if f.is_real}
    assert set(points) == {2}
    assert points[2].point.real / points[2].point.real[2] == pytest.approx([1, 0, 1], abs=1e-7)
    assert sum(f.multiplicity for f in common_points(first, second)) == 4


def test_conics_with_a_curve_in_common_are_noticed() -> None:
    line, first, other = np.random.default_rng(3).normal(size=(3, 3))
    pairs = [np.outer(line, side) + np.outer(side, line) for side in (first, other)]
    assert common_points(*pairs) is None
    assert common_points(pairs[0], -2 * pairs[0]) is None
    assert common_points(pairs[0], np.zeros((3, 3))) is None
    assert common_points(pairs[0], pairs[1] + 1e-3 * np.eye(3)) is not None


def test_eliminant_vanishes_at_the_common_points_alone() -> None:
    points = np.random.default_rng(5).normal(size=(4, 3))
    quartic = eliminant(*pencil(points))
    values = np.polyval(quartic, points[:, 0] / points[:, 2])
    assert (
        np.abs(values).max()
        < 1e-12 * np.abs(quartic).max() * np.abs(points[:, 0] / points[:, 2]).max() ** 4
    )
    assert abs(np.polyval(quartic, 0.123)) > 1e-6 * np.abs(quartic).max()
