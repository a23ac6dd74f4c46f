"""Lengths of pitch curves: closed forms, an independent quadrature, scaling, derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipe

from planter.errors import GeometryError
from planter.gears.geometry import families
from planter.gears.geometry import stage as stage_functions
from planter.gears.geometry.pitch_curves import build_stage_pair
from planter.gears.geometry.stage import PitchLength, Stage, StageCandidate
from tests.support import pairs


def measure(stage: Stage, parameters: np.ndarray) -> PitchLength:
    return PitchLength(stage, [StageCandidate(parameters, lambda name: name)])


def draw_curve(family: str, seed: int) -> tuple[Stage, np.ndarray, PitchLength]:
    parameters = pairs.parameters(family, seed)
    stage = pairs.stage(family, seed)
    return stage, parameters, measure(stage, parameters)


@pytest.mark.parametrize("k", [0.0001, 0.031, 0.4, 0.8])
def test_ellipse_length_agrees_with_elliptic_integral(k: float) -> None:
    """Undeformed: 4 A E(k) (Abramowitz and Stegun, 17.3.3)."""
    parameters = np.array([0.031, k, 1.0])
    length = measure(Stage("ellipse", ("A", "k", "m")), parameters).at(parameters)
    assert length.value == pytest.approx(4 * 0.031 * ellipe(k**2), rel=1e-14)


def test_circle_length_is_independent_of_axis() -> None:
    parameters = np.array([0.03, 0.012, 1.0])
    length = measure(Stage("eccentric_circle", ("R", "e", "m")), parameters).at(parameters)
    assert length.value == pytest.approx(2 * np.pi * 0.03, rel=1e-14)
    assert length.gradient[:2] == pytest.approx([2 * np.pi, 0.0], abs=1e-12)


@pytest.mark.parametrize("case", pairs.EVERY_CURVE, ids=str)
def test_length_agrees_with_toothed_curve(case: pairs.Drawn) -> None:
    """Which is found along the polar angle, by Chebyshev series."""
    stage, parameters, length = draw_curve(*case)
    assert build_stage_pair(stage, parameters).gear.length == pytest.approx(
        length.at(parameters).value, rel=1e-13
    )


@pytest.mark.parametrize("case", pairs.EVERY_CURVE, ids=str)
def test_stage_length_derivatives_agree_with_differences(case: pairs.Drawn) -> None:
    _, parameters, length = draw_curve(*case)
    at = length.at(parameters)
    for j, h in enumerate(1e-6 * np.abs(parameters)):
        after, before = (
            length.at(parameters + sign * h * np.eye(len(parameters))[j]) for sign in (1, -1)
        )
        slope, bent = (
            (after.value - before.value) / 2 / h,
            (after.gradient - before.gradient) / 2 / h,
        )
        assert at.gradient[j] == pytest.approx(slope, rel=1e-6, abs=1e-9 * at.value / h)
        assert at.hessian[j] == pytest.approx(bent, rel=1e-5, abs=1e-5 * np.abs(at.hessian).max())


@pytest.mark.parametrize("case", pairs.EVERY_CURVE[::3], ids=str)
def test_it_grows_with_the_curve(case: pairs.Drawn) -> None:
    """All lengths times s: the length too; so it is what its slopes along the lengths make
    (Euler).
    """
    _, parameters, length = draw_curve(*case)
    lengths = np.array(
        [entry["unit"] == "m" for entry in families.load_sidecar(case[0])["parameters"]]
    )
    at = length.at(parameters)
    assert length.at(np.where(lengths, 1.7 * parameters, parameters)).value == pytest.approx(
        1.7 * at.value, rel=1e-14
    )
    assert (at.gradient * parameters)[lengths].sum() == pytest.approx(at.value, rel=1e-13)


def test_curve_needing_too_many_nodes_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    parameters = np.array([0.031, 0.8, 1.0])
    stage = Stage("ellipse", ("A_mm", "k", "m"))
    length = measure(stage, parameters)
    length.nodes = 8
    assert abs(length.at(parameters).value / (4 * 0.031 * ellipe(0.64)) - 1) > 1e-9
    monkeypatch.setattr(stage_functions, "MAX_NODES", 16)
    with pytest.raises(
        GeometryError, match=r"A_mm: the length of the .* has not converged .* must be rounder"
    ):
        measure(stage, parameters)
