"""The audit: its keys, its verdicts by rule (each can be flipped), its page, and the formulas
behind the numbers.
"""

from __future__ import annotations

import copy
import itertools
import json
import math
import re
from decimal import Decimal
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from planter import Device, load_machine, optimise_device
from planter.audit import numbers, verdicts
from planter.audit.registry import FORMULAS, Computation, Inputs, Rounded
from planter.audit.user_paper import MEASURE
from planter.errors import ComputationError, PlanterError
from planter.kernels import generated
from tests.support.cli import below
from tests.support.sampled import sampled
from tests.support.schemas import load_schema
from tests.support.structure import ROOT

PAPERS = ["wang2017", "shi2021", "yu2023", "sun2019"]
VERDICTS = {"reproduced", "consistent", "not reproduced", "not recomputable"}


run, answer, refusal = below("audit")


@pytest.fixture(scope="module")
def audit() -> dict[str, Any]:
    return answer()


def find_entry(entries: list[dict[str, Any]], paper: str, quantity: str) -> dict[str, Any]:
    (entry,) = [e for e in entries if (e["paper"], e["quantity"]) == (paper, quantity)]
    return entry


def tampered(paper: str, quantity: str, printed: str) -> dict[str, Any]:
    """The data file with another printed text for one number."""
    table = copy.deepcopy(numbers.load_numbers())
    for row in table["number"]:
        each = row.get("each", {})
        texts = row["printed"] if each else [row["printed"]]
        for index in range(len(texts)):
            inputs = {name: values[index] for name, values in each.items()}
            if (row["paper"], row["quantity"].format_map(inputs)) == (paper, quantity):
                texts[index] = printed
        row["printed"] = texts if each else texts[0]
    return table


# ---- contract
# ------------------------------------------------------------------------------------------------------


def test_it_has_the_keys_of_the_contract(audit: dict[str, Any]) -> None:
    assert audit.keys() == {
        "equations",
        "laws",
        "numbers",
        "causes",
        "references",
        "claims",
        "consequences",
        "summary",
    }
    jsonschema.validate(audit, load_schema("audit"))
    assert {e["verdict"] for e in audit["numbers"]} <= VERDICTS
    assert list(audit["summary"]) == PAPERS
    for part in ("equations", "numbers"):
        assert list(dict.fromkeys(e["paper"] for e in audit[part])) == PAPERS
        assert sum(sum(s[part].values()) for s in audit["summary"].values()) == len(audit[part])


def test_equations_equal_committed_ones(audit: dict[str, Any]) -> None:
    committed = generated.sidecar("audit")
    assert audit["equations"] == [
        e for p in PAPERS for e in committed["equations"] if e["paper"] == p
    ]
    for paper, summary in audit["summary"].items():
        verdicts = [e["verdict"] for e in committed["equations"] if e["paper"] == paper]
        assert summary["equations"] == {
            verdict: verdicts.count(verdict) for verdict in sorted(set(verdicts))
        }


@pytest.mark.parametrize("paper", sampled(["shi2021", "yu2023"], PAPERS))
def test_single_paper_equals_part_of_all(paper: str, audit: dict[str, Any]) -> None:
    partial = answer(paper)
    assert list(partial["summary"]) == [paper]
    for part in ("equations", "laws", "numbers", "causes", "references", "claims", "consequences"):
        assert partial[part] == [e for e in audit[part] if e["paper"] == paper]


@pytest.mark.parametrize(
    ("name", "hint"), [("wang2016", "wang2017"), ("Yu2023", "yu2023"), ("", ""), ("moby", "")]
)
def test_unknown_paper_is_refused_in_a_sentence(name: str, hint: str) -> None:
    message = refusal(name)
    assert all(paper in message for paper in PAPERS)
    assert ("did you mean " + hint in message) == bool(hint)


def test_without_committed_verdicts_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> dict[str, Any]:
        raise FileNotFoundError(name)

    monkeypatch.setattr(generated, "sidecar", missing)
    with pytest.raises(ComputationError, match="make audit"):
        verdicts.audit()
    code, out, _ = run("--json")
    assert code == 1
    assert json.loads(out)["error"]["name"] == "ComputationError"


def test_tables_show_equations_numbers_and_counts() -> None:
    code, out, _ = run("sun2019")
    assert code == 0
    for text in ("equations", "numbers", "not reproduced", "untested", "sign of 10 in pose 1"):
        assert text in out


# ---- verdicts by rule
# ----------------------------------------------------------------------------------------------


def test_no_verdict_stands_in_the_data() -> None:
    files = Path(numbers.__file__).parents[1].glob("papers/*/printed/*.toml")
    text = "".join(file.read_text(encoding="utf-8") for file in files).lower()
    for word in (
        "reproduced",
        "consistent",
        "recomputable",
        "verdict",
        "confirmed",
        "misprint",
        "contradicted",
    ):
        assert word not in text


def test_the_code_names_no_paper() -> None:
    for module in Path(verdicts.__file__).parent.glob("*.py"):
        assert not re.search("|".join(PAPERS), module.read_text(encoding="utf-8")), module.name


def test_every_verdict_follows_the_rule(audit: dict[str, Any]) -> None:
    for e in audit["numbers"]:
        place = Decimal(1).scaleb(Decimal(e["printed_text"]).as_tuple().exponent)
        reach = 0.5 * float(place) * (1 + 1e-7)
        hit = e["recomputed"] is not None and abs(e["recomputed"] - e["printed"]) <= reach
        low, high = e["interval"] or (np.nan, np.nan)
        is_within = low - reach <= e["printed"] <= high + reach
        assert e["printed"] == float(e["printed_text"])
        expected = {
            "reproduced": hit and not e["assumed_inputs"] and not e["needs"],
            "not reproduced": not hit and not e["assumed_inputs"] and not e["needs"],
            "consistent": not e["needs"]
            and (hit if e["assumed_inputs"] else is_within and not hit),
            "not recomputable": bool(e["assumed_inputs"] or e["needs"]),
        }
        assert expected[e["verdict"]], e


@pytest.mark.parametrize(
    ("paper", "quantity", "before", "printed", "after"),
    [
        (
            "wang2017",
            "range of the support force, theory, from its extremes",
            "reproduced",
            "122.19",
            "not reproduced",
        ),
        (
            "wang2017",
            "range of the support force, theory, from its extremes",
            "reproduced",
            "122.18",
            "consistent",
        ),
        ("shi2021", "Y1, F of A", "reproduced", "183.84", "consistent"),
        ("shi2021", "Y1, F of A", "reproduced", "186.50", "not reproduced"),
        ("shi2021", "Y1, sum of squares, A", "reproduced", "64.15", "not reproduced"),
        ("shi2021", "Y2, mean at level 2 of B", "consistent", "-6.0", "reproduced"),
        ("shi2021", "travel at 15 deg, printed formula", "consistent", "5.6", "not recomputable"),
        (
            "shi2021",
            "reduction of the lag, engagement, from printed means",
            "reproduced",
            "83.3",
            "not reproduced",
        ),
        (
            "yu2023",
            "difference of the errors of both measured angles",
            "reproduced",
            "0.20",
            "not reproduced",
        ),
        ("sun2019", "real solutions", "not reproduced", "4", "reproduced"),
        ("sun2019", "Z1 of pose 4", "reproduced", "72.5089", "not reproduced"),
    ],
)
def test_another_print_changes_the_verdict(
    paper: str, quantity: str, before: str, printed: str, after: str, audit: dict[str, Any]
) -> None:
    assert find_entry(audit["numbers"], paper, quantity)["verdict"] == before
    changed = numbers.judge_numbers(paper, tampered(paper, quantity, printed))
    assert find_entry(changed, paper, quantity)["verdict"] == after


def test_as_many_hits_as_assumed_inputs_are_not_enough() -> None:
    table = tampered("shi2021", "travel at 10 deg, printed formula", "8.5")
    rows = numbers.judge_numbers("shi2021", table)
    assert (
        find_entry(rows, "shi2021", "travel at 15 deg, printed formula")["verdict"] == "consistent"
    )
    table["number"] = [
        r for r in table["number"] if "travel" not in r["quantity"] or "printed" in r["quantity"]
    ]
    for row in table["number"]:
        if row["by"] == "travel as printed":
            row["printed"] = ["8.5", "5.6", "4.2"]
    rows = numbers.judge_numbers("shi2021", table)
    assert (
        find_entry(rows, "shi2021", "travel at 20 deg, printed formula")["verdict"]
        == "not recomputable"
    )


def test_assumed_input_changes_the_verdict() -> None:
    table = copy.deepcopy(numbers.load_numbers())
    table["assumed"]["shi2021"]["shaft_flats_mm"] = table["disclosed"]["shi2021"].pop(
        "shaft_flats_mm"
    )
    entry = find_entry(
        numbers.judge_numbers("shi2021", table),
        "shi2021",
        "distance of the tooth tip, (3) with equality",
    )
    assert entry["assumed_inputs"] == ["shaft_flats_mm = 20"]
    assert entry["verdict"] != "reproduced"


@pytest.mark.parametrize(
    ("printed", "value", "same"),
    [
        ("8.6", 8.65, True),
        ("8.6", 8.651, False),
        ("134.00", 133.9956, True),
        ("134.00", 133.99, False),
        ("-8.52e-5", -8.5151e-5, True),
        ("-8.52e-5", 8.52e-5, False),
        ("2", 2.0, True),
        ("2", 4.0, False),
        ("0", 0.0, True),
        ("45.5", 45.45, True),
        ("1.1", 6.3 - 5.2, True),
    ],
)
def test_equal_at_the_printed_precision(printed: str, value: float, same: bool) -> None:
    assert numbers.equals_printed(printed, value) is same


def test_formulas_and_numbers_correspond() -> None:
    table = numbers.load_numbers()
    used = {number.by for number in numbers.list_numbers(table)} | {
        row["by"] for row in table["claim"]
    }
    used |= {row[key] for row in table["headline"] for key in ("as_printed", "as_derived")}
    assert FORMULAS.keys() - {MEASURE} == used


def test_quantities_are_distinguished(audit: dict[str, Any]) -> None:
    names = [(e["paper"], e["quantity"]) for e in audit["numbers"]]
    assert len(names) == len(set(names))


def test_numbers_with_same_sign_error_share_a_cause(audit: dict[str, Any]) -> None:
    (cause,) = [c for c in audit["causes"] if c["numbers"]]
    assert (cause["paper"], cause["cause"]) == ("sun2019", "sign of 10 in pose 1")
    cured = [e for e in audit["numbers"] if e["cured_by"]]
    assert [f"{e['paper']}: {e['quantity']}" for e in cured] == cause["numbers"]
    assert all(e["verdict"] == "not reproduced" for e in cured)
    missed = [e for e in cured if not numbers.equals_printed(e["printed_text"], e["cured_to"])]
    assert [e["quantity"] for e in missed] == ["first dyad, a3 at the scale of the printed a0"]
    assert len(cured) > 40


def test_rounded_inputs_explain_a_number_only_with_all_others(audit: dict[str, Any]) -> None:
    """The interval of F alone spans 186.5; the sums of squares, which the same runs give, exclude
    it.
    """
    name = "Y1, F of A"
    changed = find_entry(
        numbers.judge_numbers("shi2021", tampered("shi2021", name, "186.50")), "shi2021", name
    )
    low, high = changed["interval"]
    assert changed["verdict"] == "not reproduced"
    assert low < 186.5 < high
    alone = tampered("shi2021", name, "186.50")
    alone["number"] = [row for row in alone["number"] if row["by"] == "variance ratio"]
    for row in alone["number"]:
        row["each"] = {key: values[:1] for key, values in row["each"].items()}
        row["printed"] = row["printed"][:1]
    assert (
        find_entry(numbers.judge_numbers("shi2021", alone), "shi2021", name)["verdict"]
        == "consistent"
    )


def test_whole_numbers_are_exact_inputs() -> None:
    inputs = Inputs({"a": Rounded("2.50"), "b": [3, Rounded("0.1")]}, {}, {})
    product = Computation(
        lambda i: i["a"] * i["b"][0] * i["b"][1], inputs, inputs["a"] * inputs["b"][0] * 0.1
    )
    assert sorted(product.effects.values()) == pytest.approx([0.005 * 0.3, 0.05 * 7.5])
    assert product.interval == pytest.approx((0.75 - 0.3765, 0.75 + 0.3765))


@pytest.mark.parametrize(
    "text", ["inf", "-inf", "nan", "1e9999999999999999999999", "1e-9999999999999999999999"]
)
def test_numbers_without_a_last_digit_are_not_rounded(text: str) -> None:
    assert Rounded(text).rounding == 0.0


def test_designs_without_interactions_are_reported(audit: dict[str, Any]) -> None:
    """Nine runs have 8 degrees of freedom: 6 for main effects, 2 for the rest; three interactions
    would take 12.
    """
    (claim,) = [c for c in audit["claims"] if "interact" in c["claim"]]
    assert (claim["value"], claim["holds"]) == (-10.0, False)
    full = list(itertools.product((1, 2, 3), repeat=3))
    columns = {
        f"column_{name}": list(column)
        for name, column in zip("ABC", zip(*full, strict=True), strict=True)
    }
    inputs = Inputs({"factors": ["A", "B", "C"], **columns}, {}, {})
    assert FORMULAS["freedom of interactions over what they take"](inputs) == 0


def test_corrected_error_disappears() -> None:
    table = copy.deepcopy(numbers.load_numbers())
    table["disclosed"]["sun2019"]["pose 1"][2] = -10
    found_now = numbers.judge_numbers("sun2019", table)
    assert not any(e["cured_by"] for e in found_now)
    assert sum(e["verdict"] == "not reproduced" for e in found_now) <= 1


def test_other_error_is_identified() -> None:
    table = copy.deepcopy(numbers.load_numbers())
    table["disclosed"]["sun2019"]["pose 1"][2] = -10
    table["disclosed"]["sun2019"]["pose 4"][1] *= -1
    named = {e["cured_by"] for e in numbers.judge_numbers("sun2019", table) if e["cured_by"]}
    assert named == {"sign of 270 in pose 4"}


def test_causes_and_equations_are_counted_apart(audit: dict[str, Any]) -> None:
    page = (ROOT / "generated" / "AUDIT.md").read_text(encoding="utf-8")
    rows = [line for line in page.split("\n## ")[0].splitlines() if " | " in line]
    overview = {row.split(" | ")[0].strip("| "): row for row in rows}
    for paper, summary in audit["summary"].items():
        causes = [c for c in audit["causes"] if c["paper"] == paper]
        assert summary["causes"] == len(causes)
        faulty = {
            f"{paper}: {e['equation']}"
            for e in audit["equations"]
            if e["paper"] == paper and e["grade"] == "at fault"
        }
        assert {n for c in causes for n in c["equations"]} == faulty
        of_equations = sum(bool(c["equations"]) for c in causes)
        assert f"| {summary['at_fault']} | {of_equations} |" in overview[paper]
        assert summary["at_fault"] >= len(faulty)
    assert audit["summary"]["sun2019"]["causes"] == 2  # a claim, and a sign of a printed pose


def scaled(value: Any, factor: float) -> Any:
    """All measures in a value grown by a factor; texts, counts of items and choices stay."""
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        return value * factor
    if isinstance(value, list):
        return [scaled(item, factor + 0.013 * i) for i, item in enumerate(value)]
    return (
        {key: scaled(item, factor) for key, item in value.items()}
        if isinstance(value, dict)
        else value
    )


CHOICES = {
    "axis",
    "bar",
    "component",
    "dyad",
    "entry",
    "level",
    "levels",
    "against",
    "column_A",
    "column_B",
    "column_C",
    "value_points",
}


def changed(table: dict[str, Any]) -> dict[str, Any]:
    """The data with every input another one."""
    other = copy.deepcopy(table)
    for part in ("disclosed", "assumed"):
        for entry in other[part].values():
            for i, (name, value) in enumerate(entry.items()):
                entry[name] = value if name in CHOICES else scaled(value, 1.07 + 0.011 * (i % 7))
    for row in (*other["number"], *other["claim"]):
        for where in ("with", "each"):
            for i, (name, value) in enumerate(row.get(where, {}).items()):
                if name not in CHOICES:
                    row[where][name] = scaled(value, 1.09 + 0.017 * i)
    return other


def test_another_print_makes_no_number_equal() -> None:
    """Each is moved by two units of its last digit, and by all that the rounding of its inputs
    leaves open.
    """
    table = copy.deepcopy(numbers.load_numbers())

    def shifted(number: numbers.PrintedNumber) -> str:
        low, high = numbers.recompute(number, numbers.load_numbers()).computed.interval or (
            0.0,
            0.0,
        )
        place = Decimal(1).scaleb(int(Decimal(number.printed).as_tuple().exponent))
        return str(Decimal(number.printed) + (2 + round((high - low) / float(place))) * place)

    moved = iter([shifted(number) for number in numbers.list_numbers(numbers.load_numbers())])
    for row in table["number"]:
        printed = row["printed"]
        row["printed"] = (
            [next(moved) for _ in printed] if isinstance(printed, list) else next(moved)
        )
    was = {
        (e["paper"], e["quantity"])
        for e in numbers.judge_numbers()
        if e["verdict"] in ("reproduced", "consistent")
    }
    now = {(e["paper"], e["quantity"]): e["verdict"] for e in numbers.judge_numbers(content=table)}
    assert len(was) > 120
    assert all(now[key] not in ("reproduced", "consistent") for key in was)


def test_formulas_depend_on_their_inputs() -> None:
    """Other inputs give other values: of each formula, at least for one of the numbers or
    statements that use it.
    """
    table = numbers.load_numbers()
    other = changed(table)
    moved: dict[str, bool] = {}
    for before, after in zip(numbers.list_numbers(table), numbers.list_numbers(other), strict=True):
        moved[before.by] = moved.get(before.by, False) or differs(
            before.by, before.arguments, after.arguments, before.paper, other
        )
    for row, second in zip(table["claim"], other["claim"], strict=True):
        arguments = (row.get("with", {}), second.get("with", {}))
        moved[row["by"]] = moved.get(row["by"], False) or differs(
            row["by"], *arguments, row["paper"], other
        )
    discrete = {
        "not computed",
        "degrees of freedom",
        "real dyads",
        "eigenvalues that vanish",
        "driver is a crank",
        "names without an entry",
        "place in the order of influence",
        "best level by level means",
        "best level by prediction",
        "best level by ranks",
        "freedom of interactions over what they take",
        "rotation of the crank gear by both equations",
        "poses in the assembly of one of them",
        "support force",
        "optimum",
        "printed rule for the direction of the tip",
        "round trip of the law",
        "round trip of the path",
        "outline by both sections",
        "distance from the centre of the corner's path",
        "angle from the major axis of the corner's path",
        "mismatch with the third pair of sides",
        "play that the hexagon lacks",
        "semi-axis of the corner's path",
        "curvature radius where the path meets the side",
    }
    assert {by for by, was in moved.items() if not was} <= discrete


def differs(by: str, arguments: Any, other_own: Any, paper: str, other: dict[str, Any]) -> bool:
    table = numbers.load_numbers()
    before = FORMULAS[by](Inputs(arguments, table["disclosed"][paper], table["assumed"][paper]))
    try:
        after = FORMULAS[by](Inputs(other_own, other["disclosed"][paper], other["assumed"][paper]))
    except (PlanterError, ValueError, KeyError, IndexError, np.linalg.LinAlgError):
        return True
    if before is None or after is None:
        return before is not after
    return not math.isclose(before, after, rel_tol=1e-6, abs_tol=1e-9)


@pytest.mark.parametrize(
    ("claim", "change"),
    [
        ("chosen tip radius", {"tip_radius_mm": 10.4}),
        ("chosen fillet", {"fillet_mm": 4.4}),
        ("centre of the corner's path", {"centre_over_width": [-0.28, 0.5]}),
        ("foci of the corner's path", {"foci_slope": -1.7}),
        ("circumscribed alike", {"outline_angle_deg": 30}),
        ("gives back the law", {"law_p": -1.2}),
        ("arctan(yS/xS)", {"phi5_far_deg": 100}),
        ("a1 larger than a2", {"centre_distance_mm": 50}),
    ],
)
def test_another_input_changes_whether_a_statement_holds(
    claim: str, change: dict[str, Any]
) -> None:
    table = copy.deepcopy(numbers.load_numbers())
    (before,) = [e for e in verdicts.judge_claims() if claim in e["claim"]]
    for name, value in change.items():
        part = "disclosed" if name in table["disclosed"][before["paper"]] else "assumed"
        assert name in table[part][before["paper"]]
        table[part][before["paper"]][name] = value
    (after,) = [e for e in verdicts.judge_claims(content=table) if claim in e["claim"]]
    assert after["holds"] is not before["holds"]


@pytest.mark.parametrize(
    ("value", "must", "holds"),
    [
        (0.0, "= 0", True),
        (1e-6, "= 0", False),
        (3.0, "= 3", True),
        (0.05, "< 0.05", False),
        (-1e-12, ">= 0", True),
        (-1e-6, ">= 0", False),
        (1e-12, "<= 0", True),
        (0.0, "> 0", False),
    ],
)
def test_measures_satisfy_their_definitions(value: float, must: str, holds: bool) -> None:
    assert verdicts.interval_meets((value, value), must) is holds


def test_consequences_have_both_sides_and_reasons(audit: dict[str, Any]) -> None:
    equations = {(e["paper"], e["equation"]): e["verdict"] for e in audit["equations"]}
    wrong = {e["quantity"] for e in audit["numbers"] if e["verdict"] == "not reproduced"}
    assert {e["paper"] for e in audit["consequences"]} == {"shi2021", "yu2023", "sun2019"}
    for entry in audit["consequences"]:
        for name in entry["rests_on"]:
            assert equations.get((entry["paper"], name)) in verdicts.FAULTY or name in wrong
        if entry["paper"] == "shi2021":
            assert entry["as_printed"] != entry["as_derived"]


def test_no_faults_have_no_consequences(audit: dict[str, Any]) -> None:
    table = numbers.load_numbers()
    sound = copy.deepcopy({part: audit[part] for part in ("equations", "numbers")})
    for entry in sound["equations"]:
        entry["verdict"] = "confirmed"
    for entry in sound["numbers"]:
        entry["verdict"] = "reproduced"
    assert verdicts.derive_consequences(None, table, sound) == []
    for entry in sound["equations"]:
        if (entry["paper"], entry["equation"]) == ("yu2023", "14"):
            entry["verdict"] = "misprint"
    (left,) = verdicts.derive_consequences(None, table, sound)
    assert (left["paper"], left["rests_on"]) == ("yu2023", ["14"])
    assert left["as_printed"] > 1.5 * left["as_derived"]


def test_optimum_of_the_printed_equations_is_that_of_the_record(audit: dict[str, Any]) -> None:
    names = {"k6": "", "R3_mm": "mm", "theta_deg": "deg"}
    rows = {e["quantity"]: e for e in audit["numbers"] if e["quantity"].startswith("optimum, ")}
    device = Device(load_machine("wang2017"), "printed")
    best = optimise_device(device, method="ipopt", starts=1).result.design
    for name, unit in names.items():
        row = rows[f"optimum, {name}"]
        assert (row["unit"], row["verdict"]) == (unit, "not recomputable")
        assert row["recomputed"] == pytest.approx(best[name], rel=1e-6)
