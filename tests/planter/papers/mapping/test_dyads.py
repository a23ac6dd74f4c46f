"""Dyads of five poses: they pass all poses, none is missing, and nothing hangs on units, frames or
basis.
"""

import numpy as np
import pytest
import scipy

from planter.errors import InputError
from planter.papers.mapping import model
from planter.papers.mapping.dyads import (
    Dyad,
    Scale,
    Solution,
    count_free_parameters,
    distinct,
    find_family,
    fit_dyads,
    misses,
    null_space,
    solve_dyads,
)
from tests.planter.papers.mapping.data import CORRECTED, inverse, random_poses, si


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


@pytest.mark.parametrize("seed", range(6))
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


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e6, 1e100])
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


def test_the_order_of_the_poses_does_not_matter() -> None:
    poses = random_poses(seeds_with(4)[0])
    for dyad, other in zip(
        solve_dyads(poses).dyads, solve_dyads(poses[[3, 0, 4, 2, 1]]).dyads, strict=True
    ):
        assert other.vector == pytest.approx(dyad.vector, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_kinematic_inversion_swaps_the_hinges(seed: int) -> None:
    poses = random_poses(seed)
    for dyad, other in zip(
        solve_dyads(poses).dyads, solve_dyads(inverse(poses)).dyads, strict=True
    ):
        assert other.vector == pytest.approx([*dyad.centre, *dyad.point, dyad.radius], rel=1e-8)


def test_roots_with_zero_gamma_are_included() -> None:
    """A basis of the null space whose third vector is not needed for a dyad: there the patent would
    divide by zero.
    """
    poses = random_poses(seeds_with(4)[1])
    scale = Scale.from_poses(poses)
    basis = null_space(scale.normalise(poses))[0]
    dyad = scale.normalise_dyad(solve_dyads(poses).dyads[0])
    p = basis @ (basis.T @ of_dyad(dyad))
    assert p == pytest.approx(of_dyad(dyad), rel=1e-9)
    turned = np.column_stack(
        [p / np.linalg.norm(p), np.linalg.qr(np.column_stack([p, basis]))[0][:, 1:3]]
    )
    solution = solve_dyads(poses, turned)
    assert worst(poses, solution.dyads) < 1e-10
    for plain, other in zip(solve_dyads(poses).dyads, solution.dyads, strict=True):
        assert other.vector == pytest.approx(plain.vector, rel=1e-9)


def of_dyad(dyad: np.ndarray) -> np.ndarray:
    """Coefficients p1..p8 as the patent prints them, for a0 = 1."""
    x, y, a1, a2, radius = dyad
    a3 = radius**2 - a1**2 - a2**2
    return np.array(
        [-1, x, y, a1, a2, a2 * x - a1 * y, -(a1 * x + a2 * y) / 2, (a3 - x**2 - y**2) / 4]
    )


PRINTED = {
    # moving point, centre, radius, moving hinges of the poses 1 and 4, as the patent prints them
    # [mm]
    0: ((-199.9259, -69.1470), (-43.835, 15.533), 99.724, (26.1041, 86.6203), (-6.3085, -76.8614)),
    1: (
        (-10.0829, -9.4963),
        (137.487, -70.4616),
        202.0462,
        (223.421, 112.399),
        (69.6611, -260.7831),
    ),
}


@pytest.mark.parametrize("number", [0, 1])
def test_printed_dyads_and_hinges(number: int) -> None:
    poses = si(CORRECTED)
    dyad = solve_dyads(poses).dyads[number]
    point, centre, radius, first, fourth = PRINTED[number]
    assert dyad.point * 1e3 == pytest.approx(point, abs=6e-5)
    assert dyad.centre * 1e3 == pytest.approx(centre, abs=6e-4)
    assert dyad.radius * 1e3 == pytest.approx(radius, abs=6e-4 if number == 0 else 1e-4)
    hinges = model.place_point(poses, dyad.point) * 1e3
    assert hinges[0] == pytest.approx(first, abs=6e-4)
    assert hinges[3] == pytest.approx(fourth, abs=6e-5)


def test_printed_first_pose_has_no_dyads() -> None:
    solution = solve_dyads(si([(235, 120, 10), *CORRECTED[1:]]))
    assert len(solution.dyads) == 4
    for point, _, _, _, _ in PRINTED.values():
        assert min(np.hypot(*(d.point * 1e3 - point)) for d in solution.dyads) > 10


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


def test_family_members_share_a_fifth_pose() -> None:
    poses = si(CORRECTED)
    members, _ = find_family(poses[:4])
    both = solve_dyads(poses).dyads
    for dyad in both:
        nearest = min(members, key=lambda m: np.hypot(*(m.point - dyad.point)))
        assert np.hypot(*(nearest.point - dyad.point)) < 0.02


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


def test_circular_translation_has_every_point() -> None:
    turn = np.array([0.1, 1.0, 2.5, 3.0, 5.0])
    poses = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    dyads, _ = find_family(poses)
    assert worst(poses, dyads) < 1e-10
    assert [d.radius for d in dyads] == pytest.approx([1.0] * len(dyads), rel=1e-9)


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
