"""Integer tooth numbers: length constraints of a device's optimisation, their price, cutting by
`planter gears`.
"""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from planter.cli.app import build_application
from planter.engine.solvers.certificate import kkt_residual
from planter.engine.solvers.local_search import STATIONARITY_TOLERANCE
from planter.engine.solvers.optimiser import METHODS
from planter.gears.geometry.pitch_curves import build_stage_pair
from planter.papers.planting import optimisation as device_search
from planter.papers.planting import tooth_count_search
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.objective import build_problem
from planter.papers.planting.optimisation import Optimisation, OptimisationInterrupted
from planter.papers.planting.requirements import InfeasibleRequirementsError
from planter.papers.planting.tooth_count_search import (
    ToothCountSearch,
    evaluate_stages,
    generate_neighbours,
    optimise_with_tooth_counts,
)
from planter.papers.planting.tooth_counts import (
    PitchLengthConstraints,
    ToothCountSpec,
    compute_length_ranges,
)
from planter.report.presentation import ResultPresentation
from tests.support import pairs

SAMPLES = "60"
SHORT = {"genetic_algorithm.generations": 6, "genetic_algorithm.individuals": 10}
OPTIONS = ("--method", "ipopt", "--starts", "1", "--samples", SAMPLES)
SPEC = ToothCountSpec((2e-3, 1.97e-3), (31, 31))


@cache
def device(name: str = "wang2017") -> Device:
    return Device(load(name, SHORT))


@cache
def optimisation() -> Optimisation:
    """The optimum of `SPEC` with its price and its teeth."""
    return optimise_with_tooth_counts(device(), SPEC, "ipopt", SAMPLES, starts=2)


def find_optimum(
    module_mm: float = 2.0, method: str = "ipopt", starts: int = 2
) -> device_search.DeviceOptimum:
    """The optimum with a module of stage 1, without its price."""
    spec = ToothCountSpec((module_mm * 1e-3, 1.97e-3), (31, 31))
    return device_search.search_optimum(
        device(),
        method,
        int(SAMPLES),
        starts=starts,
        lengths=PitchLengthConstraints(device(), spec),
    )


def is_satisfied(
    machine: Device, spec: ToothCountSpec, optimum: device_search.DeviceOptimum
) -> bool:
    """Whether the lengths are those of a specification, to rounding."""
    constraints = PitchLengthConstraints(machine, spec)
    return bool(np.abs(constraints.values(optimum.design) / constraints.upper - 1).max() < 1e-14)


def run_command(*arguments: str) -> dict:
    done = CliRunner().invoke(build_application(), [*arguments, "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


@pytest.fixture(autouse=True)
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ResultPresentation, "write", lambda *_: None)


def test_pitch_curve_lengths_agree_with_quadrature() -> None:
    for k, module in enumerate((2e-3, 1.97e-3)):
        curve = build_stage_pair(
            device().stages[k], device().of_stage(k, optimisation().optimum.design)
        ).gear
        assert curve.length == pytest.approx(np.pi * module * 31, rel=1e-13)
    assert all(abs(stage.length_error) < 1e-14 for stage in optimisation().result.teeth.stages)


def test_certificate_holds_on_the_constraints_only() -> None:
    task = build_problem(device(), 60, None, PitchLengthConstraints(device(), SPEC))
    design = optimisation().optimum.design
    assert optimisation().result.certificate.kkt_residual < 1e-9
    assert kkt_residual(task, (design - task.box.origin) / task.box.unit) < 1e-9
    longer = design.copy()
    longer[list(device().names).index("R3_mm")] *= 1 + 1e-6
    assert kkt_residual(task, (longer - task.box.origin) / task.box.unit) > STATIONARITY_TOLERANCE


def test_price_is_the_derivative_of_the_optimum() -> None:
    """The objective of the best designs with a little more and less module; stage 2 does not affect
    the force.
    """
    step = 1e-3
    more, less = (find_optimum(2 + sign * step).objective for sign in (1, -1))
    first, second = optimisation().result.teeth.stages
    assert first.price_per_module_mm == pytest.approx((more - less) / 2 / step, rel=1e-3)
    assert first.price_per_tooth == pytest.approx(first.price_per_module_mm * 2 / 31, rel=1e-12)
    assert second.price_per_module_mm == second.price_per_tooth == 0


def test_total_price_equals_missing_tooth() -> None:
    """To first order: the free optimum has a part of a tooth more."""
    teeth = optimisation().result.teeth
    missing = teeth.stages[0].z - teeth.stages[0].free_teeth
    assert teeth.price == pytest.approx(teeth.stages[0].price_per_tooth * missing, rel=0.1)
    assert teeth.price > 0


def test_all_methods_satisfy_length_constraints() -> None:
    """The genetic algorithm alone satisfies the lengths and comes near."""
    optima = {method: find_optimum(2.0, method, starts=1) for method in METHODS}
    best = optimisation().result.objective
    assert [optima[method].objective for method in ("ipopt", "hybrid")] == pytest.approx(
        [best, best], rel=1e-9
    )
    assert best - 1e-9 <= optima["ga"].objective < optima["ga"].start_objective
    assert all(is_satisfied(device(), SPEC, optimum) for optimum in optima.values())
    assert find_optimum(starts=1).design.tolist() == optima["ipopt"].design.tolist()


def test_insensitive_directions_respect_the_lengths() -> None:
    """The force depends neither on gamma, nor A6, nor R3 and e3 together; with fixed lengths gamma
    alone is free.
    """
    assert optimisation().result.insensitive == [[{"gamma_deg": 1.0}]]
    assert optimisation().result.effective_parameters == 7


@pytest.mark.parametrize(
    "pair",
    [("fourier", "sine"), pytest.param(("limacon", "ellipse"), marks=pytest.mark.long)],
    ids=str,
)
def test_any_family_takes_integer_tooth_numbers(pair: tuple[str, str]) -> None:
    machine = Device(pairs.machine(*pair))
    constraints = PitchLengthConstraints(machine, ToothCountSpec((1.0, 1.0), (1, 1)))
    modules = tuple(
        bounds.shortest / np.pi / 31 * 1.002 for bounds in compute_length_ranges(constraints)
    )
    spec = ToothCountSpec(modules, (31, 31))
    optimum = device_search.search_optimum(
        machine, "ipopt", 60, starts=1, lengths=PitchLengthConstraints(machine, spec)
    )
    assert is_satisfied(machine, spec, optimum)
    assert optimum.certificate.kkt_residual < STATIONARITY_TOLERANCE


def test_length_range_encloses_random_designs() -> None:
    machine, rng = device("wang2017-wide"), np.random.default_rng(0)
    constraints = PitchLengthConstraints(machine, SPEC)
    designs = machine.lower + rng.random((300, 10)) * (machine.upper - machine.lower)
    lengths = np.array([constraints.lengths(x) for x in designs])
    for bounds, column in zip(compute_length_ranges(constraints), lengths.T, strict=True):
        assert bounds.shortest <= column.min()
        assert column.max() <= bounds.longest


@pytest.mark.long
def test_infeasibility_error_names_the_tooth_numbers() -> None:
    message = r"31 teeth of 2 mm on stage 1 and 31 teeth .* nozzle_distance"
    with pytest.raises(InfeasibleRequirementsError, match=message):
        optimise_with_tooth_counts(device("wang2017-wide"), ToothCountSpec((2e-3, 2e-3), (31, 31)))


@pytest.mark.long
def test_requirements_and_lengths_hold_together() -> None:
    machine, spec = device("wang2017-wide"), ToothCountSpec((2e-3, 2e-3), (35, 33))
    optimum = device_search.search_optimum(
        machine, "ipopt", 60, starts=1, lengths=PitchLengthConstraints(machine, spec)
    )
    assert all(requirement.verdict == "pass" for requirement in optimum.requirements)
    assert is_satisfied(machine, spec, optimum)
    assert optimum.certificate.kkt_residual < STATIONARITY_TOLERANCE


@pytest.mark.usefixtures("blank_figures")
def test_gears_cuts_the_optimum_without_scaling(tmp_path: Path) -> None:
    options = ("--teeth", "40,40", "--module", "1.31")
    best = run_command("optimise", "compact", *options, *OPTIONS, "--out", str(tmp_path))
    text = (tmp_path / "optimum.toml").read_text()
    assert (
        "# Integer tooth numbers: stage 1 has 40 teeth of 1.31 mm, stage 2 has 40 teeth of 1.31 "
        "mm.\n" in text
    )
    cut = run_command("gears", str(tmp_path / "optimum.toml"), *options)
    assert [stage["scale"] for stage in cut["stages"]] == [1.0, 1.0]
    assert cut["scaled"] is None
    for stage, expected in zip(cut["stages"], best["teeth"]["stages"], strict=True):
        assert [stage["z"][0], stage["module_mm"]] == [expected["z"], expected["module_mm"]]
        assert stage["perimeter_mm"] == pytest.approx([expected["pitch_length_mm"]] * 2, rel=1e-12)
        margins = [gear["margin"] for gear in expected["gears"]]
        assert [gear["margin"] for gear in stage["gears"]] == pytest.approx(margins)
        assert stage["contact_ratio"]["min"] == pytest.approx(expected["contact_ratio_min"])


def test_search_ends_at_numbers_without_a_better_neighbour() -> None:
    spec = ToothCountSpec((1e-3, 1.25e-3), (None, None))
    free = device_search.search_optimum(device("compact"), "ipopt", 60, starts=1)
    count_search = ToothCountSearch(
        PitchLengthConstraints(device("compact"), spec), free.design, 60
    )
    best, candidates = count_search.run().teeth, count_search.candidates
    lowest = min(candidate.objective for candidate in candidates.values())
    assert all(candidate.settled for candidate in candidates.values())
    assert candidates[best].objective == pytest.approx(lowest, rel=1e-5)
    assert set(generate_neighbours(best, compute_length_ranges(count_search.constraints))) <= set(
        candidates
    )
    assert len(candidates) > 2


@pytest.mark.parametrize(
    "part", ["ToothCountSearch.run", "optimisation.search_optimum", "evaluate_stages"]
)
def test_interrupt_returns_best_so_far(monkeypatch: pytest.MonkeyPatch, part: str) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    finished = optimisation()
    monkeypatch.setattr(tooth_count_search.optimisation, "optimise", lambda *_, **__: finished)
    monkeypatch.setattr(
        tooth_count_search.optimisation, "search_optimum", lambda *_, **__: finished.optimum
    )
    monkeypatch.setattr(f"planter.papers.planting.tooth_count_search.{part}", interrupt)
    spec = ToothCountSpec(SPEC.modules, (None, None)) if part == "ToothCountSearch.run" else SPEC
    with pytest.raises(OptimisationInterrupted) as stopped:
        optimise_with_tooth_counts(device(), spec)
    assert stopped.value.best is finished.optimum


def test_a_single_stage_takes_an_integer_number() -> None:
    """The force does not depend on the length of the second stage: its number is free of charge."""
    spec = ToothCountSpec((None, 1.97e-3), (None, 31))
    constraints = PitchLengthConstraints(device(), spec)
    free, optimum = (
        device_search.search_optimum(device(), "ipopt", 60, starts=1, lengths=part)
        for part in (None, constraints)
    )
    assert is_satisfied(device(), spec, optimum)
    assert optimum.objective == pytest.approx(free.objective, rel=1e-9)
    (stage,) = evaluate_stages(constraints, optimum.design, free.design, [])
    assert (stage.stage, stage.z, stage.refused) == (2, 31, None)


def test_uncuttable_teeth_report_reason() -> None:
    """Fifteen teeth are undercut; they are cut for the result once undercut is allowed."""
    machine = device()
    constraints = PitchLengthConstraints(machine, ToothCountSpec((4.1e-3, None), (15, None)))
    x = device_search.find_feasible_point(build_problem(machine, 60, None, constraints), None, 0)
    design = build_problem(machine, 60, None).design(x)
    (stage,) = evaluate_stages(constraints, design, machine.design, [])
    assert "are undercut" in stage.refused
    assert min(gear.margin for gear in stage.gears) < 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            "--teeth 31,31 --module 2",
            r"31 teeth of 2 mm .* stage 2: .*, 30.198 to 30.733 of them; 31 .* 1.98281 mm",
        ),
        (
            "--module 2",
            r"teeth of 2 mm .* stage 2: .* 30 teeth take .* and 31 teeth take a module of 1.94825 "
            r"to",
        ),
        ("--teeth 31,31", "--teeth 31,31 needs a module.*--module1 and --module2"),
        ("--teeth 31 --module 2", "--teeth 31: .* Z1,Z2"),
        ("--teeth 31,31 --module1 2", "Z, the teeth of stage 1"),
        ("--teeth 31,x --module 2", "--teeth 31,x: give Z or Z1,Z2"),
        ("--teeth 31,5 --module 2", "--teeth 31,5: .* at least 6"),
        ("--module 2 --module1 2", "leave out --module1 and --module2"),
        ("--module 2 --front", "--front cannot be used with --module"),
        ("--module1 2 --prove", "--prove cannot be used with --module"),
    ],
)
def test_invalid_options_exit_with_a_line(options: str, message: str) -> None:
    done = CliRunner().invoke(build_application(), ["optimise", "wang2017", *options.split()])
    assert (done.exit_code, done.stdout) == (2, "")
    assert len(done.stderr.strip().splitlines()) == 1
    assert re.search(message, done.stderr)
