"""The comparison of gear families: a pair beside the narrow box, resumed after a kill without loss;
ranks of pairs.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest

from planter.engine.solvers.local_search import LocalMinimum
from planter.engine.solvers.objective import ObjectiveEvaluation, ObjectiveSummary
from planter.errors import InputError
from planter.gears.geometry import families
from planter.papers.planting import family_pairs as box
from planter.papers.planting import family_pairs as pair
from planter.papers.planting import file
from planter.papers.planting.design_summary import summarise_design
from planter.papers.planting.family_comparison import (
    ComparisonStore,
    _ranked,
    build_proposal,
    compare_families,
    compute_remaining_violation,
)
from planter.papers.planting.model import Device
from planter.papers.planting.objective import evaluate_true_extremes
from planter.papers.planting.presentation import pair_name
from planter.papers.planting.results import ComparedPair
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema

PAIR = "eccentric_circle+ellipse"
KEYS = {"stage1", "stage2", "feasible", "objective", "range_N", "variance_N2", "design", "binding"}


def words(out: Path) -> list[str]:
    return ["compare", "wang2017", "--starts", "1", "--json", "--out", str(out), "--pair", PAIR]


@pytest.fixture(scope="module")
def resumed(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, dict[str, int], Path, str]:
    """A run killed after its first devices and then resumed: result, its files before, folder, what
    was said.
    """
    out = tmp_path_factory.mktemp("compare")
    first = subprocess.Popen(
        [sys.executable, "-m", "planter", *words(out)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    limit = time.monotonic() + 120
    while not list((out / "devices").glob("*.json")) and time.monotonic() < limit:
        time.sleep(0.05)
    os.kill(first.pid, signal.SIGKILL)
    first.wait()
    before = {path.name: path.stat().st_mtime_ns for path in (out / "devices").glob("*.json")}
    assert len(before) == 1
    assert not (out / "summary.json").exists()
    code, output, messages = run(*words(out), "--resume")
    assert code == 0, messages
    return json.loads(output), before, out, messages


@pytest.mark.fault
def test_resumed_comparison_is_complete_without_repeats(
    resumed: tuple[dict, dict[str, int], Path, str],
) -> None:
    result, before, out, message = resumed
    after = {path.name: path.stat().st_mtime_ns for path in (out / "devices").glob("*.json")}
    assert set(after) == {f"{PAIR}.json", "narrow.json"}
    assert {name: after[name] for name in before} == before
    assert "device 1 of 2, done before" in message
    assert len(result["devices"]) == 1


def test_keys_and_ranks(resumed: tuple[dict, dict[str, int], Path, str]) -> None:
    result, _, out, _ = resumed
    assert result["seconds"] > 0
    jsonschema.validate(result, load_schema("compare"))
    assert all(set(entry) >= KEYS for entry in result["devices"])
    assert result["devices"][0]["objective"] < result["narrow"]["objective"]
    for entry in result["devices"]:
        verdicts = {requirement["verdict"] for requirement in entry["requirements"]}
        assert (verdicts == {"pass"}) is entry["feasible"]
        assert not entry["settled"] or not entry["feasible"]  # one start cannot agree with another
        assert not entry["feasible"] or entry["kkt_residual"] < 1e-6
        assert entry["lacks"][-1].startswith("a second start that agrees") or not entry["feasible"]
        assert (entry["rank"] is None) is not entry["settled"]
    assert result["settled"] == sum(entry["settled"] for entry in result["devices"])
    page = (out / "report.html").read_text()
    assert "Comparison of gear families" in page
    assert all(pair_name(ComparedPair.read(entry)) in page for entry in result["devices"])
    assert (out / "figures" / "comparison.svg").exists()
    assert len((out / "devices.csv").read_text().splitlines()) == 3


@pytest.mark.long
def test_two_pairs_are_ranked_by_objective() -> None:
    result = answer(
        "compare", "wang2017", "--starts", "1", "--pair", "ellipse+ellipse", "--pair", PAIR
    )
    assert len(result["devices"]) == 2
    feasible = [entry["feasible"] for entry in result["devices"]]
    assert feasible == sorted(feasible, reverse=True)
    objectives = [entry["objective"] for entry in result["devices"] if entry["feasible"]]
    assert objectives == sorted(objectives)
    assert objectives[0] < result["narrow"]["objective"]


def test_another_question_is_not_answered_from_the_folder(
    resumed: tuple[dict, dict[str, int], Path, str],
) -> None:
    _, _, out, _ = resumed
    paper_device, pair = file.load("wang2017"), ("eccentric_circle", "ellipse")
    assert ComparisonStore(out / "devices", paper_device, 1, 0).load(pair) is not None
    assert ComparisonStore(out / "devices", paper_device, 1, 1).load(pair) is None
    assert (
        ComparisonStore(out / "devices", file.load("wang2017", {"sun_kg": 0.41}), 1, 0).load(pair)
        is None
    )


def test_devices_changing_places_are_not_read(
    resumed: tuple[dict, dict[str, int], Path, str], tmp_path: Path
) -> None:
    pair = ("eccentric_circle", "ellipse")
    shutil.copy(resumed[2] / "devices" / f"{'+'.join(pair)}.json", tmp_path / "narrow.json")
    assert ComparisonStore(tmp_path, file.load("wang2017"), 1, 0).load(None) is None


def test_machine_design_equals_described_design(
    resumed: tuple[dict, dict[str, int], Path, str],
) -> None:
    """The families' own parameters, put into a machine of these families, make the same
    objective.
    """
    (entry,) = resumed[0]["devices"]
    device_table = file.load("wang2017").table()
    device_table["design"] = {name: entry["design"][name] for name in device_table["design"]}
    device_table["bounds"] = {
        name: [value - 1e-3, value + 1e-3] for name, value in device_table["design"].items()
    }
    device = Device(file.PlantingMachine.read(device_table, "own"))
    assert evaluate_true_extremes(device, device.design).range_N == pytest.approx(
        entry["range_N"], rel=1e-7
    )


@pytest.mark.parametrize("family", families.list_families())
def test_described_curves_have_requested_size_and_swing(family: str) -> None:
    paper_device = file.load(box.REFERENCE)
    device = Device(box.build_pair_machine(paper_device, (family, family)))
    swings = []
    for stage in (0, 1):
        size, swing, m = box.measure_curve(device, stage)
        swings.append(swing)
        expected = device.design[[n.startswith("size") for n in device.names]][stage]
        assert size == pytest.approx(expected, rel=0.02)
        assert swing == pytest.approx(
            device.design[[n.startswith("swing") for n in device.names]][stage], rel=0.02
        )
        assert m == device.design[[n.startswith("m") for n in device.names]][stage]
    assert all(name in device.names for name in ("size3_mm", "swing3", "size6_mm", "swing6"))
    assert families.find_family(f"{family}-relative") == family


def test_conflict_is_reported_with_feasible_proposal() -> None:
    strict = file.load(box.REFERENCE, {"funnel_speed_margin_m_s": 0.05})
    comparison = compare_families(strict, starts=1, pairs=[("ellipse", "ellipse")])
    entry = comparison.devices[0]
    assert not entry.feasible
    assert entry.settled is (entry.lacks == [])
    proposal = comparison.proposal
    assert proposal.conflicting == [violation.name for violation in entry.violations]
    assert proposal.violation < 1e-6
    half = {
        violation.key: (violation.limit + violation.relaxed) / 2 for violation in entry.violations
    }
    assert compute_remaining_violation(strict, entry, half) > 1e-3
    assert build_proposal(strict, [replace(entry, feasible=True)]) is None


VIOLATION = {
    "name": "depth",
    "amount": 1.0,
    "unit": "mm",
    "phi_deg": None,
    "value": 1.0,
    "key": "depth_min_mm",
    "limit": 2.0,
    "relaxed": 1.0,
}


def _entry(objective: float, **more: object) -> dict:
    entry = {
        "stage1": "eccentric_circle",
        "stage2": "eccentric_circle",
        "feasible": True,
        "settled": True,
        "objective": objective,
        "range_N": 1.23456789,
        "variance_N2": 1234567.8,
        "kkt_residual": 1e-9,
        "binding": ["seedling_clearance", "curvature_radius", "nozzle_distance", "contact_ratio"],
        "violations": [],
        "lacks": [],
        "design": {},
        "requirements": [],
        "objectives": [objective],
        "agreeing_starts": 2,
        "designer": _designer(),
        "seconds": 1.0,
    }
    return entry | more


@cache
def _designer() -> dict:
    device = Device(file.load("wang2017"))
    return summarise_design(device, device.design).table()


def test_unsettled_pairs_are_ranked_apart() -> None:
    ranked = _ranked(
        [
            _entry(3.0),
            _entry(1.0, settled=False),
            _entry(2.0),
            _entry(1.5, feasible=False, settled=False, violations=[VIOLATION]),
        ]
    )
    assert [(pair.rank, pair.objective) for pair in ranked] == [
        (1, 2.0),
        (2, 3.0),
        (None, 1.0),
        (None, 1.5),
    ]


def test_settled_requires_small_residual_and_agreement() -> None:
    problem = SimpleNamespace(scale=1.0)

    def minimum(objective: float, residual: float) -> LocalMinimum:
        return LocalMinimum(
            np.zeros(1),
            ObjectiveEvaluation(objective, ObjectiveSummary(0.0, np.zeros(2))),
            residual,
            1,
        )

    assert (
        pair._list_missing_evidence(problem, [minimum(1.0, 1e-9), minimum(1.0 + 9e-7, 1e-3)]) == []
    )
    rough = pair._list_missing_evidence(problem, [minimum(1.0, 1e-5), minimum(1.0, 1e-5)])
    assert rough == ["a KKT residual below 1e-06 (1e-05)"]
    alone = pair._list_missing_evidence(problem, [minimum(1.0, 1e-9), minimum(1.00001, 1e-9)])
    assert alone == ["a second start that agrees (the next ended at 1.00001)"]
    assert pair._list_missing_evidence(problem, [minimum(1.0, 1e-9)]) == [
        "a second start that agrees (no other kept the requirements)"
    ]


BAD = {
    "unknown family": (["--pair", "ellipse+oval"], "--pair ellipse+oval: it must be two of"),
    "one family": (["--pair", "ellipse"], "--pair ellipse:"),
    "nowhere to resume": (["--resume"], "--resume needs --out"),
    "no starts": (["--starts", "0"], "--starts"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_calls_are_refused_in_a_sentence(case: str) -> None:
    arguments, message = BAD[case]
    assert message in refusal("compare", "wang2017", *arguments)


def test_resume_without_a_folder_is_an_input_error() -> None:
    with pytest.raises(InputError, match="--out"):
        compare_families(file.load("wang2017"), resume=True)


def test_the_registry_squared_is_compared() -> None:
    assert len(box.list_pairs()) == len(families.list_families()) ** 2
    assert ("eccentric_circle", "ellipse") in box.list_pairs()
    assert np.unique(box.list_pairs(), axis=0).shape == (len(families.list_families()) ** 2, 2)
