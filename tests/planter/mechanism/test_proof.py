"""Proofs of optima of one's own mechanisms: enclosures against the engine's own results, bounds,
tampered cases.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import asdict, replace
from functools import cache, partial
from itertools import islice
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from planter.engine.goal import Goal
from planter.engine.measures import parse_limit, parse_sum
from planter.engine.proof import check_proof, enclosures
from planter.engine.proof.certificate_file import check_document, describe_claim, read_objective
from planter.engine.proof.enclosures import ResponseProgram
from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import ANYWHERE, Jet, Space
from planter.engine.proof.objective import (
    ObjectiveBounds,
    ProvableObjective,
    ProvedQuantity,
    build_provable_objective,
)
from planter.engine.proof.proof_results import GlobalBound
from planter.engine.proof.roots import EnclosedRoots
from planter.engine.response import MachineResponse
from planter.kernels import Array
from planter.kernels.generated import find_periodic
from planter.mechanism.file import MechanismFile, load
from planter.mechanism.machines import build_machine
from planter.mechanism.proof import EnclosedMechanism, build_objective, rebuild_objective
from planter.report.presentation import describe_proof
from planter.text_files import read_json
from tests.planter.engine.proof.tampering import list_tampered, renew
from tests.planter.engine.proof.test_certificates import check_apart
from tests.planter.engine.proof.toys import enclose_samples
from tests.support import own
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema

COUNT = 12
SMALL = 0.004
"""Share of the bounds that a box takes."""
QUANTITIES = {
    "transplanting_arm": (("F_Ox", False), ("M_in", True), ("beta_ddot", False), ("y_tip", False)),
    "planetary_train": (("F_Ox", False), ("M_in", False), ("chi", False), ("x_tip", False)),
    "cam_follower": (("F_Oy", False), ("s_ddot", False), ("P_M_in", True)),
}
"""Closed loops, closed forms with angles of two arguments and flanks, friction with simultaneous
equations.
"""


def find_box(file: MechanismFile, share: float = SMALL) -> tuple[Array, Array]:
    machine = build_machine(file)
    half = share * (machine.upper - machine.lower) / 2
    return machine.design - half, machine.design + half


def draw_designs(box: tuple[Array, Array], count: int) -> list[Array]:
    rng = np.random.default_rng(5)
    return [box[0] + rng.random(len(box[0])) * (box[1] - box[0]) for _ in range(count)]


def enclose(
    file: MechanismFile, quantities: tuple[tuple[str, bool], ...], box: tuple[Array, Array]
) -> list[Jet]:
    enclosed = EnclosedMechanism(build_machine(file), file.model)
    space, program = Space(*box), enclosed.record([ProvedQuantity(*pair) for pair in quantities])
    return enclose_samples(program, space, COUNT, enclosed.find_assembly(space.centre))


def count_misses(
    jets: list[Jet], file: MechanismFile, quantities: tuple[tuple[str, bool], ...]
) -> int:
    """Return how many values and slopes of the engine, at random designs, are outside their
    enclosures.
    """
    machine = build_machine(file)
    response = MachineResponse(machine, [name for name, _ in quantities])
    angles, misses = 2 * np.pi * np.arange(COUNT) / COUNT, 0
    for x in draw_designs(find_box(file), 6):
        values, slopes = response.slopes(response.at(x), angles)
        for jet, row, slope, (name, is_size) in zip(jets, values, slopes, quantities, strict=True):
            scale = (np.sign(row) if is_size else np.ones(COUNT)) / machine.find_quantity(
                name
            ).factor
            misses += count_outside(jet.value[ANYWHERE], row * scale)
            misses += count_outside(
                jet.gradient[ANYWHERE], (slope[:, 1:].T * scale)[list(jet.support)]
            )
    return misses


def count_outside(ball: Ball, value: Array) -> int:
    room = 1e-9 * (np.abs(value).max(initial=0) + 1e-3)
    return int(((value < ball.low - room) | (value > ball.high + room)).sum())


@pytest.mark.parametrize("name", QUANTITIES)
def test_enclosures_hold_values_and_slopes_at_random_designs(name: str) -> None:
    file = own.file(name)
    jets = enclose(file, QUANTITIES[name], find_box(file))
    assert count_misses(jets, file, QUANTITIES[name]) == 0
    for jet, (quantity, _) in zip(jets, QUANTITIES[name], strict=True):
        middle = np.abs(jet.value.mid[ANYWHERE]).max()
        assert jet.value.rad[ANYWHERE].max() < 0.2 * middle, (
            f"{quantity} is enclosed too widely to prove anything"
        )


def test_too_narrow_an_enclosure_of_loops_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    file, name = own.file("transplanting_arm"), "transplanting_arm"
    honest = enclosures.enclose_roots

    def pinch(space: Space, *rest: Any) -> EnclosedRoots:
        if space.half.shape[1] == 1:  # not where loops are followed, which would end there
            space.half = 0.3 * space.half
        return honest(space, *rest)

    monkeypatch.setattr(enclosures, "enclose_roots", pinch)
    assert count_misses(enclose(file, QUANTITIES[name], find_box(file)), file, QUANTITIES[name]) > 0


@cache
def build_bounding(name: str, objective: str, *limits: str, **changes: float) -> ProvableObjective:
    """Return a sum over samples of a mechanism, under limits, as a proof bounds it."""
    file = own.file(name, **changes)
    machine = build_machine(file)
    terms, holds = parse_sum(objective), [parse_limit(limit) for limit in limits]
    enclosed = EnclosedMechanism(machine, file.model)
    return build_provable_objective(machine, terms, COUNT, enclosed, holds)


def evaluate(objective: str, x: Array) -> float:
    """Return a sum over samples of the four-bar, as a search evaluates it."""
    return Goal(build_machine(own.file(ARM_NAME)), parse_sum(objective), (), COUNT).evaluate(x)


ARM_NAME, ARM_SUM = "transplanting_arm", "range F_Ox + rms M_in"
SUMS = (
    "range F_Ox + 0.5 rms M_in + max abs F_Oy + y_tip at 50",
    "-min F_Oy + std F_Ox + 0.1 variance F_Oy + mean x_tip + work M_in + work P_M_in",
)


@pytest.mark.parametrize("objective", SUMS)
def test_bounds_are_below_the_objective_of_every_design(objective: str) -> None:
    bounding, box = build_bounding(ARM_NAME, objective), find_box(own.file(ARM_NAME))
    bounds, goal = bounding(*box), partial(evaluate, objective)
    centre = goal((box[0] + box[1]) / 2)
    slack = 1e-9 * abs(centre)
    assert bounds.lower_bound <= min(map(goal, draw_designs(box, 6))) + slack
    assert bounds.reached == pytest.approx(centre, rel=1e-9)
    spread = bounds.slopes.low @ (box[1] - box[0]), bounds.slopes.high @ (box[1] - box[0])
    assert spread[0] - slack <= goal(box[1]) - goal(box[0]) <= spread[1] + slack


def test_true_objective_may_hold_a_value_at_an_angle() -> None:
    file = own.file(ARM_NAME)
    x = build_machine(file).design
    bounds = build_objective(file, {}, parse_sum("y_tip at 50"), [], None)(x, x)
    assert bounds.lower_bound <= evaluate("y_tip at 50", x) <= bounds.reached
    assert bounds.reached - bounds.lower_bound < 1e-9 * bounds.reached


def test_possible_friction_reversal_disables_slope_proof() -> None:
    """Where the sign of a sliding speed is open, the objective may jump: no direction only rises or
    falls.
    """
    crank = find_box(own.file("slider_crank", e_mm=0.0), 1e-5)
    assert build_bounding("slider_crank", "max abs F_Oy", e_mm=0.0)(*crank).may_jump
    assert not build_bounding(ARM_NAME, ARM_SUM)(*find_box(own.file(ARM_NAME))).may_jump


def bound_arm(objective: str, *limits: str) -> ObjectiveBounds:
    """Return bounds of a sum over a small box of the four-bar, under limits."""
    return build_bounding(ARM_NAME, objective, *limits)(*find_box(own.file(ARM_NAME)))


def test_boxes_violating_a_limit_are_empty() -> None:
    objective, machine = ARM_SUM, build_machine(own.file(ARM_NAME))
    greatest = evaluate("max M_in", machine.design)
    free = bound_arm(objective)
    assert bound_arm(objective, f"max M_in <= {0.9 * greatest}").lower_bound == np.inf
    assert bound_arm(objective, f"M_in >= {1.1 * greatest}").lower_bound == np.inf
    limited = bound_arm(objective, f"M_in <= {1.1 * greatest}")
    assert (limited.lower_bound, limited.reached, limited.may_jump) == (
        free.lower_bound,
        free.reached,
        False,
    )
    crossed = bound_arm(objective, f"max M_in <= {greatest}")
    assert crossed.lower_bound == free.lower_bound
    assert crossed.may_jump, "no side stands for a box that a limit crosses"


def test_samples_without_an_enclosure_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    sums = "range F_Ox + rms M_in", "max F_Ox + std M_in - min F_Oy + variance F_Ay"
    free_bounds, prepare = [bound_arm(objective) for objective in sums], ResponseProgram.prepare

    def fail(self: ResponseProgram, space: Space, phi: Jet, starts: Any) -> list[Jet]:
        gap = np.where(np.arange(phi.lanes) == 5, np.nan, 0.0)
        angles, *rest = prepare(self, space, phi, starts)
        return [angles + space.constant(Ball.exact(gap)), *rest]

    monkeypatch.setattr(ResponseProgram, "prepare", fail)
    for objective, other in zip(sums, free_bounds, strict=True):
        part = bound_arm(objective)
        assert part.lower_bound <= other.lower_bound + 1e-9 * abs(other.lower_bound)
        assert part.lower_bound > 0.5 * other.lower_bound
        assert (part.reached, part.may_jump) == (np.inf, True)
    with pytest.raises(Unbounded, match="every angle"):
        bound_arm("mean F_Ox")


def bound_at_once(*boxes: tuple[Array, Array]) -> list[ObjectiveBounds | Unbounded]:
    """Return the bounds over boxes of the four-bar, at once, or why there are none."""
    return build_bounding(ARM_NAME, ARM_SUM).bound_boxes(boxes)


def move(changes: dict[str, float]) -> tuple[Array, Array]:
    """Return the small box about another design, given in the units of the file."""
    machine = build_machine(own.file("transplanting_arm"))
    shift = np.array(
        [
            changes.get(name, x / f) * f - x
            for name, x, f in zip(machine.design_names, machine.design, machine.scale, strict=True)
        ]
    )
    lower, upper = find_box(own.file("transplanting_arm"))
    return lower + shift, upper + shift


OPEN = {"a_mm": 60.0, "b_mm": 110.0, "c_mm": 80.0, "d_mm": 180.0}
"""A four-bar whose crank and frame are longer than the other bars: it does not close at 180 deg."""


def test_batched_boxes_equal_single_boxes() -> None:
    boxes = [
        move({}),
        move(OPEN),
        move({"a_mm": 40.0, "k_N_m": 300.0}),
        find_box(own.file("transplanting_arm"), 0.05),
    ]
    for box, result in zip(boxes, bound_at_once(*boxes), strict=True):
        (alone,) = bound_at_once(box)
        assert isinstance(result, ObjectiveBounds)
        assert isinstance(alone, ObjectiveBounds)
        assert result.lower_bound == pytest.approx(alone.lower_bound, rel=1e-5), (
            "how often roots are narrowed may differ"
        )
        assert result.reached == pytest.approx(alone.reached, rel=1e-9)
        np.testing.assert_allclose(result.slopes.mid, alone.slopes.mid, rtol=1e-3, atol=1e-3)


def test_boxes_whose_loops_cannot_close_hold_no_design() -> None:
    machine = build_machine(own.file("transplanting_arm"))
    lower, upper = move(OPEN)
    assert [
        result.lower_bound
        for result in bound_at_once((lower, upper))
        if isinstance(result, ObjectiveBounds)
    ] == [np.inf]
    (wide,) = bound_at_once((np.minimum(lower, machine.design), np.maximum(upper, machine.design)))
    assert isinstance(wide, Unbounded) or wide.lower_bound < np.inf, "one of its designs closes"


def measure_gaps(xp: object, q: Sequence[float]) -> tuple[float, ...]:
    """A loop in an angle, a length and an angle that a gear turns further."""
    beta = q[0]
    s = q[1]
    gamma = q[2]
    return xp.cos(beta) - s, xp.sin(beta) + xp.sin(2 * gamma), gamma - beta * 0  # type: ignore[attr-defined]


def test_angles_are_periodic_only_in_sine_and_cosine() -> None:
    assert find_periodic(own.array_code("transplanting_arm"), "closure", "loops", 2) == [True, True]
    assert find_periodic(sys.modules[__name__], "measure_gaps", "q", 3) == [False, False, False]


ARM = """
[bounds]
k_N_m = [600, 700]
p_mm = [200, 280]

[turn]
samples = 12

[objective]
least = "range F_Ox + rms M_in"
"""


@cache
def write_arm() -> str:
    """Return the file of a heavier arm whose spring and tip may move."""
    folder = own.generated("transplanting_arm")
    text = (folder / "transplanting_arm.toml").read_text()
    begin, end = text.index("[bounds]"), text.index("[origin]")
    path = folder / "heavy_arm.toml"
    path.write_text(
        text[:begin].replace("m_b_kg = 0.82", "m_b_kg = 1.3") + ARM.lstrip() + "\n" + text[end:]
    )
    return str(path)


def test_optimise_proves_user_mechanism() -> None:
    result = answer("optimise", write_arm(), "--starts", "1", "--prove", "--prove-seconds", "30")
    proof = result["proof"]
    assert (proof["kind"], proof["samples"]) == ("true", None)
    assert proof["proved"], proof["statement"]
    assert proof["lower_bound"] <= proof["objective"] == result["objective"]
    assert 0 <= proof["gap"] <= 1e-6 * proof["objective"]
    sampled = answer("optimise", write_arm(), "--starts", "1", "--samples", str(COUNT), "--prove")[
        "proof"
    ]
    assert (sampled["kind"], sampled["samples"]) == ("sampled", COUNT)
    assert sampled["proved"], sampled["statement"]
    assert sampled["objective"] < proof["lower_bound"], "twelve samples miss the extremes"


@pytest.mark.parametrize("bound", [3.5, None])
def test_page_shows_proof_with_and_without_bound(bound: float | None) -> None:
    proof = GlobalBound(
        kind="sampled",
        samples=COUNT,
        design={"k_N_m": 641.5},
        objective=4.0,
        lower_bound=bound,
        gap=None if bound is None else 0.5,
        boxes=7,
        seconds=1.0,
        proved=False,
        statement="not proved",
    )
    html = "".join(block.html("proof") for block in describe_proof(proof.table()))
    assert "641.5" in html
    assert "k / N/m" in html
    assert ("3.5" in html) == (bound is not None)
    assert html.count("\N{EN DASH}</dd>") == (2 if bound is None else 0)


def test_objectives_without_a_proof_are_refused_first() -> None:
    for objective, reason in (
        ("rms M_in while y_tip <= 100 mm", "`while`"),
        ("F_Ox where y_tip is least", "`where`"),
        ("max law_power", "law"),
    ):
        text = refusal(
            "optimise", write_arm(), "--least", objective, "--prove", "--prove-seconds", "1"
        )
        assert "--least: " in text
        assert reason in text


def test_design_without_enclosure_returns_search_result() -> None:
    """The sliding speed of the follower is zero at the first sample, whose contact has no bound
    over a box.
    """
    folder = own.generated("cam_follower")
    result = answer(
        "optimise",
        str(folder / "cam_follower.toml"),
        "--least",
        "rms N_cam",
        "--samples",
        "8",
        "--starts",
        "1",
        "--prove",
        "--prove-seconds",
        "0",
    )
    assert not result["proof"]["proved"]
    assert result["proof"]["statement"].startswith("not proved")
    assert result["objective"] == pytest.approx(result["proof"]["objective"])


@cache
def prove_slider_crank() -> Path:
    """Return the folder of a proof with friction, whose reactions are solved for, over samples."""
    path = own.generated("slider_crank") / "slider_crank.toml"
    folder = path.parent / "proved"
    answer(
        "optimise",
        str(path),
        "--least",
        "range F_Oy",
        "--vary",
        "r_mm=49:51",
        "--samples",
        "12",
        "--starts",
        "1",
        "--prove",
        "--out",
        str(folder),
    )
    return folder


X_PIN = 0.049
"""Place of the crank pin along the guide at the angle 0 of the best design [m]."""


def run_checker(folder: Path, file: Path) -> tuple[int, str]:
    """Return exit code and last line of the checker that lies beside a proof, in a place without
    planter.
    """
    command = [sys.executable, "-I", str(folder / "check_proof.py"), str(file), "1"]
    process = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return process.returncode, process.stdout.splitlines()[-1]


def test_proof_is_checked_from_its_file() -> None:
    folder = prove_slider_crank()
    file = folder / "proof.json"
    result, proof = (
        answer("prove", "--check", str(file)),
        read_json(folder / "summary.json")["proof"],
    )
    jsonschema.validate(result, load_schema("prove"))
    assert result["valid"]
    assert result["kind"] == "sampled"
    assert result["lower_bound"] == proof["lower_bound"]
    assert result["gap"] == pytest.approx(proof["gap"], abs=1e-12)
    assert run_checker(folder, file) == (0, "valid")


@cache
def read_slider_crank() -> tuple[str, dict[str, Any]]:
    """Return the file of the slider-crank, and its proof."""
    folder = prove_slider_crank()
    return str(folder.parent / "slider_crank.toml"), read_json(folder / "proof.json")


@pytest.mark.parametrize("step", [11, pytest.param(1, marks=pytest.mark.long)])
def test_tampered_proofs_with_loops_are_refused(step: int) -> None:
    """Of the programs, the suite tampers with each eleventh part."""
    source, document = read_slider_crank()
    rebuild, valid = partial(rebuild_objective, source), []
    assert check_document(document, rebuild).valid
    for name, tampered in islice(list_tampered(document), 0, None, step):
        valid += [f"{name}: planter"] if check_document(tampered, rebuild).valid else []
        valid += [f"{name}: check_proof"] if check_apart(tampered) is None else []
    assert not valid


def prove_greatest(document: dict[str, Any]) -> dict[str, Any]:
    """Return the claim that no greatest value of s is below what it is in an assembly."""
    x = [float.fromhex(value) for value in document["incumbent"]["x"]]
    document["terms"] = [{**document["terms"][0], "measure": "min", "weight": (-1.0).hex()}]
    objective = read_objective(document)
    bounds = objective(np.array(x), np.array(x))
    document["box"] = [document["incumbent"]["x"]] * 2
    document["lower_bound"] = (bounds.lower_bound - 1e-9).hex()
    document["incumbent"] |= {"upper_bound": None}
    document["incumbent"].pop("evidence", None)
    document["nodes"] = [{"bound": document["lower_bound"], "evidence": {"continued": 0}}]
    return renew(document)


def test_other_assemblies_are_other_claims() -> None:
    """The slider of a slider-crank may be on either side: 240 mm and -150 mm are not the same."""
    source = own.generated("slider_crank") / "slider_crank.toml"
    file = load(source)
    machine = build_machine(file)
    machine = replace(
        machine, moved=machine.moved[:1], lower=machine.lower[:1], upper=machine.upper[:1]
    )
    enclosed = EnclosedMechanism(machine, file.model)
    _, honest = read_slider_crank()
    plain = build_provable_objective(machine, parse_sum("max s"), COUNT, enclosed)
    quantities = [{**asdict(ProvedQuantity("s")), "factor": (1.0).hex()}]
    document = deepcopy(honest) | describe_claim(plain, (machine.lower, machine.upper), COUNT)
    document["machine"]["quantities"] = quantities
    document["assembly"]["design"] = document["incumbent"]["x"]
    document["assembly"]["roots"] = honest["assembly"]["roots"]
    other = deepcopy(document)
    beta, s = (float.fromhex(root) for root in honest["assembly"]["roots"][0])
    other["assembly"]["roots"] = [[(np.pi - beta).hex(), (2 * X_PIN - s).hex()]]
    rebuild = partial(rebuild_objective, str(source))
    right, wrong = prove_greatest(document), prove_greatest(other)
    assert check_document(right, rebuild).valid
    assert check_apart(right) is None
    assert right["statement"] != wrong["statement"]
    assert "assembly" in str(check_document(wrong, rebuild).reason)
    bounds = [float.fromhex(entry["lower_bound"]) for entry in (right, wrong)]
    assert bounds[1] - bounds[0] > 0.2, "on one side the slider is 0.4 m further"
    right["lower_bound"] = right["nodes"][0]["bound"] = wrong["lower_bound"]
    assert not check_document(renew(right), rebuild).valid
    assert check_apart(right)


def compare_apart(document: dict[str, Any], path: Path) -> str | None:
    """Return why the checker refuses a generated module, None if it is that of the proof."""
    check_proof.PROOF = check_proof.ProofClaims(document)
    try:
        check_proof.compare_module(document, path)
    except check_proof.RefusedError as error:
        return str(error)
    return None


def test_checker_compares_programs_with_generated_functions() -> None:
    source, document = read_slider_crank()
    path = Path(source).parent / "array" / "slider_crank.py"
    assert compare_apart(document, path) is None
    swapped, moved, constant = (deepcopy(document) for _ in range(3))
    swapped["machine"]["inputs"]["moved"] = [document["machine"]["inputs"]["moved"][0] + 1]
    beta, s = (float.fromhex(root) for root in document["assembly"]["roots"][0])
    moved["assembly"]["roots"] = [[(np.pi - beta).hex(), (2 * X_PIN - s).hex()]]
    last = constant["response"]["stages"][-1]
    last["operations"], last["outputs"] = [["constant", [], [(0.5).hex()]]], [0]
    for tampered in (swapped, moved, constant):
        assert "--machine" in str(compare_apart(tampered, path))


def test_tampered_and_unreadable_proofs_have_their_exit_codes(tmp_path: Path) -> None:
    folder = prove_slider_crank()
    document = read_json(folder / "proof.json")
    document["lower_bound"] = (2 * float.fromhex(document["lower_bound"])).hex()
    tampered, unreadable = tmp_path / "tampered.json", tmp_path / "unreadable.json"
    tampered.write_text(json.dumps(renew(document)))
    unreadable.write_text("{")
    code, output, _ = run("prove", str(tampered), "--json")
    assert (code, json.loads(output)["valid"]) == (1, False)
    assert "lower_bound" in json.loads(output)["reason"]
    code, reason = run_checker(folder, tampered)
    assert code == 1
    assert "lower_bound" in reason
    assert str(unreadable) in refusal("prove", str(unreadable))
    assert run_checker(folder, unreadable)[0] == 2
    assert "format" in refusal("prove", str(folder / "summary.json"))
