"""Proof of the planting device's optimum: enclosures against two other ways to compute, effects,
tampered cases.
"""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from flint import arb, ctx

from planter.engine.proof import check_proof
from planter.engine.proof.certificate_file import check_document
from planter.engine.proof.intervals import Ball
from planter.engine.proof.jets import ANYWHERE, CENTRE, Jet, Space
from planter.engine.proof.objective import ProvableObjective, ProvedQuantity
from planter.engine.proof.search import BranchAndBound
from planter.kernels import Array, generated
from planter.papers.planting import optimisation, proof
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import FORCE, Device
from planter.papers.planting.objective import evaluate_true_extremes
from planter.papers.planting.proof import EnclosedForce
from planter.progress import Progress
from tests.planter.engine.proof.tampering import renew
from tests.planter.engine.proof.toys import enclose_samples
from tests.support import xp_arb
from tests.support.cli import answer
from tests.support.machines import device, machine
from tests.support.sampled import sampled

COUNT = 24
BITS = 1500
"""Fifty Newton steps of the generated prologue lose some of them."""
ASKED = range(1, COUNT // 2, 3)
"""Samples that are compared: not the first, where the cam's angle is zero and a ball cannot tell
its turn.
"""
SHARE = 0.02


@cache
def box(name: str, model: Model, seed: int = 3) -> tuple[Array, Array]:
    """A small box within a machine's."""
    subject, rng = device(name, model), np.random.default_rng(seed)
    half = SHARE * (subject.upper - subject.lower) / 2
    middle = (
        subject.lower + half + rng.random(subject.size) * (subject.upper - subject.lower - 2 * half)
    )
    return middle - half, middle + half


def enclose(subject: Device, lower: Array, upper: Array) -> Jet:
    force, space = EnclosedForce(subject), Space(lower, upper)
    program = force.record([ProvedQuantity(FORCE)])
    return enclose_samples(program, space, COUNT, force.find_assembly(space.centre))[0]


@cache
def enclosed(name: str, model: Model) -> Jet:
    return enclose(device(name, model), *box(name, model))


def inside(name: str, model: Model, seed: int) -> Array:
    lower, upper = box(name, model)
    return lower + np.random.default_rng(seed).random(len(lower)) * (upper - lower)


def by_arb(subject: Device, x: Array, sample: int) -> arb:
    """The force at a sample, by the generated code of the whole model on arb balls."""
    with ctx.workprec(BITS):
        return _by_arb(subject, x, arb(sample) / COUNT)


def _by_arb(subject: Device, x: Array, turn: arb) -> arb:
    lengths = [len(stage.names) for stage in subject.stages]
    parts = np.cumsum([0, subject.size - sum(lengths), *lengths]).tolist()
    mounting, *parameters = ([arb(float(v)) for v in x[a:b]] for a, b in pairwise(parts))
    curves = [generated.module(f"array.curve_{stage.family}") for stage in subject.stages]
    hoisted = [
        curve.prologue(xp_arb, p, stage.terms)
        for curve, p, stage in zip(curves, parameters, subject.stages, strict=True)
    ]
    packed = [part for pair in zip(parameters, hoisted, strict=True) for part in pair]
    constants, contacts = (
        [arb(float(v)) for v in subject.constants],
        [curve.contact for curve in curves],
    )
    module = generated.module(f"array.planting_support_{subject.model}")
    still = module.prologue(xp_arb, mounting, *packed, constants, *contacts)
    return sum(
        (
            module.lane(
                xp_arb,
                2 * xp_arb.pi * (turn + back),
                mounting,
                *packed,
                constants,
                still,
                *contacts,
            )[0]
            for back in (arb(0), arb(-1) / 2)
        ),
        arb(0),
    )


def holds(ball: Ball, value: arb) -> bool:
    return bool(arb(float(ball.low)) <= value <= arb(float(ball.high)))


@pytest.mark.parametrize("model", MODELS)
def test_the_force_of_an_interval_library_is_enclosed(model: Model) -> None:
    enclosure = enclosed("wang2017", model).value[ANYWHERE]
    for seed in range(4):
        x = inside("wang2017", model, seed)
        assert all(holds(enclosure[i], by_arb(device("wang2017", model), x, i)) for i in ASKED)


@pytest.mark.parametrize("model", MODELS)
def test_without_rounding_the_force_is_missed(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At a single design, where only rounding has a width."""
    subject, x = device("wang2017", model), inside("wang2017", model, 1)
    exact = [by_arb(subject, x, i) for i in ASKED]

    def missed() -> int:
        values = enclose(subject, x, x).value[ANYWHERE]
        return sum(not holds(values[i], value) for i, value in zip(ASKED, exact, strict=True))

    assert missed() == 0
    for part, value in (("U", 0.0), ("SLACK", 0.0), ("GROWTH", 1.0), ("TINY", 0.0), ("LIBM", 0.0)):
        monkeypatch.setattr(f"planter.engine.proof.intervals.{part}", value)
    monkeypatch.setattr("planter.engine.proof.enclosures.U", 0.0)
    for module in ("enclosures", "programs"):
        monkeypatch.setattr(f"planter.engine.proof.{module}.PI", Ball.exact([np.pi]))
    assert missed() > 0


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", ["wang2017", "compact"])
def test_force_and_slopes_of_the_whole_model_are_enclosed(name: str, model: Model) -> None:
    """The compiled kernels of the whole model, internal forces and all: the reduced one is the
    same.
    """
    subject, enclosure = device(name, model), enclosed(name, model)
    angles = 2 * np.pi * np.arange(COUNT // 2) / COUNT
    for seed in range(30):
        force, slopes = subject.support_slopes(subject.prologue(inside(name, model, seed)), angles)
        assert_within(enclosure.value[ANYWHERE], force)
        support = list(enclosure.support)
        assert_within(enclosure.gradient[ANYWHERE], slopes[:, 1:].T[support])
        gone = [k for k in range(subject.size) if k not in support]
        assert np.abs(slopes[:, 1:].T[gone]).max(initial=0) < 1e-8


def assert_within(ball: Ball, value: Array) -> None:
    room = 1e-9 * (1 + np.abs(value))
    assert (ball.low - room <= value).all()
    assert (value <= ball.high + room).all()


def test_the_enclosure_is_narrow() -> None:
    enclosure = enclosed("wang2017", "exact")
    assert enclosure.value.rad[CENTRE].max() < 1e-4
    assert enclosure.value.rad[ANYWHERE].max() < 0.05


def test_parameters_without_effect() -> None:
    assert EnclosedForce(device("wang2017", "exact")).without == ("gamma_deg", "A6_mm")
    assert EnclosedForce(device("wang2017", "printed")).without == ()


@cache
def problem(model: Model) -> tuple[ProvableObjective, Array, Array, Array]:
    """Objective, a corner of the box that is an optimum of all that is near, and a small box
    there.
    """
    subject = device("wang2017", model)
    bounding = proof.build_objective_enclosure(subject.machine, model, COUNT)
    lower, upper = subject.lower, subject.upper
    half = 0.01 * (upper - lower)
    slopes = bounding(lower + half, upper - 97 * half).slopes.mid
    corner = np.where(slopes < 0, upper, lower)
    return (
        bounding,
        corner,
        np.where(slopes < 0, upper - half, lower),
        np.where(slopes < 0, upper, lower + half),
    )


@pytest.mark.parametrize(
    ("model", "count"), sampled([(model, 3) for model in MODELS], product(MODELS, [3, 12]))
)
def test_bounds_hold_at_designs_of_a_box(model: Model, count: int) -> None:
    bounding, corner, lower, upper = problem(model)
    bounds = bounding(lower, upper)
    for seed in range(count):
        x = lower + np.random.default_rng(seed).random(len(lower)) * (upper - lower)
        assert bounds.lower_bound <= bounding(x, x).reached
    assert bounds.lower_bound <= bounding(corner, corner).reached
    open_ = upper > lower
    assert ((bounds.slopes.low > 0) | (bounds.slopes.high < 0))[open_].sum() >= 5


def shifted(
    name: str, lower: Array, upper: Array, without: tuple[str, ...], design: Array
) -> BranchAndBound:
    """A search that takes `without` as having no effect."""
    subject = device(name, "exact")
    gone = np.isin(subject.names, without)
    bounding = proof.build_objective_enclosure(subject.machine, "exact", COUNT)
    return BranchAndBound(bounding, np.where(gone, design, lower), np.where(gone, design, upper))


def test_small_box_is_proved_and_false_claim_is_not() -> None:
    """The claim that the sun's deformation has no effect takes the optimum out of the box."""
    bounding, corner, lower, upper = problem("exact")
    best, without = (
        bounding(corner, corner).reached,
        EnclosedForce(device("wang2017", "exact")).without,
    )
    honest = shifted("wang2017", lower, upper, without, corner)
    lower_bound = honest.run(best * (1 - 1e-6), 60.0)
    assert lower_bound <= min(best, honest.met)
    assert lower_bound >= honest.met * (1 - 1e-3)
    elsewhere = np.where(
        np.isin(device("wang2017", "exact").names, ["m31"]),
        device("wang2017", "exact").upper,
        corner,
    )
    false = shifted("wang2017", lower, upper, (*without, "m31"), elsewhere).run(best, 5.0)
    assert false > best


def test_a_refined_search_has_a_proof_of_true_extremes() -> None:
    options = ("--method", "ipopt", "--starts", "1", "--prove", "--prove-seconds", "0")
    result = answer("optimise", "wang2017", *options)
    proof = result["proof"]
    assert (proof["kind"], proof["samples"]) == ("true", None)
    assert (proof["objective"], proof["design"]) == (result["objective"], result["design"])
    assert not proof["proved"]
    distance = proof["objective"] - proof["lower_bound"]
    room = 2e-6 * proof["objective"]  # of the enclosure of the incumbent
    assert 1e-6 * proof["objective"] < distance <= proof["gap"] <= distance + room
    assert proof["statement"].startswith("not proved to 1e-06 of the objective in ")


@cache
def true_problem(model: Model) -> tuple[ProvableObjective, Device, Array]:
    """Return the true objective, its device, and a design inside the bounds with kinks of the pitch
    curves.
    """
    subject = device("wang2017", model)
    return (
        proof.build_objective_enclosure(subject.machine, model, None),
        subject,
        (subject.lower + 2 * subject.upper) / 3,
    )


def evaluate(subject: Device, x: Array) -> float:
    return evaluate_true_extremes(subject, x).objective


@pytest.mark.parametrize("model", MODELS)
def test_true_objective_at_a_design_is_enclosed_narrowly(model: Model) -> None:
    """Against extremes by Newton's method and Gauss-Legendre quadrature between kinks."""
    bounding, subject, x = true_problem(model)
    bounds, value = bounding(x, x), evaluate(subject, x)
    assert bounds.lower_bound - 1e-9 * value <= value <= bounds.reached + 1e-9 * value
    assert bounds.reached - bounds.lower_bound < 2e-6 * value


@pytest.mark.parametrize("model", MODELS)
def test_true_bounds_hold_at_designs_of_a_box(model: Model) -> None:
    bounding, subject, x = true_problem(model)
    half = 0.005 * (subject.upper - subject.lower)
    bounds, rng = bounding(x - half, x + half), np.random.default_rng(2)
    values = [evaluate(subject, x + rng.uniform(-1, 1, len(x)) * half) for _ in range(5)]
    assert bounds.lower_bound <= min(values)
    assert bounds.lower_bound > 0.98 * min(values)
    assert ((bounds.slopes.low > 0) | (bounds.slopes.high < 0)).sum() >= 5


def test_true_bounds_of_a_part_of_the_cycle_are_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    bounding, subject, x = true_problem("exact")
    value = evaluate(subject, x)
    monkeypatch.setattr(bounding, "response", replace(bounding.response, period=Fraction(49, 100)))
    bounds = bounding(x, x)
    assert not bounds.lower_bound <= value <= bounds.reached


def test_programs_of_a_device_are_compared_with_its_generated_code() -> None:
    """Without planter, too; gamma and A6 are in the box, and no program takes them."""
    optimum = optimisation.optimise(device("wang2017", "exact"), "ipopt", str(COUNT), starts=1)
    document = json.loads(str(proof.add_proof(optimum, 0.0).certificate))
    assert check_proof.list_ineffective(document) == ["gamma_deg", "A6_mm"]
    pairs = zip(*document["box"], strict=True)
    assert all(float.fromhex(low) < float.fromhex(high) for low, high in pairs)
    rebuild = partial(proof.rebuild_objective, "wang2017")
    result = check_document(document, rebuild)
    assert result.valid, result.reason
    assert result.compared == ["wang2017"]
    assert "Without any effect, as no result takes them: gamma_deg, A6_mm." in str(result.statement)
    path = Path(str(generated.module("array.planting_support_exact").__file__))
    check_proof.PROOF = check_proof.ProofClaims(document)
    assert "8 random points" in check_proof.compare_module(document, path)
    other = document | {"machine": document["machine"] | {"changes": {"mass.sun_kg": 0.5}}}
    assert "stages" in str(check_document(renew(other), rebuild).reason)
    (*_, last) = document["response"]["stages"]
    last["operations"], last["outputs"] = [["constant", [], [(0.5).hex()]]], [0]
    assert "stages" in str(check_document(renew(document), rebuild).reason)
    check_proof.PROOF = check_proof.ProofClaims(document)
    with pytest.raises(check_proof.RefusedError, match="not those of"):
        check_proof.compare_module(document, path)


def test_a_narrow_box_is_proved() -> None:
    """A machine whose bounds leave one parameter some room."""
    base = machine("wang2017")
    table = base.table()
    bounds = {name: (value, value) for name, value in base.design.items()}
    bounds |= {"k6": (0.0309, 0.0311), "gamma_deg": (20.0, 40.0)}
    table["bounds"] = {name: [low - 1e-6, high + 1e-6] for name, (low, high) in bounds.items()}
    subject = Device(type(base).read(table, "narrow"))
    seen: list[Progress] = []
    optimum = optimisation.optimise(subject, "ipopt", str(COUNT), starts=1)
    proved = proof.add_proof(optimum, 60.0, seen.append).result.proof
    assert proved is not None
    assert proved.proved, proved
    assert 0 <= proved.gap <= 1e-6 * proved.objective
    assert proved.statement.startswith("proved: no design of the box is better than ")
    assert str(seen[-1]).startswith("proof: ")
