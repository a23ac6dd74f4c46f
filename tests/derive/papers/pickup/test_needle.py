"""Needle in the frame of a cell, by shapes."""

import numpy as np
import pytest

from planter.kernels.formulas import load

NEEDLE = load("pickup_needle")
RNG = np.random.default_rng(8)


@pytest.mark.parametrize("tilt", [-0.9, 0.0, 0.4])
def test_needle_outline_is_a_rectangle(tilt: float) -> None:
    outputs = NEEDLE.at("needle", along=0.01, across=-0.002, tilt=tilt, length=0.05, width=0.004)
    names = ("tip_right", "tip_left", "root_left", "root_right")
    corners = np.array([complex(outputs[f"{n}_along"], outputs[f"{n}_across"]) for n in names])
    turned = (corners - complex(0.01, -0.002)) * np.exp(-1j * tilt)
    assert turned == pytest.approx([-0.002j, 0.002j, -0.05 + 0.002j, -0.05 - 0.002j], abs=1e-15)
    for side, (tip, root) in (("right", corners[[0, 3]]), ("left", corners[[1, 2]])):
        share = tip.real / (tip.real - root.real)
        assert outputs[f"{side}_surface"] == pytest.approx(
            (tip + share * (root - tip)).imag, abs=1e-15
        )


def test_point_transform_is_invertible() -> None:
    length, across = RNG.uniform(-1, 1, 2)
    at = NEEDLE.at("placed", along=length, across=across, axis=0.8)
    back = load("pickup_exact").at(
        "entry", x_S=at["x"], y_S=at["y"], x_bottom=0.0, y_bottom=0.0, axis=0.8
    )
    assert [back["along"], back["across"]] == pytest.approx([length, across], abs=1e-15)
