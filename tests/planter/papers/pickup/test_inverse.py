"""The inverse chain: it sees points alone, finds the law, the bars and the dwell again, and knows
what has none.
"""

import ast
from pathlib import Path

import numpy as np
import pytest

import planter.papers.pickup.inverse
from planter.errors import InputError
from planter.numerics.arrays import TURN
from planter.papers.pickup.inverse import Inversion, invert_path
from tests.planter.papers.pickup.pickups import END, FAR, L1, L2, START, arm, steps, tips

T = np.linspace(0, TURN, 2001)
AWAY = T[
    np.min(
        [np.abs((T - e + np.pi) % TURN - np.pi) for e in (START, END, np.radians(142.78), 0)],
        axis=0,
    )
    > 0.5
]


def invert_samples(count: int, offset: float = 0.0, **law: float) -> Inversion:
    t = steps(count, offset)
    return invert_path(tips(t, arm(t, **law)))


def error(inversion: Inversion, at: np.ndarray = T, **law: float) -> float:
    shift = (inversion.phi5_far - FAR + np.pi) % TURN - np.pi
    return float(np.abs(inversion.law.arm(at - shift) - arm(at, **law)).max())


def test_the_chain_cannot_see_a_law() -> None:
    for module in (planter.papers.pickup.inverse, planter.papers.pickup.inverse):
        tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
        taken = {
            (n.module, alias.name)
            for n in ast.walk(tree)
            if isinstance(n, ast.ImportFrom)
            for alias in n.names
        }
        assert ("planter.papers.pickup.law", "CosineLaw") not in taken
        assert not {m for m, _ in taken} & {
            "planter.papers.pickup.file",
            "planter.papers.pickup.model",
            "planter.papers.pickup.analysis",
        }


@pytest.mark.parametrize("offset", [0.0, 0.37, 0.5])
def test_a_dense_path_gives_the_law_back(offset: float) -> None:
    inversion = invert_samples(3600, offset)
    assert error(inversion) < 1e-9
    assert [inversion.L1 - L1, inversion.L2 - L2, inversion.phi5_far - FAR] == pytest.approx(
        [0, 0, 0], abs=1e-12
    )
    assert [inversion.law.dwell.start - START, inversion.law.dwell.end - END] == pytest.approx(
        [0, 0], abs=1e-9
    )


def test_error_falls_at_spline_order() -> None:
    errors = [error(invert_samples(count, 0.37), AWAY) for count in (60, 120, 240)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.5).all()
    bars = [abs(invert_samples(count, 0.37).L1 - L1) for count in (60, 120, 240)]
    assert (np.log2(np.array(bars[:-1]) / bars[1:]) > 3.5).all()


@pytest.mark.parametrize(
    ("p", "start", "end"), [(0.2, 200, 290), (-0.3, 100, 140), (0.3, 20, 60), (0.0, 300, 350)]
)
def test_dwells_are_recovered_from_the_path(p: float, start: float, end: float) -> None:
    law = {"p": p, "start": np.radians(start), "end": np.radians(end)}
    inversion = invert_samples(1200, 0.2, **law)
    assert error(inversion, **law) < 1e-6
    assert np.degrees([inversion.law.dwell.start, inversion.law.dwell.end]) == pytest.approx(
        [start, end], abs=1e-4
    )


def test_a_dwell_at_the_farthest_tip() -> None:
    """The plateau is the maximum itself; t then counts from its middle."""
    width = np.radians(40)
    t = steps(1800, 0.3)

    def hold_ends(x: np.ndarray) -> np.ndarray:
        wrapped = (x + np.pi) % TURN - np.pi
        beyond = np.sign(wrapped) * np.maximum(np.abs(wrapped) - width / 2, 0)
        return np.pi + beyond * np.pi / (np.pi - width / 2) + (x - wrapped)

    inversion = invert_path(tips(t, hold_ends(t)), tolerance=1e-13)
    assert inversion.law.dwell.width == pytest.approx(width, abs=1e-4)
    inner = T[(T > 0.5) & (T < TURN - 0.5)]
    assert (
        np.abs(inversion.law.arm(inner - (inversion.phi5_far - FAR)) - hold_ends(inner)).max()
        < 1e-4
    )


def test_a_path_without_dwell() -> None:
    def smooth(t: np.ndarray) -> np.ndarray:
        return np.pi + t + 0.3 * np.sin(t) + 0.05 * np.sin(2 * t)

    t = steps(900, 0.4)
    inversion = invert_path(tips(t, smooth(t)))
    assert inversion.law.dwell is None
    assert np.abs(inversion.law.arm(T) - smooth(T)).max() < 1e-8
    slope = 1 + 0.3 * np.cos(T) + 0.1 * np.cos(2 * T)
    assert np.abs(inversion.law.slopes(T)[0] - slope).max() < 1e-5


def test_the_start_of_the_points_does_not_matter() -> None:
    points = tips(steps(400), arm(steps(400)))
    first, other = invert_path(points), invert_path(np.roll(points, 123, axis=0))
    assert np.abs(first.law.arm(T) - other.law.arm(T)).max() < 1e-9


def test_a_moved_point_is_felt() -> None:
    points = tips(steps(400), arm(steps(400)))
    points[60] *= 1.0001
    assert error(invert_path(points)) > 1e-6


def test_uneven_points() -> None:
    t = steps(2000) + 0.3 * np.sin(steps(2000))
    assert error(invert_path(tips(t, arm(t)))) < 1e-8


def test_points_against_the_carrier_are_refused() -> None:
    with pytest.raises(InputError, match=r"counter-clockwise, .* turn the lines of the file round"):
        invert_path(tips(steps(100), arm(steps(100)))[::-1])


def test_a_path_with_two_far_points_is_refused() -> None:
    t = steps(200)
    lobes = np.column_stack([0.2 + 0.02 * np.cos(t), 0.1 * np.sin(t)])
    with pytest.raises(InputError, match=r"2 maxima and 2 minima \(at .*mm\)"):
        invert_path(lobes)


def test_path_around_the_sun_is_refused() -> None:
    t = steps(200)
    for r in (0.15 + 0.03 * np.cos(2 * t), 0.15 + 0.03 * np.cos(t)):
        for sense in (1, -1):
            with pytest.raises(InputError, match="goes round the origin"):
                invert_path(np.column_stack([r * np.cos(t), sense * r * np.sin(t)]))


def test_a_circle_about_the_sun_is_refused() -> None:
    t = steps(50)
    with pytest.raises(InputError, match="goes round the origin"):
        invert_path(0.1 * np.column_stack([np.cos(t), np.sin(t)]))
