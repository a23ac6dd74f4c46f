"""The objective over samples of a cycle and its derivatives: against array code on complex numbers,
differences, across backends and threads.
"""

import pickle
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from planter import evaluate_many
from planter.engine import outputs
from planter.engine.outputs import CycleObjective
from planter.errors import ComputationError
from planter.kernels import Array, CallError
from planter.papers.planting.file import load
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from tests.support import machines, swapped, xp_complex
from tests.support.lanes import needs_compiler
from tests.support.model import ArrayModel

pytestmark = pytest.mark.usefixtures("kernel_cache")

EVEN, ODD = 36, 37
BACKENDS = [pytest.param("lanes", marks=needs_compiler), "casadi-vm"]


def build_device(name: str, model: Model) -> Device:
    return Device(swapped.machine() if name == "swapped" else load(name), model)


@cache
def build_objective(name: str, model: Model, way: str, samples: int = EVEN) -> CycleObjective:
    """Return the objective of a device of its own, since a device keeps its compiled kernels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANTER_KERNELS", way)
        return CycleObjective(build_device(name, model), samples)


def complex_objective(subject: CycleObjective, x: Array) -> complex:
    """Return the objective by array code on complex numbers; extremes by real parts."""
    device = subject.stated
    assert isinstance(device, Device)
    array, phi = ArrayModel.like(device), 2 * np.pi * np.arange(subject.samples) / subject.samples
    totals = array(xp_complex, phi + 0j, list(x.astype(complex)), device.constants).totals
    force, objective = np.asarray(totals["F_support"]), device.machine.objective
    spread = objective.weighted(((force - force.mean()) ** 2).mean(), np.sqrt)
    span = force[force.real.argmax()] - force[force.real.argmin()]
    return complex(objective.weight_range * span + spread)


def draw_designs(subject: CycleObjective, count: int) -> Array:
    rng = np.random.default_rng(5)
    return np.array([machines.design_near(subject.stated, rng) for _ in range(count)])


@pytest.mark.parametrize("samples", [EVEN, ODD])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", ["wang2017", "compact"])
def test_value_and_gradient_against_complex_step(name: str, model: Model, samples: int) -> None:
    """Machine `compact` takes the standard deviation, `wang2017` the variance."""
    subject = build_objective(name, model, "casadi-vm", samples)
    width = subject.machine.upper - subject.machine.lower
    steps = 1e-30j * np.eye(len(width))
    for x in draw_designs(subject, 2):
        value, gradient = subject.gradient(x)
        expected = np.array([complex_objective(subject, x + h).imag / 1e-30 for h in steps]) * width
        assert value == subject.value(x)
        assert value == pytest.approx(complex_objective(subject, x).real, rel=1e-11)
        assert np.abs(gradient * width - expected).max() <= 1e-9 * np.abs(expected).max()


def test_hessian_against_differences_of_the_gradient() -> None:
    subject = build_objective("compact", "exact", "casadi-vm")
    width = subject.machine.upper - subject.machine.lower
    (x,) = draw_designs(subject, 1)
    columns = [
        (subject.gradient(x + h)[1] - subject.gradient(x - h)[1]) / (2 * h.sum())
        for h in np.diag(1e-5 * width)
    ]
    expected = np.array(columns) * np.outer(width, width)
    hessian = subject.hessian(x) * np.outer(width, width)
    assert np.abs(hessian - expected).max() <= 1e-6 * np.abs(expected).max()


@needs_compiler
@pytest.mark.parametrize(
    ("name", "model", "samples"),
    [("wang2017", "printed", EVEN), ("compact", "exact", ODD), ("swapped", "exact", EVEN)],
)
def test_all_backends_give_the_same(name: str, model: Model, samples: int) -> None:
    ways = ("lanes", "casadi-c", "casadi-vm")
    subjects = [build_objective(name, model, way, samples) for way in ways]
    assert [s.way for s in subjects] == list(ways)
    width = subjects[0].machine.upper - subjects[0].machine.lower
    for x in draw_designs(subjects[0], 2):
        *other_results, (value, gradient) = [s.gradient(x) for s in subjects]
        for other, slopes in other_results:
            assert other == pytest.approx(value, rel=1e-12)
            difference = np.abs((slopes - gradient) * width).max()
            assert difference <= 1e-11 * np.abs(gradient * width).max()
        assert [s.value(x) for s in subjects] == pytest.approx([value] * 3, rel=1e-12)


@needs_compiler
@pytest.mark.parametrize("samples", [EVEN, ODD])
def test_half_a_turn_is_enough_where_both_sides_are_the_same(samples: int) -> None:
    """An odd number of samples has no half: the whole turn is looked at."""
    subject = build_objective("wang2017", "exact", "lanes", samples)
    device = subject.stated
    assert isinstance(device, Device)
    assert len(subject.angles) == (samples // 2 if samples % 2 == 0 else samples)
    angles = 2 * np.pi * np.arange(samples) / samples
    force = device.support(device.prologue(device.design), angles)
    expected = device.machine.objective.value(np.ptp(force), force.var())
    assert subject.value(device.design) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("way", BACKENDS)
def test_results_do_not_depend_on_threads_or_history(way: str) -> None:
    """Memory is lent to each thread and used again: every gradient is that of its own design."""
    subject = build_objective("wang2017", "exact", way)
    rounds, designs = 40 if way == "lanes" else 2, draw_designs(subject, 8)

    def run(x: Array) -> list[tuple[float, list[float]]]:
        results = [subject.gradient(x) for _ in range(rounds)]
        return [(value, gradient.tolist()) for value, gradient in results]

    alone = [run(x) for x in designs]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(run, designs)) == alone


@needs_compiler
def test_threads_sharing_memory_are_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case, held in step so that nothing is written at the same time: the other's
    design is found.
    """
    subject = build_objective("wang2017", "exact", "lanes")
    first, second = draw_designs(subject, 2)
    cycles = subject._slopes
    assert cycles is not None
    expected = subject.gradient(first)[0], subject.gradient(second)[0]

    def evaluate_both() -> tuple[float, float]:
        memory = cycles._lent.memory
        memory.d[: len(first)] = first
        with ThreadPoolExecutor(1) as pool:
            other = pool.submit(subject.gradient, second).result()[0]
        cycles._run(*memory.arguments)
        return float(memory.outputs[0]), other

    assert evaluate_both() == expected
    monkeypatch.setattr(cycles, "_lent", SimpleNamespace(memory=cycles._lent.memory))
    assert evaluate_both() == (expected[1], expected[1])


@needs_compiler
def test_many_designs_are_each_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks on several threads are the rows that one call finds; one without a force has no
    numbers.
    """
    subject = build_objective("wang2017", "exact", "lanes")
    monkeypatch.setattr(outputs, "CHUNK", 70)
    designs = draw_designs(subject, 100)
    designs[22, 0] = np.nan
    batch = evaluate_many(subject.stated, designs, EVEN, threads=4, gradients=True)
    assert batch.gradient is not None
    assert np.flatnonzero(np.isnan(batch.objective)).tolist() == [22]
    for row in (0, 69, 99):
        value, gradient = subject.gradient(designs[row])
        assert batch.objective[row] == pytest.approx(value, rel=1e-12)
        assert batch.gradient[row] == pytest.approx(gradient, rel=1e-9)


@pytest.mark.parametrize("way", BACKENDS)
def test_unusable_designs_are_refused(way: str) -> None:
    """An eccentricity beyond the radius gives a curve that has no real radius everywhere."""
    subject = build_objective("wang2017", "exact", way)
    names, design = subject.machine.design_names, subject.machine.design
    without_force, not_finite = design.copy(), design.copy()
    without_force[names.index("e3_mm")] = 2 * design[names.index("R3_mm")]
    not_finite[3] = np.inf
    for call in (subject.value, subject.gradient):
        for bad in (design[:9], np.zeros((10, 2)), np.float64(1.0)):
            with pytest.raises(CallError, match="shape"):
                call(bad)
        with pytest.raises(CallError, match="finite"):
            call(not_finite)
        with pytest.raises(ComputationError):
            call(without_force)


def test_pickled_objective_is_that_of_its_machine() -> None:
    """Data that were changed after loading are pickled, too."""
    device = build_device("compact", "printed")
    device.data[device.size :] *= 1.01
    objective = CycleObjective(device, EVEN)
    again = pickle.loads(pickle.dumps(objective))
    unchanged = CycleObjective(build_device("compact", "printed"), EVEN)
    assert again.value(device.design) == objective.value(device.design)
    assert again.value(device.design) != unchanged.value(device.design)
