"""Dyads of five poses: they pass all poses, none is missing, and nothing hangs on units, frames or
basis; common points of two conics, in general and special positions."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from planter.errors import InputError
from planter.papers.mapping import model
from planter.papers.mapping.dyads import (
    Dyad,
    Scale,
    Solution,
    common_points,
    count_free_parameters,
    distinct,
    find_family,
    fit_dyads,
    misses,
    solve_dyads,
)
from tests.planter.papers.mapping.data import CORRECTED, inverse, random_poses, si


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


@pytest.mark.parametrize("seed", range(5))
def test_four_real_points_are_recovered(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(4, 3))
    common = common_points(*pencil(points))
    assert [f.is_real for f in common] == [True] * 4
    assert matched(common, points) < 1e-10


@pytest.mark.parametrize("seed", range(5))
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


def worst(poses: np.ndarray, dyads: list[Dyad]) -> float:
    """Largest miss in parts of the poses' size, by complex numbers."""
    place, turn = poses[:, 0] + 1j * poses[:, 1], np.exp(1j * poses[:, 2])
    size = Scale.from_poses(poses).size
    gaps = [abs(place + turn * complex(*d.point) - complex(*d.centre)) - d.radius for d in dyads]
    return max(np.abs(gap).max() / (size + d.radius) for gap, d in zip(gaps, dyads, strict=True))


def by_number(solution: Solution) -> int:
    return sum(d.multiplicity for d in solution.dyads) + sum(
        s.multiplicity for s in solution.straights
    )


def seeds_with(count: int) -> list[int]:
    return [seed for seed in range(40) if len(solve_dyads(random_poses(seed)).dyads) == count][:4]


@pytest.mark.parametrize("count", [0, 2, 4])
def test_random_poses_have_zero_two_or_four_dyads(count: int) -> None:
    seeds = seeds_with(count)
    assert len(seeds) == 4
    for seed in seeds:
        solution = solve_dyads(random_poses(seed))
        assert by_number(solution) + solution.complex_roots == 4
        if count:
            assert worst(random_poses(seed), solution.dyads) < 1e-10


def test_a_moved_hinge_misses() -> None:
    poses = si(CORRECTED)
    dyad = solve_dyads(poses).dyads[0]
    moved = Dyad(dyad.point + np.array([1e-6, 0]), dyad.centre, dyad.radius)
    assert worst(poses, [dyad]) < 1e-14
    assert worst(poses, [moved]) > 1e-8


@pytest.mark.parametrize("seed", range(3))
def test_no_dyad_is_missing(seed: int) -> None:
    """Against roots of a general solver from many starts, which knows nothing of mapping or
    conics.
    """
    poses = random_poses(seed)
    place, turn = poses[:, 0] + 1j * poses[:, 1], np.exp(1j * poses[:, 2])

    def differences(z: np.ndarray) -> np.ndarray:
        return np.diff(np.abs(place + turn * complex(*z[:2]) - complex(*z[2:])) ** 2)

    dyads = solve_dyads(poses).dyads
    vectors = [np.array([*d.point, *d.centre]) for d in dyads]
    reached = set()
    for start in np.random.default_rng(seed).normal(scale=0.5, size=(60, 4)):
        root = scipy.optimize.root(differences, start, tol=1e-14)
        if (
            root.success
            and np.abs(differences(root.x)).max() < 1e-13
            and np.abs(root.x).max() < 1e2
        ):
            matches = [
                k
                for k, z in enumerate(vectors)
                if np.abs(z - root.x).max() < 1e-4 * (1 + np.abs(z).max())
            ]
            assert matches, "a dyad that the conics do not have"
            reached.add(matches[0])
    assert len(reached) >= min(len(dyads), 1)


@pytest.mark.parametrize("scale", [1e-9, 1e100])
def test_units_do_not_matter(scale: float) -> None:
    poses = si(CORRECTED)
    scaled = poses * [scale, scale, 1]
    for dyad, other in zip(solve_dyads(poses).dyads, solve_dyads(scaled).dyads, strict=True):
        assert other.vector == pytest.approx(scale * dyad.vector, rel=1e-10)


def test_frames_do_not_matter() -> None:
    """Another fixed frame moves the centres, another place of the body's origin the moving
    points.
    """
    poses = si(CORRECTED)
    z = poses[:, 0] + 1j * poses[:, 1]
    moved = np.exp(0.7j) * z + (0.4 - 0.2j) + np.exp(1j * (poses[:, 2] + 0.7)) * (0.03 + 0.05j)
    pose_file = np.column_stack([moved.real, moved.imag, poses[:, 2] + 0.7])
    for dyad, other in zip(solve_dyads(poses).dyads, solve_dyads(pose_file).dyads, strict=True):
        assert other.radius == pytest.approx(dyad.radius, rel=1e-10)
        assert complex(*other.centre) == pytest.approx(
            np.exp(0.7j) * complex(*dyad.centre) + 0.4 - 0.2j, rel=1e-10
        )
        assert complex(*other.point) == pytest.approx(
            complex(*dyad.point) - 0.03 - 0.05j, rel=1e-10
        )


@pytest.mark.parametrize("seed", range(5))
def test_kinematic_inversion_swaps_the_hinges(seed: int) -> None:
    poses = random_poses(seed)
    for dyad, other in zip(
        solve_dyads(poses).dyads, solve_dyads(inverse(poses)).dyads, strict=True
    ):
        assert other.vector == pytest.approx([*dyad.centre, *dyad.point, dyad.radius], rel=1e-8)


def on_line(poses: np.ndarray, solution: Solution) -> float:
    """How far the points of sliders are off their lines, and the lines of swinging ones off their
    points.
    """
    gaps = []
    for s in solution.straights:
        where = poses if s.kind == "slider" else inverse(poses)
        places = model.place_point(where, np.array(s.point_mm) * 1e-3)
        gaps.append(np.abs(places @ s.normal - s.offset_mm * 1e-3).max())
    return max(gaps)


def test_collinear_poses_have_a_slider() -> None:
    poses = random_poses(3)
    poses[:, 1] = 0.1 + 0.5 * poses[:, 0]
    solution = solve_dyads(poses)
    (slider,) = solution.straights
    assert slider.kind == "slider"
    assert slider.point_mm == pytest.approx((0, 0), abs=1e-9)
    assert np.dot(slider.normal, [1, 0.5]) == pytest.approx(0, abs=1e-12)
    assert on_line(poses, solution) < 1e-12
    assert by_number(solution) + solution.complex_roots == 4
    assert worst(poses, solution.dyads) < 1e-10


def test_inverse_of_collinear_poses_has_a_swinging_line() -> None:
    poses = random_poses(3)
    poses[:, 1] = 0.1 + 0.5 * poses[:, 0]
    solution = solve_dyads(inverse(poses))
    assert [s.kind for s in solution.straights] == ["swinging line"]
    assert on_line(inverse(poses), solution) < 1e-12


def test_a_nearly_straight_circle_is_still_a_circle() -> None:
    poses = random_poses(3)
    poses[:, 1] = 1e-6 * poses[:, 0] ** 2
    solution = solve_dyads(poses)
    large = max(solution.dyads, key=lambda d: d.radius)
    assert not solution.straights
    assert large.radius == pytest.approx(0.5e6, rel=1e-2)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_fewer_poses_leave_a_family(count: int) -> None:
    poses = si(CORRECTED)[:count]
    assert count_free_parameters(poses) == 5 - count
    dyads, _ = find_family(poses)
    assert len(dyads) > 50
    assert worst(poses, dyads) < 1e-10


def test_repeated_poses_count_once() -> None:
    poses = si(CORRECTED)
    twice = np.vstack([poses, poses[1] + [0, 0, 2 * np.pi]])
    assert len(distinct(twice)) == 5
    assert [d.radius for d in solve_dyads(twice).dyads] == pytest.approx(
        [d.radius for d in solve_dyads(poses).dyads], rel=1e-9
    )
    assert solve_dyads(poses[[0, 1, 2, 3, 3]]).free == 1
    with pytest.raises(InputError, match="one and the same"):
        find_family(poses[[0, 0]])


def test_pure_translation_has_no_dyads() -> None:
    poses = random_poses(4)
    poses[:, 2] = 0.3
    assert count_free_parameters(poses) == 1
    assert find_family(poses) == ([], [])


def test_pure_rotation_has_every_point_about_the_pole() -> None:
    """But for the point at the pole itself, which keeps its distance from everything."""
    poses = random_poses(4)
    poses[:, :2] = (0.1, 0.2)
    assert count_free_parameters(poses) == 2
    dyads, _ = find_family(poses)
    assert worst(poses, dyads) < 1e-10
    assert max(min(np.hypot(*(d.centre - (0.1, 0.2))), np.hypot(*d.point)) for d in dyads) < 1e-6


def on_a_dyad(seed: int, count: int, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    dyad = np.array([0.1, -0.05, 0.2, 0.1, 0.15])
    theta, phi = rng.uniform(-2, 2, (2, count))
    hinge = complex(*dyad[2:4]) + dyad[4] * np.exp(1j * theta) * (
        1 + noise * rng.normal(size=count)
    )
    tip = hinge - np.exp(1j * phi) * complex(*dyad[:2])
    return dyad, np.column_stack([tip.real, tip.imag, phi])


def test_extra_poses_recover_the_dyad() -> None:
    dyad, poses = on_a_dyad(1, 9)
    solution = fit_dyads(poses)
    best = min(solution.dyads, key=lambda d: misses(poses, d.vector).max())
    assert best.vector == pytest.approx(dyad, abs=1e-9)


def test_more_poses_are_fitted_by_least_squares() -> None:
    dyad, poses = on_a_dyad(2, 12, noise=1e-3)
    solution = fit_dyads(poses)

    def cost(vector: np.ndarray) -> float:
        return float(np.sum(misses(poses, vector) ** 2))

    best = min((d.vector for d in solution.dyads), key=cost)
    assert best == pytest.approx(dyad, abs=0.02)
    assert cost(best) < cost(dyad)
    for direction in np.vstack([np.eye(5), -np.eye(5)]):
        assert cost(best + 1e-5 * direction) > cost(best)


def test_cardan_motion_has_a_circle_of_line_points() -> None:
    """Cardan circles: five poses in general, and yet a family, the conics having a curve in
    common.
    """
    turn = np.array([0.2, 0.9, 1.7, 2.6, 4.0])
    poses = np.column_stack([0.1 * np.cos(turn), 0 * turn, turn])
    solution = solve_dyads(poses)
    assert (solution.free, count_free_parameters(poses)) == (1, 0)
    dyads, straights = find_family(poses)
    assert dyads == []
    assert {s.kind for s in straights} == {"slider"}
    assert len(straights) > 50
    assert on_line(poses, Solution([], straights, 0, 0, solution.singular_values)) < 1e-10
    assert [np.hypot(s.point_mm[0] + 50, s.point_mm[1]) for s in straights] == pytest.approx(
        [50] * len(straights), abs=1e-9
    )
