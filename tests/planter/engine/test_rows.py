"""Rows of machines in lanes: what a machine alone gives, the same digits whatever stands beside a
row.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from planter.engine.loops import TURN
from planter.engine.machine import load_machine
from planter.engine.response import MachineResponse
from planter.engine.rows import MachineRows, SampleBlock
from planter.errors import ComputationError
from planter.kernels import Array, Flags, Kernel
from planter.mechanism.machines import build_machine
from tests.planter.mechanism.test_periodicity import belt
from tests.support import own

ANGLES = 36


def measure(block: SampleBlock) -> Array:
    samples = block.samples
    return np.vstack([samples.max(axis=1), np.where(block.repeats, samples.mean(axis=1), np.nan)])


def spread(data: Array, share: float, count: int) -> Array:
    return data * (1 + share * np.random.default_rng(5).uniform(-1, 1, (count, len(data))))


def test_rows_equal_single_machine_or_dead_point() -> None:
    file = own.file("slider_crank")
    machine = build_machine(file)
    d = spread(machine.data, 0.2, 24)
    d[::3, machine.find_index("l_mm")] *= np.linspace(0.3, 1.0, 8)
    result = MachineRows(machine, ["F_Ox", "M_in"], ANGLES).evaluate(d, measure)
    refused = 0
    for row, data in zip(result, d, strict=True):
        try:
            values = own.evaluate_lane(file, TURN * np.arange(ANGLES) / ANGLES, data)
        except ComputationError:
            refused += 1
            assert np.isnan(row).all()
            continue
        expected = [
            values["F_Ox"].max(),
            values["M_in"].max(),
            values["F_Ox"].mean(),
            values["M_in"].mean(),
        ]
        np.testing.assert_allclose(row, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max())
    assert 0 < refused < len(d), "both kinds are there"


def test_digits_do_not_depend_on_threads_and_neighbours() -> None:
    machine = build_machine(own.file("slider_crank"))
    d = spread(machine.data, 0.5, 150)
    rows = MachineRows(machine, ["F_Ox"], ANGLES)
    values = rows.evaluate(d, measure)
    np.testing.assert_array_equal(rows.evaluate(d, measure, threads=3), values)
    for start, stop in ((0, 1), (7, 20), (140, 150)):
        np.testing.assert_array_equal(rows.evaluate(d[start:stop], measure), values[start:stop])


def test_open_loops_cost_at_most_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = build_machine(own.file("slider_crank"))
    loops = machine.loops
    assert loops is not None
    evaluated: list[int] = []
    steps = loops._steps

    def masked(phi: Array, d: Array, q: Array) -> tuple[dict[str, Array], Flags]:
        evaluated.append(q.shape[1])
        return Kernel.masked(steps, phi=phi, d=d, q=q)

    monkeypatch.setattr(steps, "masked", masked)
    angles = np.radians(np.arange(361.0))

    def count_lanes(data: Array) -> tuple[int, int]:
        evaluated.clear()
        walk = loops.walk(np.ascontiguousarray(data.T), angles)
        return sum(evaluated), int(np.count_nonzero(~walk.alive))

    d = spread(machine.data, 0.02, 256)
    usual, failed = count_lanes(d)
    assert failed == 0
    d[::2, machine.find_index("l_mm")] *= np.linspace(0.2, 0.28, 128)
    slow, failed = count_lanes(d)
    assert failed == 128
    assert slow < 2 * usual


def test_halved_steps_do_not_change_digits() -> None:
    """A crank that nearly stretches out needs small steps there: alone, and beside others, the same
    ones.
    """
    machine = build_machine(own.file("slider_crank"))
    loops = machine.loops
    assert loops is not None
    d = spread(machine.data, 0.0, 24)
    d[:, machine.find_index("l_mm")] = (0.05 + 0.01) * (1 + np.geomspace(1e-7, 1e-1, 24))
    angles = np.append(TURN * np.arange(ANGLES) / ANGLES, TURN)
    states = loops.walk(np.ascontiguousarray(d.T), angles)
    assert np.count_nonzero(states.alive) > 0
    for lane in (0, 8, 16):
        part = loops.walk(np.ascontiguousarray(d[lane : lane + 8].T), angles)
        np.testing.assert_array_equal(part.reached, states.reached[lane : lane + 8])
        for place in np.flatnonzero(part.alive):
            np.testing.assert_array_equal(
                part.places[:, :, place], states.places[:, :, lane + place]
            )


def test_average_requires_periodic_cycle() -> None:
    machine = build_machine(belt(Fraction(1, 2)))
    block = next(MachineRows(machine, ["F_Ox", "chi_dot"], ANGLES).blocks(machine.data[None]))
    assert not block.failed.any()
    assert block.repeats[:, 0].tolist() == [False, True]
    changed_machine = build_machine(belt(Fraction(2)))
    assert next(
        MachineRows(changed_machine, ["F_Ox", "chi_dot"], ANGLES).blocks(changed_machine.data[None])
    ).repeats.all()


@pytest.mark.parametrize("samples", [8, 9])
def test_totals_of_equal_sides_are_those_of_all_sides(samples: int) -> None:
    """One side is evaluated; what is no sum of equal shares, such as the printed torque, is taken
    whole.
    """
    machine = load_machine("wang2017", model="printed")
    names = ["F_support", "M_L", "y_tip"]
    for chosen in (names, names[:1]):
        rows = MachineRows(machine, chosen, samples)
        block = next(rows.blocks(machine.data[None]))
        response = MachineResponse(machine, chosen)
        expected = response.values(response.at_data(machine.data), rows.angles)
        count = block.samples.shape[1]
        np.testing.assert_allclose(block.samples[:, :, 0], expected[:, :count], rtol=1e-11)
        assert block.repeats.all()
    assert count == {8: 4, 9: 9}[samples], "totals alone are those of a period"
    assert len(rows.steps) == {8: 8, 9: 18}[samples]


def test_slopes_of_equal_sides_are_those_of_all_sides() -> None:
    machine = load_machine("wang2017", model="printed")
    machine = machine.with_moved({"design.theta_deg": (0, 1), "operation.speed_rpm": (0, 1)})
    names, rng = ["F_support", "M_L"], np.random.default_rng(4)
    for samples in (6, 7):
        rows, response = MachineRows(machine, names, samples), MachineResponse(machine, names)
        block = next(rows.blocks(machine.data[None]))
        weights = rng.normal(size=(2, samples))
        _, slopes = response.slopes(response.at_data(machine.data), rows.angles)
        expected = np.einsum("kn,knp->kp", weights, slopes[:, :, 1:])
        np.testing.assert_allclose(
            rows.gradients(block, (0, 1), weights[:, :, None])[:, :, 0], expected, rtol=1e-9
        )
