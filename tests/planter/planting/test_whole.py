"""Whole teeth: lengths as equations of a device's optimisation, their price, the way into `planter gears`."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from planter.cli.app import application
from planter.gear_geometry.pitch_curves import build_stage_pair
from planter.optimise.certificate import kkt_residual
from planter.optimise.descent import STATIONARY
from planter.optimise.hybrid import METHODS
from planter.planting import optimisation
from planter.planting.file import load
from planter.planting.model import Device
from planter.planting.optimisation import Optimisation, OptimisationInterrupted
from planter.planting.report import results as report
from planter.planting.requirements.verdict import Infeasible
from planter.planting.whole import made, run
from planter.planting.whole.choice import Choice, neighbours
from planter.planting.whole.extent import extents
from planter.planting.whole.lengths import Lengths
from planter.planting.whole.wanted import Wanted
from tests.support import pairs

SAMPLES = "60"
SHORT = {"genetic_algorithm.generations": 6, "genetic_algorithm.individuals": 10}
OPTIONS = ("--method", "ipopt", "--starts", "1", "--samples", SAMPLES)
WANTED = Wanted((2e-3, 1.97e-3), (31, 31))


@cache
def device(name: str = "wang2017") -> Device:
    return Device(load(name, SHORT))


@cache
def found() -> Optimisation:
    """With its price and its teeth."""
    return run.optimise(device(), WANTED, "ipopt", SAMPLES, starts=2)


def best(module_mm: float = 2.0, method: str = "ipopt", starts: int = 2) -> optimisation.DeviceOptimum:
    """The optimum alone."""
    wanted = Wanted((module_mm * 1e-3, 1.97e-3), (31, 31))
    return optimisation.search_optimum(device(), method, int(SAMPLES), starts=starts, lengths=Lengths(device(), wanted))


def kept(own: Device, wanted: Wanted, optimum: optimisation.DeviceOptimum) -> bool:
    """Whether the lengths are those that were wanted, to rounding."""
    lengths = Lengths(own, wanted)
    return bool(np.abs(lengths.values(optimum.design) / lengths.upper - 1).max() < 1e-14)


def task(wanted: Wanted = WANTED) -> optimisation.Problem:
    return optimisation.build_constrained_problem(device(), int(SAMPLES), None, Lengths(device(), wanted))


def called(*arguments: str, code: int = 0) -> dict:
    done = CliRunner().invoke(application(), [*arguments, "--json"])
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)


@pytest.fixture(autouse=True)
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "draw_optimum", lambda *_: None)


def test_pitch_curves_have_their_lengths_by_a_quadrature_of_its_own() -> None:
    for k, module in enumerate((2e-3, 1.97e-3)):
        curve = build_stage_pair(device().stages[k], device().of_stage(k, found().found.design)).gear
        assert curve.length == pytest.approx(np.pi * module * 31, rel=1e-13)
    assert all(abs(one.length_error) < 1e-14 for one in found().result.teeth.stages)


def test_the_optimum_is_certified_with_its_equations_and_not_off_them() -> None:
    problem, design = task(), found().found.design
    assert found().result.certificate.kkt_residual < 1e-9
    assert kkt_residual(problem, (design - optimisation.box.origin) / optimisation.box.unit) < 1e-9
    longer = design.copy()
    longer[list(device().names).index("R3_mm")] *= 1 + 1e-6
    assert kkt_residual(problem, (longer - optimisation.box.origin) / optimisation.box.unit) > STATIONARY


def test_the_derivatives_of_the_equations_are_those_of_differences() -> None:
    lengths, x = Lengths(device(), WANTED), device().design
    weights, h = np.array([0.7, -1.1]), 1e-6
    steps = h * np.diag(np.abs(x))
    ends = [[(lengths.values(y), lengths.slopes(y)) for y in (x + step, x - step)] for step in steps]
    slopes = np.array([(a[0] - b[0]) / 2 / h / abs(own) for (a, b), own in zip(ends, x, strict=True)]).T
    bent = np.array([weights @ (a[1] - b[1]) / 2 / h / abs(own) for (a, b), own in zip(ends, x, strict=True)])
    assert lengths.slopes(x) == pytest.approx(slopes, rel=1e-5, abs=1e-4)
    scale = np.abs(np.outer(x, x))
    assert lengths.curvature(x, weights) * scale == pytest.approx(bent * scale, rel=1e-4, abs=1e-5)


def test_whole_teeth_cost_what_their_prices_say() -> None:
    """The objective of the best designs with a little more and less module; teeth that cost nothing have no price."""
    step = 1e-3
    more, less = (best(2 + sign * step).objective for sign in (1, -1))
    first, second = found().result.teeth.stages
    assert first.price_per_module_mm == pytest.approx((more - less) / 2 / step, rel=1e-3)
    assert first.price_per_tooth == pytest.approx(first.price_per_module_mm * 2 / 31, rel=1e-12)
    assert second.price_per_module_mm == second.price_per_tooth == 0
    assert found().result.teeth.price > 0


def test_a_price_is_that_of_the_tooth_that_is_missing() -> None:
    """To first order: the free optimum has a part of a tooth more."""
    teeth = found().result.teeth
    missing = teeth.stages[0].z - teeth.stages[0].free_teeth
    assert teeth.price == pytest.approx(teeth.stages[0].price_per_tooth * missing, rel=0.1)


def test_every_way_keeps_them_and_agrees_and_again() -> None:
    """The genetic algorithm alone keeps the lengths and comes near."""
    reached = {method: best(2.0, method, starts=1) for method in METHODS}
    own = found().result.objective
    assert [reached[method].objective for method in ("ipopt", "hybrid")] == pytest.approx([own, own], rel=1e-9)
    assert own - 1e-9 <= reached["ga"].objective < reached["ga"].start_objective
    assert all(kept(device(), WANTED, one) for one in reached.values())
    assert best(starts=1).design.tolist() == reached["ipopt"].design.tolist()


@pytest.mark.parametrize(
    ("model", "sampling"), [("printed", 60), pytest.param("exact", "refined", marks=pytest.mark.long)]
)
def test_the_other_model_and_true_extremes_keep_them_too(model: str, sampling: int | str) -> None:
    own = Device(load("wang2017"), model)
    reached = optimisation.search_optimum(own, "ipopt", sampling, starts=1, lengths=Lengths(own, WANTED))
    assert kept(own, WANTED, reached)
    assert reached.certificate.kkt_residual < STATIONARY


def test_what_the_lengths_settle_is_not_said_to_be_without_effect() -> None:
    """The force feels neither gamma, nor A6, nor R3 and e3 together; with whole teeth gamma alone is free."""
    assert found().result.insensitive == [[{"gamma_deg": 1.0}]]
    assert found().result.effective_parameters == 7


@pytest.mark.parametrize(
    "pair", [("fourier", "sine"), pytest.param(("limacon", "ellipse"), marks=pytest.mark.long)], ids=str
)
def test_any_families_have_whole_teeth(pair: tuple[str, str]) -> None:
    own = Device(pairs.machine(*pair))
    modules = tuple(one.least / np.pi / 31 * 1.002 for one in extents(Lengths(own, Wanted((1.0, 1.0), (1, 1)))))
    wanted = Wanted(modules, (31, 31))
    reached = optimisation.search_optimum(own, "ipopt", 60, starts=1, lengths=Lengths(own, wanted))
    assert kept(own, wanted, reached)
    assert reached.certificate.kkt_residual < STATIONARY


def test_no_length_in_the_box_is_beyond_its_extent() -> None:
    lengths, rng = Lengths(device("wang2017-wide"), WANTED), np.random.default_rng(0)
    own = device("wang2017-wide")
    tried = [lengths.measured(own.lower + rng.random(10) * (own.upper - own.lower)) for _ in range(300)]
    for extent, of_stage_ in zip(extents(lengths), np.array(tried).T, strict=True):
        assert extent.least <= of_stage_.min()
        assert of_stage_.max() <= extent.most


@pytest.mark.long
def test_requirements_that_no_design_with_the_teeth_keeps_are_told_with_them() -> None:
    with pytest.raises(Infeasible, match=r"no design with 31 teeth of 2 mm on stage 1 and 31 teeth .* nozzle_distance"):
        run.optimise(device("wang2017-wide"), Wanted((2e-3, 2e-3), (31, 31)))


@pytest.mark.long
def test_requirements_are_kept_beside_the_lengths() -> None:
    own = device("wang2017-wide")
    wanted = Wanted((2e-3, 2e-3), (35, 33))
    reached = optimisation.search_optimum(own, "ipopt", 60, starts=1, lengths=Lengths(own, wanted))
    assert all(one.verdict == "pass" for one in reached.requirements)
    assert kept(own, wanted, reached)
    assert reached.certificate.kkt_residual < STATIONARY


@pytest.mark.usefixtures("blank_figures")
def test_the_optimum_goes_into_gears_without_scaling(tmp_path: Path) -> None:
    options = ("--teeth", "40,40", "--module", "1.31")
    best = called("optimise", "compact", *options, *OPTIONS, "--out", str(tmp_path))
    text = (tmp_path / "optimum.toml").read_text()
    assert "# Whole teeth: stage 1 has 40 teeth of 1.31 mm, stage 2 has 40 teeth of 1.31 mm.\n" in text
    cut = called("gears", str(tmp_path / "optimum.toml"), *options)
    assert [stage["scale"] for stage in cut["stages"]] == [1.0, 1.0]
    assert cut["scaled"] is None
    for stage, told in zip(cut["stages"], best["teeth"]["stages"], strict=True):
        assert [stage["z"][0], stage["module_mm"]] == [told["z"], told["module_mm"]]
        assert stage["perimeter_mm"] == pytest.approx([told["pitch_length_mm"]] * 2, rel=1e-12)
        assert [gear["margin"] for gear in stage["gears"]] == pytest.approx([g["margin"] for g in told["gears"]])
        assert stage["contact_ratio"]["min"] == pytest.approx(told["contact_ratio_min"])


def test_teeth_that_are_left_open_are_chosen_from_neighbours() -> None:
    wanted = Wanted((1e-3, 1.25e-3), (None, None))
    free = optimisation.search_optimum(device("compact"), "ipopt", 60, starts=1)
    choice = Choice(Lengths(device("compact"), wanted), free.design, 60)
    chosen = choice.run()
    tried, within = choice.tried, extents(choice.lengths)
    best_of_all = min(one.objective for one in tried.values())
    assert all(one.settled for one in tried.values())
    assert tried[chosen.teeth].objective == pytest.approx(best_of_all, rel=1e-5)
    assert set(neighbours(chosen.teeth, within)) <= set(tried)
    assert len(tried) > 2


@pytest.mark.parametrize("part", ["Choice.run", "optimisation.search_optimum", "made.stages"])
def test_an_interrupt_hands_over_what_there_is(monkeypatch: pytest.MonkeyPatch, part: str) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    there = found()
    monkeypatch.setattr(run.optimisation, "optimise", lambda *_, **__: there)
    monkeypatch.setattr(run.optimisation, "search_optimum", lambda *_, **__: there.found)
    monkeypatch.setattr(f"planter.planting.whole.run.{part}", interrupt)
    with pytest.raises(OptimisationInterrupted) as stopped:
        run.optimise(device(), Wanted((2e-3, 1.97e-3), (None, None)) if part == "Choice.run" else WANTED)
    assert stopped.value.best is there.found


def test_one_stage_alone_may_have_whole_teeth() -> None:
    """The second, whose length the force does not feel: it costs nothing."""
    wanted = Wanted((None, 1.97e-3), (None, 31))
    free, reached = (optimisation.search_optimum(device(), "ipopt", 60, starts=1, lengths=one)
                     for one in (None, Lengths(device(), wanted)))  # fmt: skip
    assert kept(device(), wanted, reached)
    assert reached.objective == pytest.approx(free.objective, rel=1e-9)
    (told,) = made.stages(Lengths(device(), wanted), reached.design, free.design, [])
    assert (told.stage, told.z, told.refused) == (2, 31, None)


def test_teeth_that_cannot_be_made_are_told_with_why() -> None:
    """Fifteen teeth are undercut; a few more are made after all, once that is let be."""
    own, wanted = device(), Wanted((4.1e-3, None), (15, None))
    x = optimisation.find_feasible_point(
        optimisation.build_constrained_problem(own, 60, None, Lengths(own, wanted)), None, 0
    )
    design = optimisation.build_constrained_problem(own, 60, None).design(x)
    (told,) = made.stages(Lengths(own, wanted), design, own.design, [])
    assert "are undercut" in told.refused
    assert min(gear.margin for gear in told.gears) < 0


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ("--teeth 31,31 --module 2", r"31 teeth of 2 mm .* stage 2: .*, 30.198 to 30.733 of them; 31 .* 1.98281 mm"),
        ("--module 2", r"whole teeth of 2 mm .* stage 2: .* 30 teeth take .* and 31 teeth take a module of 1.94825 to"),
        ("--teeth 31,31", "--teeth 31,31 is not allowed without a module: --module, or --module1 and --module2"),
        ("--teeth 31 --module 2", "--teeth 31 is not allowed: it must be Z1,Z2, one for each stage with a module"),
        ("--teeth 31,31 --module1 2", "it must be Z, the teeth of stage 1, which has one"),
        ("--teeth 31,x --module 2", "--teeth 31,x: give Z or Z1,Z2"),
        ("--teeth 31,5 --module 2", "there must be at least 6 on a gear"),
        ("--module 2 --module1 2", "leave out --module1 and --module2"),
        ("--module 2 --front", "--front is not allowed with --module"),
        ("--module1 2 --prove", "--prove is not allowed with --module"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_for_is_one_sentence(options: str, told: str) -> None:
    done = CliRunner().invoke(application(), ["optimise", "wang2017", *options.split()])
    assert (done.exit_code, done.stdout) == (2, "")
    assert len(done.stderr.strip().splitlines()) == 1
    assert re.search(told, done.stderr)
