"""Laws of a chain as a whole: the derivation keeps them, the print breaks some, and a planted error
is found.
"""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import combinations

import mpmath
import numpy as np
import pytest

from derive.audit import laws as chain_laws
from derive.audit.laws import TOLERANCE, Causes, ChainLaws, LawError, judge_laws
from derive.audit.paper import Law
from derive.audit.record import Record
from derive.evaluate import Point
from derive.model import Let
from derive.papers import wang2017
from derive.papers.planting import quantities as q
from derive.papers.planting import subject as laws
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from tests.support import machines, model

MEAN = "mean vertical support force is the weight"
WORK = "work of the motor is work of friction"
VERTICAL = "vertical support force is weight and rate of momentum"


@pytest.fixture(scope="module")
def printed() -> ChainLaws:
    return ChainLaws(wang2017.SIDE, wang2017.FRAME, laws.build_dynamics())


@pytest.fixture(scope="module")
def repaired(printed: ChainLaws) -> ChainLaws:
    """The chain with every equation exchanged for its derivation where it does not hold."""
    return with_repairs(printed, printed.suspects)


@pytest.fixture(scope="module")
def records(printed: ChainLaws) -> list[Record]:
    """What is found of the print."""
    return judge_laws("print", printed)


def with_repairs(chains: ChainLaws, numbers: list[str]) -> ChainLaws:
    side, frame = chains.side, chains.frame
    for number in numbers:
        derived = replace(chains.dynamics.claims[side.equations[number].claims], number=number)
        side, frame = side.replace(number, derived), frame.replace(number, derived)
    return ChainLaws(side, frame, chains.dynamics)


def law(chains: ChainLaws, name: str) -> Law:
    return next(candidate for candidate in chains.dynamics.laws if candidate.name == name)


def test_the_derivation_keeps_every_law_to_rounding(printed: ChainLaws) -> None:
    for law_ in printed.dynamics.laws:
        limit = 1e-10 if law_.over == "largest" else TOLERANCE
        assert printed.violations(law_, [printed.numbers])[0] < limit, law_.name


def test_repairing_wrong_equations_restores_every_law(repaired: ChainLaws) -> None:
    assert repaired.suspects == []
    assert {record["violation"] for record in judge_laws("repaired", repaired)} == {0.0}


def test_broken_laws_need_exactly_their_causes_repaired(
    printed: ChainLaws, records: list[Record]
) -> None:
    broken = [r for r in records if r["violation"]]
    assert broken
    for record in broken:
        broken_law, causes = law(printed, record["law"]), record["caused_by"]
        assert not printed.broken(broken_law, causes)
        for spared in causes:
            fewer = [n for n in causes if n != spared]
            assert any(
                printed.broken(law_, fewer) for law_ in (broken_law, *printed.satisfied_laws)
            ), (
                record["law"],
                spared,
            )
    assert all(r["caused_by"] == [] for r in records if not r["violation"])


def test_no_smaller_set_restores_a_law(printed: ChainLaws) -> None:
    """Counted again with sets of repairs run one by one, over all suspects, those too that a law
    does not ask for.
    """
    mean_law = law(printed, MEAN)
    (causes,) = printed.causes(mean_law).sets
    for size in (1, 2):
        assert all(
            printed.broken(mean_law, chosen) for chosen in combinations(printed.suspects, size)
        )
    rng = random.Random(0)
    for chosen in rng.sample(list(combinations(printed.suspects, len(causes))), 60):
        assert printed.broken(mean_law, chosen) is (chosen != causes), chosen


def test_batched_repairs_equal_single_repairs(printed: ChainLaws) -> None:
    rng = random.Random(1)
    chosen = [
        rng.sample(printed.suspects, rng.randint(0, len(printed.suspects))) for _ in range(12)
    ]
    for law_ in printed.dynamics.laws:
        together = printed.violations(law_, chosen)
        alone = [printed.violations(law_, [number])[0] for number in chosen]
        assert together == pytest.approx(alone, rel=1e-9, abs=1e-10), law_.name


def test_unrelated_repairs_do_not_change_a_law(printed: ChainLaws) -> None:
    for law_ in printed.dynamics.laws:
        concerned = printed.concerned(law_)
        unconcerned = [n for n in printed.suspects if n not in concerned]
        before, after = printed.violations(law_, [concerned, [*concerned, *unconcerned]])
        assert before == pytest.approx(after, rel=1e-12, abs=1e-12), law_.name
    assert any(
        len(printed.concerned(law_)) < len(printed.suspects) for law_ in printed.dynamics.laws
    )


@pytest.mark.long
def test_elimination_may_find_larger_restoring_sets(
    printed: ChainLaws, monkeypatch: pytest.MonkeyPatch
) -> None:
    work_law = law(printed, WORK)
    smallest = printed.causes(work_law)
    monkeypatch.setattr(chain_laws, "MOST_SETS", 10)
    quick = printed.causes(work_law)
    assert (smallest.exhaustive, quick.exhaustive) == (True, False)
    assert all(not printed.broken(work_law, chosen) for chosen in (*smallest.sets, *quick.sets))
    assert len(smallest.sets[0]) < len(quick.sets[0])
    assert chain_laws._finding("print", printed, work_law)["search"] == "elimination"


def printed_cycle() -> tuple[float, float, float]:
    """Mean vertical support force, motor work and friction work of a turn, from the printed model's
    kernels.
    """
    machine: PlantingMachine = machines.machine("wang2017")
    phi = 2 * np.pi * (np.arange(20000) + 0.5) / 20000
    cycle = model.cycle(Device(machine, "printed"), phi)
    loss = cycle.side1["F_E_loss"] + cycle.side2["F_E_loss"]
    turn = 2 * np.pi
    return (
        float(cycle.totals["F_support"].mean()),
        float(turn * cycle.totals["M_L"].mean()),
        float(turn * loss.mean() / machine.si("speed_rpm")),
    )


def test_sizes_are_those_of_the_printed_model(printed: ChainLaws) -> None:
    mean, work, loss = printed_cycle()
    weight = 97.8548
    assert mean == pytest.approx(77.2209, abs=1e-4)
    assert (work, loss) == pytest.approx((1.47105, 1.81609), abs=1e-5)
    assert printed.size(law(printed, MEAN)) == pytest.approx(weight - mean, abs=1e-4)
    assert printed.size(law(printed, WORK)) == pytest.approx(loss - work, abs=1e-6)


def test_extreme_between_sampled_angles_is_computed(printed: ChainLaws) -> None:
    totals = model.cycle(
        Device(machines.machine("wang2017"), "printed"), np.linspace(0, np.pi, 20001)
    ).totals
    exact = model.cycle(Device(machines.machine("wang2017")), np.linspace(0, np.pi, 20001)).totals
    largest = np.abs(totals["F_support"] - exact["F_support"]).max()
    assert printed.size(law(printed, VERTICAL)) == pytest.approx(largest, abs=1e-4)


@pytest.mark.parametrize(
    ("number", "name"),
    [
        ("13", VERTICAL),
        pytest.param("10", VERTICAL, marks=pytest.mark.long),
        ("14", WORK),
        pytest.param("12", "horizontal support force is rate of momentum", marks=pytest.mark.long),
    ],
)
def test_planted_error_is_attributed_to_the_equation(
    repaired: ChainLaws, number: str, name: str
) -> None:
    equation = repaired.side.equations[number]
    error = q.m2 * q.g * q.r3 / (1 if number == "14" else q.a1)
    wrong = replace(equation, residual=equation.residual + error)
    tampered = ChainLaws(
        repaired.side.replace(number, wrong),
        repaired.frame.replace(number, wrong),
        repaired.dynamics,
    )
    assert tampered.suspects == [number]
    assert tampered.causes(law(tampered, name)) == Causes([(number,)])


def test_pulling_tooth_is_attributed_to_the_normal_force(repaired: ChainLaws) -> None:
    equation = repaired.side.equations["NP"]
    wrong = replace(equation, residual=equation.residual + 2 * (q.F_NP - equation.residual))
    tampered = ChainLaws(repaired.side.replace("NP", wrong), repaired.frame, repaired.dynamics)
    for name in ("teeth at P only push", "tooth force at P has its moment"):
        assert tampered.causes(law(tampered, name)) == Causes([("NP",)])


@pytest.mark.parametrize("tag", "PQ")
def test_repair_breaks_no_satisfied_law(printed: ChainLaws, tag: str) -> None:
    """With the normal force alone the teeth push, but with the wrong flank's moment."""
    push, moment = (
        law(printed, f"teeth at {tag} only push"),
        law(printed, f"tooth force at {tag} has its moment"),
    )
    assert moment in printed.satisfied_laws
    assert not printed.broken(push, [f"N{tag}"])
    assert printed.broken(moment, [f"N{tag}"])
    assert printed.causes(push) == Causes([(f"{tag}1", f"{tag}2", f"N{tag}")])


def test_shares_add_up_to_the_violation_and_are_sorted(records: list[Record]) -> None:
    for record in records:
        shares = record["shares"]
        assert [s["equation"] for s in shares] != [] or not record["violation"]
        assert sum(s["shapley"] for s in shares) == pytest.approx(record["violation"], rel=5e-3)
        assert [s["shapley"] for s in shares] == sorted(
            (s["shapley"] for s in shares), reverse=True
        )


def test_shares_of_two_equations_by_hand(printed: ChainLaws) -> None:
    slow_law = law(printed, "support force tends to the weight as the speed goes to zero")
    sizes = [
        printed._sizes(slow_law, [frozenset(some)])[0]
        for some in ((), ("18",), ("25",), ("18", "25"))
    ]
    first, second = printed.shares(slow_law, ["18", "25"])
    assert (first.equation, second.equation) == ("25", "18")
    assert first.alone == pytest.approx(sizes[0] - sizes[2])
    assert first.without == pytest.approx(sizes[1])
    assert first.shapley == pytest.approx(((sizes[0] - sizes[2]) + (sizes[1] - sizes[3])) / 2)


def test_derivation_violating_a_law_is_refused(printed: ChainLaws) -> None:
    claim = printed.side.equations["13"].claims
    derived = printed.dynamics.claims[claim]
    broken = replace(derived, residual=derived.residual + q.m2 * q.g)
    spoiled = replace(printed.dynamics, claims={**printed.dynamics.claims, claim: broken})
    with pytest.raises(LawError, match="with all repaired"):
        ChainLaws(printed.side, printed.frame, spoiled).causes(law(printed, VERTICAL))


def test_the_slow_motion_is_the_motion_at_low_speed(printed: ChainLaws) -> None:
    motion, slow = laws.BuiltInMotion(), printed.dynamics.cycles["slow"]
    slow_values = {s: values[0] for s, values in slow.sides[0].items()}
    point = Point({s: mpmath.mpf(float(v)) for s, v in slow_values.items()})
    for step in (step for step in motion.steps if isinstance(step, Let)):
        assert float(point(step.expr)) == pytest.approx(
            slow_values[step.symbol], rel=1e-9, abs=1e-20
        ), step.symbol


def test_the_weights_integrate_over_a_turn(printed: ChainLaws) -> None:
    assert printed.dynamics.cycles["reference"].weights.sum() == pytest.approx(2 * np.pi, abs=1e-14)
