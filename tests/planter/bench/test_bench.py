"""The benchmark: nobody is timed who is wrong, everybody is told apart, the numbers have their
keys.
"""

import importlib
import itertools
import json
import math
import platform
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import casadi as ca
import jsonschema
import numpy as np
import pytest
from pydantic import TypeAdapter

from planter import workers
from planter.bench import mechanisms, tasks
from planter.bench.array_backends import (
    DESIGNS_PER_ARRAY,
    build_jax_contender,
    build_numpy_contender,
    build_sympy_contender,
)
from planter.bench.casadi_backends import build_kernel_contender, build_virtual_machine
from planter.bench.case import Absent, BenchmarkCase, Contender
from planter.bench.measurement import (
    MOST_CALLS,
    REDUCTION,
    SERIES,
    Disagreement,
    Peak,
    check_agreement,
    count_executed_operations,
    count_operations,
    relative_difference,
    time_calls,
)
from planter.bench.mechanisms import _run, find_checkout
from planter.bench.presentation import format_markdown, present_benchmark, write_benchmark
from planter.bench.results import (
    ArithmeticPeak,
    ArithmeticRate,
    BasinSearch,
    Benchmark,
    BenchmarkMachine,
    DrawnOutline,
    DurationQuartiles,
    SeedTimes,
    SkippedWay,
    TaskTimes,
    WayTimes,
    choose_settings,
)
from planter.engine.goal import Goal
from planter.errors import ComputationError
from planter.kernels import Kernel, backends, toolchain
from planter.terminal.console import Console
from tests.support.cli import below
from tests.support.schemas import load_schema

pytestmark = pytest.mark.usefixtures("kernel_cache")
run, _, _ = below("bench")
QUICK = ("--quick", "--rounds", "1")
WORKS = (
    "cycle",
    "cycle+gradient",
    "hessian",
    "batch",
    "optimise",
    "slider-crank",
    "four-bar",
    "gears",
    "derive",
    "cold start",
)


@pytest.fixture(scope="module")
def case() -> BenchmarkCase:
    return BenchmarkCase()


@pytest.fixture(scope="module")
def designs(case: BenchmarkCase) -> list[np.ndarray]:
    return list(itertools.islice(case.designs(seed=7), 4))


def has_compiler() -> bool:
    try:
        toolchain.find_compiler()
    except toolchain.CompilerError:
        return False
    return True


@pytest.mark.long
def test_the_quick_benchmark_has_the_keys_of_the_contract(tmp_path: Path) -> None:
    ways = [word for way in tasks.WAYS if way != "jax" for word in ("--way", way)]
    code, out, err = run(*QUICK, *ways, "--json", "--out", str(tmp_path / "here"))
    assert code == 0, err
    result = json.loads(out)
    assert {"work", "machine", "versions"} <= result.keys()
    assert [work["name"] for work in result["work"]] == ["cycle", "cycle+gradient", "optimise"]
    assert {entry["work"] for entry in result["skipped"]} >= {
        "hessian",
        "batch",
        "derive",
        "cold start",
    }
    for work in result["work"]:
        assert isinstance(work["unit"], str)
        named = {way["way"]: way for way in work["ways"]}
        assert set(named) <= (
            {"ga", "ipopt", "hybrid"} if work["name"] == "optimise" else set(tasks.WAYS)
        )
        over = named[work["over"]]["median_us"]
        for way in named.values():
            assert way["ratio"] == way["median_us"] / over
            assert (
                way["spread"]["quartile1_us"] <= way["median_us"] <= way["spread"]["quartile3_us"]
            )
        if work["name"] == "optimise":
            smallest = named["ga"]["objectives"]["least"]
            assert named["ipopt"]["objectives"]["largest"] <= smallest
            assert named["hybrid"]["objectives"]["largest"] <= smallest
        else:
            assert {"way": "jax", "reason": "not asked for (--way)"} in work["skipped"]
            assert work["over"] == ("lanes" if has_compiler() else "casadi-vm")
    assert json.loads((tmp_path / "here" / "bench.json").read_text()) == result
    text = (tmp_path / "here" / "bench.md").read_text()
    jsonschema.validate(result, load_schema("bench"))
    assert text == format_markdown(TypeAdapter(Benchmark).validate_python(result))
    assert all(version in text for version in result["versions"].values())


def test_every_work_has_a_runner_and_a_unit() -> None:
    assert choose_settings().works == WORKS
    assert set(tasks.UNITS) | {"batch", *mechanisms.EXAMPLES} == set(WORKS)


def _built(builder: tasks.Builder, case: BenchmarkCase, work: str) -> Contender:
    try:
        return builder(case, work)
    except Absent as reason:
        pytest.skip(str(reason))


def evaluate_objective(case: BenchmarkCase) -> tuple[float, np.ndarray]:
    device = case.device
    goal = Goal(device.engine, device.engine.objective, (), case.turns.samples)
    return goal.evaluate(device.design), goal.slope(device.design)


@pytest.mark.parametrize(
    "builder",
    [build_virtual_machine, build_numpy_contender, build_sympy_contender, build_kernel_contender],
)
def test_ways_agree_with_simulate_on_objective(case: BenchmarkCase, builder: tasks.Builder) -> None:
    expected, _ = evaluate_objective(case)
    assert _built(builder, case, "cycle").call(case.device.design) == pytest.approx(
        expected, rel=1e-10
    )


@pytest.mark.parametrize(
    "builder",
    [
        build_virtual_machine,
        build_numpy_contender,
        pytest.param(build_sympy_contender, marks=pytest.mark.long),
        build_kernel_contender,
    ],
)
def test_ways_agree_with_simulate_on_gradient(case: BenchmarkCase, builder: tasks.Builder) -> None:
    expected, gradient = evaluate_objective(case)
    way = _built(builder, case, "cycle+gradient")
    again, actual = way.call(case.device.design)
    assert again == pytest.approx(expected, rel=1e-10)
    assert relative_difference(actual, gradient) <= way.tolerances[1]


def test_jax_agrees(case: BenchmarkCase, designs: list[np.ndarray]) -> None:
    pytest.importorskip("jax")
    peers = {
        "casadi-vm": build_virtual_machine(case, "cycle"),
        "jax": build_jax_contender(case, "cycle", thorough=False),
    }
    assert check_agreement("cycle", peers, designs)["jax"] < 1e-10


def test_hessians_agree_and_are_the_slope_of_the_gradient(case: BenchmarkCase) -> None:
    x, step = case.device.design, 1e-6 * (case.device.upper - case.device.lower)
    hessian = build_virtual_machine(case, "hessian").call(x)
    assert relative_difference(hessian, case.turns.hessian(x)) < 1e-10
    slopes = np.array(
        [case.turns.gradient(x + d)[1] - case.turns.gradient(x - d)[1] for d in np.diag(step)]
    )
    assert relative_difference(slopes / (2 * step[:, None]), hessian) < 1e-4


def test_batches_agree_with_single_designs(case: BenchmarkCase) -> None:
    designs = case.draw_designs(np.random.default_rng(2), DESIGNS_PER_ARRAY + 3)
    singles = np.array([case.turns.value(x) for x in designs])
    for builder in (build_numpy_contender, build_virtual_machine):
        assert relative_difference(builder(case, "batch").call(designs), singles) < 1e-10


def tampered(builder: tasks.Builder, change: Callable[..., object]) -> tasks.Builder:
    def built(case: BenchmarkCase, work: str) -> Contender:
        honest = builder(case, work)
        return replace(honest, call=lambda x: change(honest.call(x)))

    return built


@pytest.mark.parametrize("work", ["cycle", "cycle+gradient"])
def test_wrong_way_is_not_timed(monkeypatch: pytest.MonkeyPatch, work: str) -> None:
    def off(result: object) -> object:
        return result * (1 + 1e-9) if isinstance(result, float) else (result[0], -result[1])  # type: ignore[index]

    monkeypatch.setitem(tasks.BUILDERS, "numpy", tampered(build_numpy_contender, off))
    monkeypatch.setattr(tasks, "time_calls", lambda *_: pytest.fail("the clock was started"))
    code, out, err = run(*QUICK, "--work", work, "--way", "numpy", "--way", "casadi-vm", "--json")
    assert code == 1
    answer = json.loads(out)["error"]
    assert answer["name"] == "Disagreement"
    assert answer["message"].startswith(f"{work}: numpy is off casadi-vm by ")
    assert answer["message"] in err


@pytest.mark.parametrize(
    "wrong",
    [1.0 + 1e-9, math.nan, math.inf, (1.0, np.zeros(2)), np.ones(2)],
    ids=["off", "nan", "inf", "more", "shape"],
)
def test_disagreement_threshold(wrong: object) -> None:
    right, other = Contender(lambda x: 1.0, ""), Contender(lambda x: wrong, "")
    with pytest.raises(Disagreement, match="w: b"):
        check_agreement("w", {"a": right, "b": other}, [np.zeros(1)])
    assert (
        check_agreement(
            "w", {"a": right, "b": Contender(lambda x: 1.0 + 1e-11, "")}, [np.zeros(1)]
        )["b"]
        < 2e-11
    )


def test_clock_alternates_and_uses_new_designs() -> None:
    seen: list[tuple[str, int]] = []

    def called(name: str) -> Callable[[int], None]:
        return lambda number: seen.append((name, number))

    times = time_calls(
        {name: called(name) for name in "abc"}, itertools.count(), rounds=3, slot_s=0
    )
    numbers = [number for _, number in seen]
    assert len(set(numbers)) == len(numbers)
    assert [name for name, _ in seen] == [*"abc", *"bca", *"cab"]
    assert all(len(taken.seconds) == 3 for taken in times.values())


def test_slot_has_more_calls_of_faster_ways() -> None:
    times = time_calls(
        {"fast": lambda _: None, "slow": lambda _: sum(range(20_000))}, itertools.count(), 2, 0.002
    )
    assert times["slow"].quartiles().calls < times["fast"].quartiles().calls == 2 * MOST_CALLS


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch, case: BenchmarkCase) -> None:
    for name in ("jax", "sympy"):
        monkeypatch.setitem(__import__("sys").modules, name, None)
    contenders, skipped = tasks.list_contenders("cycle", case, choose_settings(quick=True))
    assert "numpy" in contenders
    reasons = {entry.way: entry.reason for entry in skipped}
    assert reasons["jax"] == "jax is not installed"
    assert reasons["lambdify"] == "sympy is not installed"


def test_missing_compiler_names_skipped_ways(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "")
    contenders, skipped = tasks.list_contenders(
        "cycle",
        BenchmarkCase(),
        choose_settings(quick=True, ways=["casadi-c", "casadi-vm", "lanes"]),
    )
    assert set(contenders) == {"casadi-vm"}
    assert {"casadi-c", "lanes"} <= {entry.way for entry in skipped}


def test_operations_are_counted() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    plain_sum = ca.Function("f", [x, y], [x * y + 3 * x - ca.sqrt(y)], ["x", "y"], ["z"])
    assert count_operations(Kernel(plain_sum, lanes=["x", "y"])) == 5
    assert (
        count_operations(Kernel(plain_sum, lanes=["x"])) == 4
    )  # the root is the same in all lanes
    turned = ca.Function("g", [x], [ca.sin(x) + ca.cos(x)], ["x"], ["z"])
    assert count_operations(Kernel(turned, lanes=["x"])) == 1 + REDUCTION + sum(SERIES.values())


@pytest.mark.skipif(
    not has_compiler() or not shutil.which("objdump"), reason="there is no C compiler or no objdump"
)
@pytest.mark.skipif(
    platform.machine() != "x86_64", reason="machine code of another processor is not counted"
)
def test_only_executed_operations_are_counted() -> None:
    """A product that cancels is in the graph and not in the loop; two sums and two products remain,
    fused or not.
    """
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    expression = x * y + x + y * y
    for function, cancelled in (
        (ca.Function("kept_part", [x, y], [expression], ["x", "y"], ["z"]), 0),
        (
            ca.Function(
                "with_rest", [x, y], [expression + (x * 3.5 + y) - y - x * 3.5], ["x", "y"], ["z"]
            ),
            1,
        ),
    ):
        kernel = Kernel(function, lanes=["x", "y"])
        kernel.compile()
        count = count_executed_operations(backends.build_lane_library(kernel.work), function.name())
        assert count == 4
        assert count_operations(kernel) >= 4 + cancelled
    assert count_executed_operations(Path("no_such_library.so"), "f") is None


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_no_way_beats_the_peak(case: BenchmarkCase) -> None:
    peak = Peak()
    assert peak.vector_width in (128, 256, 512)
    assert peak.operations_per_cycle > 1
    times = time_calls({"lanes": case.turns.value}, case.designs(), 3, 0.01)
    table = peak.table(case, {"cycle": {"lanes": times["lanes"].median_us}})
    assert 0 < table.rates[0].share_of_peak < 1


def test_failing_process_is_an_error() -> None:
    with pytest.raises(ComputationError, match=r"ended with 1: .*nothing like that"):
        _run(workers.python_command("raise ValueError('nothing like that')"))


def test_the_derivation_is_absent_outside_a_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Absent, match="derive cannot be imported"):
        find_checkout()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--work", "lunch"), "--work = lunch"),
        (("--way", "abacus"), "--way = abacus"),
        (("--rounds", "0"), "--rounds = 0"),
    ],
)
def test_bad_options_are_refused(arguments: tuple[str, ...], message: str) -> None:
    code, out, err = run(*arguments, "--json")
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_designs_are_in_the_box_and_reproducible(case: BenchmarkCase) -> None:
    def first(seed: int) -> Iterator[np.ndarray]:
        return itertools.islice(case.designs(seed), 3)

    for x, again, other in zip(first(1), first(1), first(2), strict=True):
        assert np.all((case.device.lower <= x) & (x <= case.device.upper))
        assert np.array_equal(x, again)
        assert not np.array_equal(x, other)


def test_gears_are_drawn_truly_and_who_is_missing_is_named(
    case: BenchmarkCase, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ncgears", None)
    result = tasks.run_task("gears", case, replace(choose_settings(), pairs=1))
    (way,) = result.ways
    assert way.drawn is not None
    assert 0 < way.drawn.deviation_um <= 1
    assert result.skipped == [SkippedWay("ncgears", "ncgears is not installed")]


@pytest.mark.long
def test_gears_are_faster_and_closer_than_ncgears(case: BenchmarkCase) -> None:
    pytest.importorskip("ncgears", reason="ncgears is not installed: pip install 'planter[bench]'")
    timed, other = tasks.run_task("gears", case, replace(choose_settings(), pairs=1)).ways
    assert (timed.way, other.way) == ("planter", "ncgears")
    assert other.ratio > 5
    assert timed.drawn is not None
    assert other.drawn is not None
    assert timed.drawn.vertices < other.drawn.vertices
    assert timed.drawn.deviation_um < other.drawn.deviation_um


def test_user_mechanism_is_timed_if_ways_agree() -> None:
    """Its gradient is that of differences, and the ways that are not there say why."""
    settings = choose_settings(works=["four-bar"], ways=["numpy", "casadi-vm", "lanes"], rounds=1)
    result = tasks.run_task("four-bar", None, settings)
    assert {way.way for way in result.ways} >= {"numpy", "casadi-vm"}
    assert max(way.disagreement for way in result.ways if way.way != "numpy") < 1e-12
    assert {skipped_task.way for skipped_task in result.skipped} >= {"jax", "casadi-c", "lambdify"}
    assert "derived in" in result.unit


def test_benchmark_is_printed_and_written_whole(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    way = WayTimes("lanes", 8467.8, 1.0, DurationQuartiles(8000.0, 9000.0, 12), "compiled", 1e-14)
    gears = WayTimes(
        "planter", 9.512, 1.0, DurationQuartiles(9.0, 10.0, 3), "DXF", drawn=DrawnOutline(720, 0.31)
    )
    basins = BasinSearch("exact", [SeedTimes(1, 1.5, 2.0, 1.25, 0.5, 3, met=True)])
    task_times = [
        TaskTimes("cycle", "us", "lanes", [way], [], [SkippedWay("jax", "not installed")]),
        TaskTimes("optimise", "us", "lanes", [way], [], [], basins),
        TaskTimes("gears", "us", "planter", [gears], [], []),
    ]
    rates = ArithmeticPeak(3.25, 30.0, [ArithmeticRate("cycle", "lanes", 12345, 15.0, 0.5)])
    result = Benchmark(
        task_times,
        BenchmarkMachine("cpu", "x86", 2, "Linux", None),
        {"planter": "1"},
        [],
        512,
        rates,
        "wang2017",
        360,
        1.5,
    )
    write_benchmark(tmp_path, result)
    assert {path.name for path in tmp_path.iterdir()} == {"bench.json", "bench.md", ".planter.json"}
    present_benchmark(result).show(Console(as_json=False))
    printed, markdown = capsys.readouterr().out, (tmp_path / "bench.md").read_text(encoding="utf-8")
    for text in (printed, markdown):
        for value in (
            "8 470",
            "8 000 to 9 000",
            "1.250000",
            "720 vertices",
            "50.0%",
            "jax: skipped",
            "seconds in all: 2",
        ):
            assert value in text
    assert "| cycle | lanes | 12345 | 15.00 | 50.0% |" in markdown
