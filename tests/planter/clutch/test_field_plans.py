"""Orthogonal arrays and the plans on them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from planter.clutch.field import evaluation, plans, trial
from planter.clutch.field.plans import FactorSpec
from planter.errors import InputError

SIZES = {
    "L4": (4, [2] * 3),
    "L8": (8, [2] * 7),
    "L9": (9, [3] * 4),
    "L18": (18, [2] + [3] * 7),
    "L25": (25, [5] * 6),
    "L27": (27, [3] * 13),
}
PRINTED_L9 = "1111 1222 1333 2123 2231 2312 3132 3213 3321"  # shi2021, table 2


def strength_two(codes: np.ndarray) -> bool:
    """Whether every pair of columns holds every pair of its levels equally often, counted one by
    one.
    """
    for a, b in itertools.combinations(codes.T.tolist(), 2):
        counts = [
            list(zip(a, b, strict=True)).count(pair) for pair in itertools.product(set(a), set(b))
        ]
        if len(set(counts)) != 1:
            return False
    return True


@pytest.mark.parametrize("name", plans.NAMES)
def test_arrays_have_their_size_and_strength(name: str) -> None:
    array = plans.build_array(name.lower())
    assert (len(array.codes), list(array.levels)) == SIZES[name]
    assert strength_two(array.codes)
    assert sorted(array.order) == list(range(len(array.levels)))
    tampered = array.codes.copy()
    tampered[0, 0] = 1 - tampered[0, 0]
    assert not strength_two(tampered)


def test_the_paper_took_the_l9_as_it_stands() -> None:
    rows = ["".join(str(code + 1) for code in row) for row in plans.build_array("L9").codes]
    assert " ".join(rows) == PRINTED_L9


@pytest.mark.parametrize(("name", "factors"), [("L8", 4), ("L27", 4)])
def test_first_factors_are_free_of_two_factor_interactions(name: str, factors: int) -> None:
    """Any three of the columns that factors take first hold all triples equally often (strength
    three).
    """
    array = plans.build_array(name)
    for three in itertools.combinations(array.order[:factors], 3):
        _, counts = np.unique(array.codes[:, three], axis=0, return_counts=True)
        assert len(counts) == array.levels[0] ** 3
        assert np.ptp(counts) == 0


def filled(plan: plans.FieldPlan, random: np.random.Generator) -> str:
    """A plan with numbers in its empty response."""
    lines = plan.text.splitlines()
    start = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    return "\n".join(
        [*lines[: start + 1], *(f"{line}{random.normal():.6f}" for line in lines[start + 1 :])]
    )


@pytest.mark.parametrize("name", plans.NAMES)
@pytest.mark.parametrize("seed", [None, 5])
def test_completed_plan_is_evaluated(name: str, seed: int | None) -> None:
    levels = {2: ("no", "yes"), 3: ("10", "15", "20"), 5: ("1", "2", "4", "8", "16")}
    first, second = plans.build_array(name).levels[:2]
    factors = [FactorSpec("gear", levels[first]), FactorSpec("angle_deg", levels[second])]
    planned = plans.plan_field(name, factors, ["Y"], seed)
    read = trial.read_trial(filled(planned, np.random.default_rng(0)), "plan.csv")
    result = evaluation.evaluate_trial(read).result
    assert result.orthogonal
    assert len(result.blank) == len(SIZES[name][1]) - 2
    assert [str(level) for level in result.factors["gear"].levels] == list(levels[first])
    assert not any("blank" in warning for warning in result.warnings)


def test_words_keep_their_order_when_runs_are_shuffled() -> None:
    soil = ("soft", "firm", "hard")
    for seed in range(6):
        planned = plans.plan_field("L9", [FactorSpec("soil", soil)], ["Y"], seed)
        read = trial.read_trial(filled(planned, np.random.default_rng(seed)), "plan.csv")
        assert read.factors[0].levels == soil


def test_seeds_shuffle_whole_runs() -> None:
    base, first, same, other = (plans.plan_field("L18", seed=seed) for seed in (None, 1, 1, 2))
    assert first == same
    assert first.columns != other.columns
    assert first.columns["run"] == base.columns["run"]
    rows = [sorted(zip(*list(p.columns.values())[1:], strict=True)) for p in (base, first, other)]
    assert rows[0] == rows[1] == rows[2]


def test_without_factors_letters_fill_the_array() -> None:
    planned = plans.plan_field("L9")
    assert list(planned.columns) == ["run", "A", "B", "C", "D", "Y1"]
    assert planned.blank == []
    assert plans.plan_field("L9", [FactorSpec("A")]).blank == ["blank1", "blank2", "blank3"]
    assert len(set(plans.plan_field("L27").columns)) == 15


def test_factors_find_columns_of_their_number_of_levels() -> None:
    planned = plans.plan_field(
        "L18", [FactorSpec("speed", ("1", "2", "3")), FactorSpec("gear", ("a", "b"))]
    )
    assert planned.columns["gear"] == ["a"] * 9 + ["b"] * 9
    assert planned.columns["speed"] == ["1", "1", "1", "2", "2", "2", "3", "3", "3"] * 2


BAD = {
    "name": (
        lambda: plans.plan_field("L10"),
        "L10: there is no plan of that name, it must be one of L4, L8, L9",
    ),
    "levels": (
        lambda: plans.plan_field("L9", [FactorSpec.parse("A=1,2")]),
        "--factor A finds no column in L9, .* 4 columns of 3",
    ),
    "too many": (
        lambda: plans.plan_field("L4", [FactorSpec(n) for n in "ABCD"]),
        "--factor D finds no column in L4",
    ),
    "second of two": (
        lambda: plans.plan_field("L18", [FactorSpec.parse("A=1,2"), FactorSpec.parse("B=1,2")]),
        "--factor B finds no column in L18, which has 1 column of 2 levels and 7 columns of 3",
    ),
    "same level": (lambda: FactorSpec.parse("A=1,1.0,2"), "levels must be two or more that differ"),
    "one level": (lambda: FactorSpec.parse("A=1"), "two or more"),
    "empty level": (lambda: FactorSpec.parse("A=1,,2"), "two or more"),
    "mixed levels": (lambda: FactorSpec.parse("A=1,two,3"), "all finite numbers or all words"),
    "not finite": (lambda: FactorSpec.parse("A=1,inf,3"), "all finite numbers or all words"),
    "no name": (lambda: FactorSpec.parse("=1,2,3"), "must be NAME or NAME=LEVEL"),
    "a comma": (lambda: FactorSpec.parse("A,B"), "must be NAME or NAME=LEVEL"),
    "twice": (
        lambda: plans.plan_field("L9", [FactorSpec("A"), FactorSpec("A")]),
        "A is given twice",
    ),
    "a response": (
        lambda: plans.plan_field("L9", [FactorSpec("Y2")]),
        "--factor Y2: .* read back as a response",
    ),
    "a run": (lambda: plans.plan_field("L9", [FactorSpec("Run")]), "read back as a run"),
    "a result": (lambda: plans.plan_field("L9", [FactorSpec("total")]), "needed for results"),
    "no response": (
        lambda: plans.plan_field("L9", [], ["lag"]),
        "--response lag: .* read back as a factor",
    ),
}


@pytest.mark.parametrize(("call", "message"), BAD.values(), ids=BAD)
def test_impossible_plans_are_refused(call, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=message):
        call()
