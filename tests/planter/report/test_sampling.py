"""Lines of drawings follow their curves: pieces are as short as it takes, corners and jumps
included.
"""

from collections.abc import Callable

import numpy as np
import pytest

from planter.kernels import Array
from planter.report.scene import TOLERANCE, Scene, refine_places
from planter.report.subject import open_machine


def scenes(machine: str) -> list[Scene]:
    subject = open_machine(machine, {})
    return list(
        subject.scenes(
            {control.path: control.value for control in subject.controls}, subject.models[0]
        )
    )


def strayed(places: Array, values: Array, dense: Array, exact: Array) -> float:
    """Largest distance of straight pieces from an exact curve, in parts of its range."""
    return float(np.abs(np.interp(dense, places, values) - exact).max() / np.ptp(exact))


@pytest.mark.parametrize(
    ("curve", "tolerance"),
    [
        (np.sin, 2 * TOLERANCE),
        (lambda t: np.abs(np.sin(7 * t)), 1e-2),
        (lambda t: np.sqrt(np.abs(t - 2)), 1e-2),
    ],
)
def test_pieces_follow_a_curve(curve: Callable[[Array], Array], tolerance: float) -> None:
    """Halved at most ROUNDS times, the pieces beside a corner are short enough to follow it within
    a hundredth.
    """
    dense, even = np.linspace(0.0, 2 * np.pi, 7001), np.linspace(0.0, 2 * np.pi, 37)
    places = refine_places(lambda t: [curve(t)], even)
    assert strayed(places, curve(places), dense, curve(dense)) < tolerance
    assert strayed(even, curve(even), dense, curve(dense)) > tolerance


def test_a_jump_is_drawn_steep() -> None:
    places = refine_places(lambda t: [np.floor(t)], np.linspace(0.0, 2.5, 11))
    neighbours = places[np.argsort(np.abs(places - 1.0))[:2]]
    assert np.ptp(neighbours) < 0.25 / 64
    assert len(places) < 40


def test_a_straight_line_needs_no_more() -> None:
    places = np.linspace(0.0, 1.0, 5)
    assert refine_places(lambda t: [3 * t, 0 * t], places) == pytest.approx(places)


def test_clutch_curve_meets_zeros() -> None:
    """The body needs no more than its width wherever a vertex points at a side: every 12 deg."""
    (scene,) = scenes("shi2021")
    (curve,) = scene.curves
    at = [int(np.argmin(np.abs(scene.places - angle))) for angle in range(0, 360, 12)]
    assert scene.places[at] == pytest.approx(range(0, 360, 12))
    assert np.abs(curve.values[at]).max() < 1e-12
    middles = [int(np.argmin(np.abs(scene.places - angle))) for angle in range(6, 360, 12)]
    assert scene.places[middles] == pytest.approx(range(6, 360, 12))
    assert curve.values[middles] == pytest.approx(curve.values.max(), rel=1e-9)


def test_tip_paths_of_linkages_are_smooth() -> None:
    """Corners between neighbouring pieces are flat but where the path is short against its
    pieces.
    """
    for scene in scenes("sun2019")[:2]:
        (tip,) = (point for point in scene.points if point.traced)
        path = np.append(tip.x, np.take(tip.x, 0)) + 1j * np.append(tip.y, np.take(tip.y, 0))
        steps = np.diff(path)
        bends = np.abs(np.angle(steps[1:] / steps[:-1]))
        bulges = (
            np.minimum(np.abs(steps[1:]), np.abs(steps[:-1])) * bends / 8
        )  # of an arc from its chord
        assert bulges.max() < 2e-3 * max(np.ptp(path.real), np.ptp(path.imag))
        assert (np.diff(scene.times) > 0).all()


def test_pickup_slope_jumps_at_dwell_start() -> None:
    (scene,) = scenes("yu2023")
    slope = next(curve for curve in scene.curves if curve.name.startswith("slope"))
    jump = int(np.argmax(np.abs(np.diff(slope.values))))
    begins = next(event.place for event in scene.events if event.name == "the dwell begins")
    ends = next(event.place for event in scene.events if event.name == "the dwell ends")
    assert min(abs(scene.places[jump] - begins), abs(scene.places[jump] - ends)) < 0.02
    assert np.diff(scene.places)[jump] < 0.02
