"""The designer's summary of any machine: dense cycles, jumps by the law of friction, closed
forms.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planter.engine.machine import Machine, load_machine
from planter.engine.response import MachineResponse
from planter.engine.summary import CycleSummary, summarise_machine
from planter.mechanism.cycle import simulate_machine
from planter.mechanism.machines import build_machine
from tests.support import own

DENSE = np.radians(np.arange(0.005, 360, 0.01))


@pytest.fixture(scope="module")
def crank() -> Machine:
    return build_machine(own.file("slider_crank"))


@pytest.fixture(scope="module")
def summary(crank: Machine) -> CycleSummary:
    return summarise_machine(crank)


def test_no_dense_cycle_passes_the_peaks(crank: Machine, summary: CycleSummary) -> None:
    names = [quantity.name for quantity in crank.results]
    response = MachineResponse(crank, names)
    values = dict(zip(names, response.values(response.at(crank.design), DENSE), strict=True))
    values["F_O"] = np.hypot(values["F_Ox"], values["F_Oy"])
    peaks = {peak.name: peak for peak in summary.peaks}
    factors = {quantity.name: quantity.factor for quantity in crank.results}
    for name, row in values.items():
        converted, peak = row / factors.get(name, 1.0), peaks[name]
        span = float(np.ptp(converted)) or 1.0
        assert converted.max() <= peak.max + 1e-9 * span
        assert converted.max() == pytest.approx(peak.max, abs=1e-4 * span)
        assert converted.min() == pytest.approx(peak.min, abs=1e-4 * span)
        assert peak.mean == pytest.approx(converted.mean(), abs=1e-5 * span)
        assert peak.rms == pytest.approx(np.sqrt(np.mean(converted**2)), abs=1e-5 * span)
        is_near = np.abs(np.degrees(DENSE) - peak.max_phi_deg) < 0.02
        assert converted[is_near].max() == pytest.approx(peak.max, abs=1e-4 * span)


def test_force_jumps_by_friction_of_both_sides(summary: CycleSummary) -> None:
    """The rod's axial force jumps by mu (N before + N after) where the slider turns round."""
    for angle in {shock.phi_deg for shock in summary.shocks}:
        at = {shock.quantity: shock for shock in summary.shocks if shock.phi_deg == angle}
        force, normal = at["F_Bx"], at["N_guide"]
        assert abs(force.after - force.before) == pytest.approx(
            0.1 * (normal.before + normal.after), rel=1e-9
        )
    assert len({shock.phi_deg for shock in summary.shocks}) == 2
    assert {shock.event for shock in summary.shocks} == {"sliding of guide turns"}


def test_switching_points_matter_to_peaks(crank: Machine, summary: CycleSummary) -> None:
    blind = summarise_machine(replace(crank, events=None, event_kinds=()))
    largest = [
        next(peak.max for peak in cycle_summary.peaks if peak.name == "F_Bx")
        for cycle_summary in (blind, summary)
    ]
    assert blind.shocks == []
    assert largest[1] - largest[0] > 1e-6


def test_cam_peaks_are_those_of_the_lift() -> None:
    result = simulate_machine(own.machine("cam_follower"), 36).result
    assert result.designer is not None
    spring = next(peak for peak in result.designer.peaks if peak.name == "F_spring")
    assert (spring.max, spring.max_phi_deg, spring.min) == pytest.approx(
        (22 + 1800 * 0.014, 180.0, 22.0), rel=1e-12
    )
    motor = result.designer.motor
    assert motor is not None
    assert motor.mean_Nm is not None
    assert 2 * np.pi * motor.mean_Nm == pytest.approx(result.work["guide_J"], rel=1e-9)


def test_nonperiodic_quantity_has_no_mean(crank: Machine) -> None:
    changed = {peak.name: peak for peak in summarise_machine(crank, {"M_in_Nm", "F_Ox_N"}).peaks}
    assert changed["M_in"].mean is changed["F_O"].rms is None
    assert changed["F_Oy"].mean is not None


def test_growing_quantity_is_largest_at_end() -> None:
    peaks = {peak.name: peak for peak in summarise_machine(load_machine("yu2023")).peaks}
    assert (peaks["phi1"].max_phi_deg, peaks["phi1"].max - peaks["phi1"].min) == pytest.approx(
        (360.0, 360.0)
    )
    assert peaks["y_S"].max_phi_deg < 360.0
