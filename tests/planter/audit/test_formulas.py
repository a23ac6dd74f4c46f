"""Formulas behind printed numbers and statements: each computed by hand or in another way here."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from planter.audit import numbers
from planter.audit.registry import FORMULAS, Inputs
from planter.papers.clutch import printed as clutch
from planter.papers.pickup import printed as pickup
from tests.planter.papers.pickup import pickups

LAW = {
    "L1_mm": 93.3377,
    "L2_mm": 163.0,
    "law_p": 0.35,
    "dwell_deg": [210, 270],
    "phi5_far_deg": 40,
    "gamma_deg": 150,
    "centre_distance_mm": 44.6,
}


def inputs(**arguments: Any) -> Inputs:
    return Inputs(arguments, {}, {})


def of_poses(by: str, poses: np.ndarray, **arguments: Any) -> Any:
    """What a formula gives for five poses (5, 3) [mm, mm, deg] that are called pose 1 to pose 5."""
    values = {f"pose {i}": pose.tolist() for i, pose in enumerate(poses, 1)}
    names = list(values)
    return FORMULAS[by](inputs(poses="five", five=names, counted=names, **values, **arguments))


def printed_poses() -> np.ndarray:
    table = numbers.load_numbers()["disclosed"]["sun2019"]
    return np.array([table[f"pose {i}"] for i in range(1, 6)], dtype=float)


def hinges(poses: np.ndarray, dyad: int) -> np.ndarray:
    return np.array(
        [
            [
                of_poses("moving hinge", poses, dyad=dyad, pose=f"pose {i}", axis=axis)
                for axis in (1, 2)
            ]
            for i in range(1, 6)
        ]
    )


def conditions(poses: np.ndarray) -> np.ndarray:
    """Rows (5, 8) of the circle condition by hand, in mm."""
    x, y, half = *poses[:, :2].T, np.radians(poses[:, 2]) / 2
    z3, z4 = np.sin(half), np.cos(half)
    z1, z2 = (x * z3 - y * z4) / 2, (x * z4 + y * z3) / 2
    columns = [z1**2 + z2**2, z1 * z3 - z2 * z4, z2 * z3 + z1 * z4, z1 * z3 + z2 * z4]
    columns += [z2 * z3 - z1 * z4, z3 * z4, z3**2 - z4**2, z3**2 + z4**2]
    return np.column_stack(columns)


def test_hinges_stay_on_the_circle_of_the_coefficients() -> None:
    poses = printed_poses()
    for dyad in range(1, 5):
        a0, a1, a2, a3 = (
            of_poses(
                "circle coefficient",
                poses,
                dyad=dyad,
                coefficient=f"a{i}",
                scale_of="a1",
                scale=2.5,
            )
            for i in range(4)
        )
        x, y = hinges(poses, dyad).T
        assert a1 == pytest.approx(2.5)
        assert a0 * (x**2 + y**2) == pytest.approx(2 * a1 * x + 2 * a2 * y + a3, rel=1e-9)
        radius = of_poses("dyad", poses, dyad=dyad, part="r")
        assert np.sqrt(a3 / a0 + (a1**2 + a2**2) / a0**2) == pytest.approx(radius, rel=1e-9)


def test_vectors_of_the_null_space_solve_the_conditions() -> None:
    """A by hand in mm; the three given entries are kept, and the nearest basis is orthonormal."""
    poses, table = printed_poses(), numbers.load_numbers()["disclosed"]["sun2019"]
    rows = conditions(poses)
    size = np.linalg.norm(rows, axis=0)
    values = {name: table[name] for name in table if name.startswith("v_") or name == "vectors"}
    for name in table["vectors"]:
        head = [
            of_poses("entry of the null space", poses, vector=name, entry=i, **values)
            for i in range(1, 6)
        ]
        p = np.array([*head, *table[name]])
        assert np.abs(rows @ p).max() < 1e-9 * np.abs(size * p).max()
        p[0] *= 1.0001
        assert np.abs(rows @ p).max() > 1e-9 * np.abs(size * p).max()
    basis = np.array(
        [
            [
                of_poses("entry of the nearest basis", poses, vector=name, entry=i, **values)
                for i in range(1, 9)
            ]
            for name in table["vectors"]
        ]
    )
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-12)
    assert np.abs(rows @ basis.T).max() < 1e-9 * size.max()
    assert of_poses("eigenvalues that vanish", poses) == 8 - np.linalg.matrix_rank(rows / size)


def test_distance_from_the_polygon_of_the_poses() -> None:
    """Poses on a circle about the fixed hinge: it lies inside, by the distance of the polygon's
    nearest side.
    """
    turn = np.radians([0, 50, 130, 210, 300])
    point, spin = 7 - 4j, np.radians([5, 40, -20, 70, -60])
    place = 30 - 20j + 40 * np.exp(1j * turn) - point * np.exp(1j * spin)
    poses = np.column_stack([place.real, place.imag, np.degrees(spin)])
    radii = [of_poses("dyad", poses, dyad=k, part="r") for k in (1, 2, 3, 4)]
    dyad_number = 1 + int(np.argmin([np.inf if r is None else abs(r - 40) for r in radii]))
    result = of_poses("distance of a hinge outside the poses", poses, dyad=dyad_number)
    ends = np.roll(place, -1)
    share = np.linspace(0, 1, 20001)[:, None]
    nearest = abs(place + share * (ends - place) - (30 - 20j)).min()
    assert result == pytest.approx(-nearest, rel=1e-6)


@pytest.mark.parametrize(
    ("p", "dwell"), [(0.35, [210, 270]), (0.0, [200, 260]), (-0.2, [230, 231])]
)
def test_the_inverse_chain_finds_bars_law_and_path(p: float, dwell: list[float]) -> None:
    values = {**LAW, "law_p": p, "dwell_deg": dwell}
    assert pickup.bar(inputs(**values, bar=1)) == pytest.approx(93.3377, rel=1e-12)
    assert pickup.bar(inputs(**values, bar=2)) == pytest.approx(163, rel=1e-12)
    assert pickup.law_error(inputs(**values)) < 1e-7
    assert pickup.path_error(inputs(**values)) < 1e-9


def test_law_path_equals_complex_arithmetic() -> None:
    t = np.linspace(0, 2 * np.pi, 721)
    path = pickup.of_law(inputs(**LAW), t)
    by_hand = pickups.arm(t, p=0.35)
    assert path.phi1 == pytest.approx(by_hand, abs=1e-13)
    assert path.tip == pytest.approx(pickups.tips(t, by_hand), abs=1e-14)
    assert path.tip != pytest.approx(pickups.tips(t, by_hand + 1e-9), abs=1e-14)


def test_unreachable_path_is_not_inverted() -> None:
    small = inputs(**{**LAW, "centre_distance_mm": 10})
    t = np.linspace(0, 2 * np.pi, 720, endpoint=False)

    def back(path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        entry = pickup.invert_tip_path(small, np.column_stack([path.real, path.imag]))
        return entry.bars, abs(entry.tip @ [1, 1j] - path)

    assert (
        back(0.2 + 0.04 * np.exp(1j * t))[1].max() < 1e-12
    )  # any path that does not go round the centre
    bars, away = back(0.02 + 0.06 * np.exp(1j * t))
    assert away[-1] < 1e-12
    assert bars == pytest.approx([0.02, 0.06])


def test_the_triangle_of_the_carrier_closes() -> None:
    values = {"L1_mm": 93.3377, "gamma_deg": 150, "centre_distance_mm": 44.6}
    a1 = pickup.centre_distance_margin(inputs(**values)) + 44.6
    cosine = a1**2 + 44.6**2 - 2 * a1 * 44.6 * np.cos(np.radians(150))
    assert cosine == pytest.approx(93.3377**2, rel=1e-12)
    assert pickup.axis_direction(inputs(**values)) == pytest.approx(0, abs=1e-10)
    beta1 = math.degrees(math.asin(44.6 * 0.5 / 93.3377))
    assert pickup.axis_direction_printed(inputs(**values)) == pytest.approx(2 * beta1, rel=1e-12)


def test_printed_centre_and_foci_are_compared_with_the_path() -> None:
    """The ellipse of the corner is centred in (-1, sqrt 3)/(2 sqrt 3), its major axis falls by 60 deg."""
    centre = np.array([-1, math.sqrt(3)]) / (2 * math.sqrt(3))
    printed = inputs(centre_over_width=centre, foci_slope=-math.sqrt(3))
    assert clutch.centre_offset(printed) == pytest.approx(0, abs=1e-15)
    assert clutch.axis_offset(printed) == pytest.approx(0, abs=1e-12)
    other = inputs(centre_over_width=centre + 0.01, foci_slope=-1.7)
    assert clutch.centre_offset(other) == pytest.approx(0.01 * math.sqrt(2))
    assert clutch.axis_offset(other) > 0.1
