"""Functions over a turn with a kink and a jump: extremes, integrals and jumps beside closed forms."""

import numpy as np
import pytest

from planter.kernels import Array
from planter.numerics.pieces import Pieces

BREAKS = np.array([1.0, 4.0])
TURN = 2 * np.pi


def functions(phi: Array) -> tuple[Array, Array]:
    """A sine; a ramp of slope 2 that falls back by 6 at 4; a constant."""
    at = np.mod(phi, TURN)
    inside = (at >= 1) & (at < 4)
    ramp, zero = np.where(inside, 2 * (at - 1), 0.0), np.zeros_like(at)
    return (
        np.array([np.sin(at + 0.3), ramp, zero + 7]),
        np.array([np.cos(at + 0.3), np.where(inside, 2.0, 0.0), zero]),
    )


def rates(phi: Array) -> tuple[Array, Array]:
    zero = np.zeros_like(phi)
    return functions(phi)[1], np.array([-np.sin(phi + 0.3), zero, zero])


def test_extremes_are_those_inside_and_the_one_sided_ones() -> None:
    sine, ramp, level = Pieces(functions, BREAKS).extremes(np.array([0, 1, 2]), rates)
    assert sine[1].place == pytest.approx(np.pi / 2 - 0.3, abs=1e-12)
    assert [one.value for one in sine] == pytest.approx([-1, 1], abs=1e-15)
    assert (ramp[1].place, ramp[1].value) == pytest.approx((4.0, 6.0), abs=1e-14)
    assert ramp[0].value == 0
    assert level[0].value == level[1].value == 7


def test_integrals_and_jumps() -> None:
    pieces = Pieces(functions, BREAKS)
    assert pieces.mean == pytest.approx([0, 9 / TURN, 7], abs=1e-14)
    assert pieces.rms == pytest.approx([np.sqrt(0.5), np.sqrt(36 / TURN), 7], abs=1e-13)
    before, after = pieces.sides
    assert after - before == pytest.approx(np.array([[0, 0], [0, -6], [0, 0]]), abs=1e-14)


def test_a_break_that_is_not_told_is_missed() -> None:
    """So that the test above can fail."""
    assert abs(Pieces(functions, BREAKS[:1]).mean[1] - 9 / TURN) > 1e-4


def test_without_breaks_the_turn_is_one_piece() -> None:
    pieces = Pieces(functions, np.empty(0))
    assert pieces.sides[0].shape == (3, 0)
    assert pieces.extremes(np.array([0]), rates)[0][1].value == pytest.approx(1)


def test_breaks_on_top_of_each_other_are_one() -> None:
    assert len(Pieces(functions, np.array([1.0, 1.0 + 1e-12, 4.0])).breaks) == 2


@pytest.mark.parametrize("noise", [1e-14, -1e-14])
def test_of_peaks_that_tie_the_first_is_named(noise: float) -> None:
    """A device whose second side repeats the first half a cycle later, each evaluated with its own rounding."""

    def repeated(phi: Array) -> tuple[Array, Array]:
        later = np.where(np.mod(phi, TURN) > np.pi, noise, 0.0)
        return (np.sin(2 * phi + 0.4) + later)[None], 2 * np.cos(2 * phi + 0.4)[None]

    def bends(phi: Array) -> tuple[Array, Array]:
        return repeated(phi)[1], -4 * np.sin(2 * phi + 0.4)[None]

    low, high = Pieces(repeated, np.empty(0)).extremes(np.array([0]), bends)[0]
    assert high.place == pytest.approx(np.pi / 4 - 0.2, abs=1e-7)
    assert low.place == pytest.approx(3 * np.pi / 4 - 0.2, abs=1e-7)
    assert high.value == pytest.approx(1 + max(noise, 0), abs=1e-15)
