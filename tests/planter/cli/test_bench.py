"""The benchmark: nobody is timed who is wrong, and the numbers have their keys."""

import itertools
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from planter.cli import benchmark
from planter.cli.benchmark import TimedCycle
from planter.cli.results import QUICK_WORKS, WORKS
from planter.errors import ComputationError
from planter.kernels import Array
from planter.workers import python_command
from tests.support.cli import answer
from tests.support.lanes import needs_compiler

pytestmark = pytest.mark.usefixtures("kernel_cache")
PLACES = {"cycle": 0, "cycle+gradient": 1}


@pytest.fixture(scope="module")
def cycle() -> TimedCycle:
    return TimedCycle()


@pytest.mark.long
def test_quick_benchmark_has_the_keys_of_the_contract(tmp_path: Path) -> None:
    result = answer("bench", "--quick", "--out", str(tmp_path / "here"))
    assert [task["name"] for task in result["work"]] == list(QUICK_WORKS)
    assert result["skipped"].keys() == set(WORKS) - set(QUICK_WORKS)
    for task in result["work"]:
        medians = {way["way"]: way["median_us"] for way in task["ways"]}
        over = "ipopt" if task["name"] == "optimise" else "lanes"
        for way in task["ways"]:
            assert way["ratio"] == pytest.approx(way["median_us"] / medians[over])
    assert {path.name for path in (tmp_path / "here").iterdir()} >= {"bench.json", "bench.md"}


@needs_compiler
@pytest.mark.parametrize("work", ["cycle", "cycle+gradient", "hessian", "batch"])
def test_ways_agree_with_planter(work: str, cycle: TimedCycle) -> None:
    arrays = ["numpy", "lambdify", *(["jax"] if find_spec("jax") else [])]
    ways = ["lanes", "casadi-vm", *([] if work == "hessian" else arrays)]
    calls = {way: cycle.call(way, work) for way in ways}
    designs = cycle.draw_designs(np.random.default_rng(7), 3)
    benchmark.check_agreement(work, calls, [designs] if work == "batch" else list(designs))


@pytest.mark.parametrize("work", PLACES)
def test_small_error_ends_the_benchmark(work: str, cycle: TimedCycle) -> None:
    call = cycle.call("casadi-vm", work)

    def tampered(x: Array) -> object:
        parts = list(call(x)) if work == "cycle+gradient" else [call(x)]
        parts[-1] = parts[-1] * (1 + 1e-8)
        return tuple(parts)

    designs = list(cycle.draw_designs(np.random.default_rng(1), 2))
    with pytest.raises(ComputationError, match=f"{work.replace('+', '.')}: other is off"):
        benchmark.check_agreement(work, {"casadi-vm": call, "other": tampered}, designs)


def test_ways_take_turns_and_every_input_is_new() -> None:
    seen: list[tuple[str, int]] = []
    calls = {name: lambda x, name=name: seen.append((name, x)) for name in ("a", "b")}
    inputs: Iterator[int] = itertools.count()
    task = benchmark.time_task("cycle", calls, inputs, "b")
    numbers = [number for _, number in seen]
    assert len(set(numbers)) == len(numbers)
    assert [way.calls for way in task.ways] == [benchmark.ROUNDS * benchmark.MOST_CALLS] * 2
    assert task.ways[0].ratio == task.ways[0].median_us / task.ways[1].median_us
    names = [name for name, _ in itertools.groupby(name for name, _ in seen[4:])]
    assert names[:5] == ["a", "b", "a", "b", "a"]


def test_new_process_that_fails_is_named() -> None:
    with pytest.raises(ComputationError, match="ended with 1: ValueError: why"):
        benchmark.run_process(python_command("raise ValueError('why')"))
