"""Ensembles of free motions: statistics of runs, and the rate at which runs part, against the
variational equation.
"""

from __future__ import annotations

import csv
from collections.abc import Callable

import jsonschema
import numpy as np
import pytest
import scipy.integrate

from planter.errors import InputError
from planter.kernels import Array
from planter.mechanism import ensemble
from planter.mechanism.ensemble import EnsembleSpec, MechanismEnsemble, compute_ensemble
from planter.task import AUTO, Means
from tests.support import own
from tests.support.cli import answer, run
from tests.support.schemas import load_schema

PENDULUM = """
from sympy import cos
from derive import Mechanism, quantities
q = quantities('''
    m | kg    | bob       | 1
    l | m     | rod       | 1
    g | m/s2  | free fall | 1
    c | N m s | damping   | 0.5
    M | N m   | drive     | 1.5
    w | rad/s | drive     | 0.6666666666666666
''')
m = Mechanism("own", q, gravity=q.g)
a = m.coordinate("a", "rad", "swing")
rod = m.frame("rod", a)
bob = m.body("bob", rod, q.m, m.point("C", m.O, rod, 0, -q.l))
m.pin("A", bob, m.ground, m.O)
m.torque("drive", bob, m.ground, q.M * cos(q.w * m.time) - q.c * m.rate(a))
m.begin({a: 0.2})
SYSTEM = m.system()
"""
SINCE, UNTIL = 20.0, 60.0


def compute_pendulums(
    torque: float, spec: EnsembleSpec, means: Means = AUTO, until: float = UNTIL
) -> MechanismEnsemble:
    points = int(2 * until) + 1
    return compute_ensemble(
        own.file(PENDULUM, "own", M_Nm=torque), until, points, spec, means=means
    )


def integrate_variation(start: Array, slope: Callable[[float], float], scales: Array) -> float:
    """Return the growth rate [1/s] of a variation of the driven pendulum, over scales (2,), from
    SINCE to UNTIL.
    """

    def rates(time: float, y: Array) -> list[float]:
        a, speed, b, change = y
        return [
            speed,
            1.5 * np.cos(2 / 3 * time) - 0.5 * speed - np.sin(a),
            change,
            -0.5 * change - slope(a) * b,
        ]

    solution = scipy.integrate.solve_ivp(
        rates,
        (0, UNTIL),
        [*start, 0.6, 0.8],
        t_eval=[SINCE, UNTIL],
        rtol=1e-11,
        atol=1e-13,
        method="DOP853",
    )
    sizes = np.hypot(*(solution.y[2:] / scales[:, None]))
    return float(np.log(sizes[1] / sizes[0]) / (UNTIL - SINCE))


@pytest.fixture(scope="module")
def chaotic() -> MechanismEnsemble:
    return compute_pendulums(1.5, EnsembleSpec(3, 1e-3, SINCE, 20.0, seed=4))


def test_chaotic_exponent_is_that_of_the_variational_equation(chaotic):
    exponent = chaotic.result.separation.lyapunov_per_s
    assert exponent is not None
    starts = [np.radians(chaotic.curves["a_deg"][:, 0]), chaotic.curves["a_dot_rad_s"][:, 0]]
    scales = ensemble.EnsembleRuns(
        own.file(PENDULUM, "own"), EnsembleSpec(1, since=SINCE), chaotic.times, 1e-9, False
    ).metric.scales
    expected, reversed_gravity = (
        [integrate_variation(start, slope, scales) for start in np.transpose(starts)]
        for slope in (np.cos, lambda a: -np.cos(a))
    )
    assert exponent.value == pytest.approx(np.mean(expected), abs=2e-3)
    assert exponent.error == pytest.approx(np.std(expected, ddof=1) / np.sqrt(3), rel=0.05)
    assert abs(exponent.value - np.mean(reversed_gravity)) > 0.05


def test_large_separation_of_companions_gives_no_exponent(monkeypatch):
    monkeypatch.setattr(ensemble, "COMPANION", 0.1)
    assert (
        compute_pendulums(1.5, EnsembleSpec(1), until=20).result.separation.lyapunov_per_s is None
    )


def test_periodic_runs_approach_at_half_the_damping():
    # the ellipse of the variations turns, which leaves up to 0.3 / (UNTIL - SINCE) of the exponent
    separation = compute_pendulums(0.5, EnsembleSpec(2, 0.05, SINCE)).result.separation
    assert (separation.parted_runs, separation.parted_after_s) == (0, None)
    assert separation.last_median < 1e-5
    assert separation.lyapunov_per_s is not None
    assert separation.lyapunov_per_s.value == pytest.approx(-0.25, abs=0.01)


def test_chaotic_runs_part():
    separation = compute_pendulums(1.5, EnsembleSpec(2, 0.05, SINCE)).result.separation
    assert separation.parted_runs == 2
    assert separation.parted_after_s is not None
    assert 0 < separation.parted_after_s.p5 <= separation.parted_after_s.p95 < UNTIL


def test_processes_and_number_of_runs_change_no_run(chaotic):
    parallel = compute_pendulums(1.5, EnsembleSpec(2, 1e-3, SINCE, 20.0, seed=4), Means(2))
    for key, curve in parallel.curves.items():
        assert np.array_equal(curve, chaotic.curves[key][:2])
    other = compute_pendulums(1.5, EnsembleSpec(1, 1e-3, SINCE, 20.0, seed=5))
    assert not np.array_equal(other.curves["a_deg"], chaotic.curves["a_deg"][:1])


def test_starts_stay_within_the_perturbation(chaotic):
    after = chaotic.times >= SINCE
    stated = own.dynamics(PENDULUM, "own").run(chaotic.times, 1e-9)
    scale = np.ptp(stated.states[1, after])
    shifts = np.abs(chaotic.curves["a_dot_rad_s"][:, 0] - stated.states[1, 0]) / scale
    assert np.all((shifts > 0) & (shifts < 1e-3))


def test_statistics_are_those_of_the_curves(chaotic):
    force, result = chaotic.curves["F_Ax_N"], chaotic.result
    windows = [(chaotic.times >= begin) & (chaotic.times <= begin + 20) for begin in (20, 40)]
    ranges = np.array([np.ptp(force[:, window], axis=1) for window in windows]).T
    statistic = result.quantities["F_Ax_N"].range
    assert result.periods == 2
    assert statistic.mean == pytest.approx(ranges.mean())
    assert statistic.mean_error == pytest.approx(ranges.mean(axis=1).std(ddof=1) / np.sqrt(3))
    assert statistic.p95 == pytest.approx(np.percentile(ranges, 95))


def test_variance_of_a_sine_is_half():
    times = np.linspace(0, 3, 301)
    spec = EnsembleSpec(1, period=1.0)
    pieces = ensemble._measure_pieces(
        np.sin(2 * np.pi * times)[None], ensemble._list_windows(times, spec)
    )
    assert pieces["variance"] == pytest.approx(np.full((1, 3), 0.5))
    assert pieces["range"] == pytest.approx(np.full((1, 3), 2.0))


def test_whole_turns_are_no_separation():
    metric = ensemble.StateMetric(np.array([0.5, 2.0, 0.0]), np.array([True, False, False]))
    separation = metric.measure(
        np.array([[7.0], [1.0], [9.0]]), np.array([[7.0 - 4 * np.pi], [3.0], [0.0]])
    )
    assert separation == pytest.approx([np.sqrt(0.5)])


def test_move_writes_an_ensemble(tmp_path):
    path = str(own.generated(PENDULUM) / "own.toml")
    options = (
        "--until",
        "10",
        "--points",
        "41",
        "--ensemble",
        "3",
        "--since",
        "4",
        "--period",
        "2",
        "--workers",
        "1",
    )
    result = answer("move", path, *options, "--out", str(tmp_path / "runs"))
    jsonschema.validate(result, load_schema("move"))
    assert result["runs"] == result["periods"] == 3
    with (tmp_path / "runs" / "runs.csv").open() as lines:
        rows = [line for line in csv.reader(lines) if not line[0].startswith("#")]
    assert len(rows) == 10
    assert "range_F_Ax_N" in rows[0]
    for name in ("figures/separation.svg", "values.csv"):
        assert (tmp_path / "runs" / name).is_file()


@pytest.mark.parametrize(
    "options",
    [
        ("--rest",),
        ("--least-squares",),
        ("--since", "9.9"),
        ("--period", "0.01"),
        ("--period", "11"),
    ],
)
def test_options_without_statistics_are_refused(options):
    path = str(own.generated(PENDULUM) / "own.toml")
    code, _, error = run("move", path, "--until", "10", "--ensemble", "2", *options)
    assert code == 2
    assert options[0] in error


def test_too_many_values_are_refused():
    with pytest.raises(InputError, match="10000"):
        compute_ensemble(own.file(PENDULUM, "own"), 10.0, 50_000, EnsembleSpec(10_000))
