"""The objective over a turn and its derivatives: against other engines, differences, and across the
ways.
"""

import pickle
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.kernels import Array, CallError, toolchain
from planter.papers.planting import objective
from planter.papers.planting.file import load
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from planter.papers.planting.objective import FIELDS, CycleObjective, read_weights
from tests.support import machines, swapped, xp_complex
from tests.support.lanes import needs_compiler
from tests.support.model import ArrayModel

pytestmark = pytest.mark.usefixtures("kernel_cache")

WAYS = ("lanes", "casadi-c", "casadi-vm")
MACHINES = ("wang2017", "compact", "swapped")
EVEN, ODD = 36, 37


def build_device(name: str, model: Model) -> Device:
    return Device(swapped.machine() if name == "swapped" else load(name), model)


@cache
def turns(name: str, model: Model, way: str, samples: int) -> CycleObjective:
    """Of a device of its own, since a device keeps the ways of its kernels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANTER_KERNELS", way)
        return CycleObjective(build_device(name, model), samples)


def complex_objective(subject: CycleObjective, x: Array) -> complex:
    """The objective by array code on complex numbers; extremes by real parts."""
    device = subject.device
    array, phi = ArrayModel.like(device), 2 * np.pi * np.arange(subject.samples) / subject.samples
    force = np.asarray(
        array(xp_complex, phi + 0j, list(x.astype(complex)), device.constants).totals["F_support"]
    )
    real, objective = force.real, read_weights(device.machine)
    variance = ((force - force.mean()) ** 2).mean()
    spread = variance if objective.kind == "paper" else np.sqrt(variance)
    span = force[real.argmax()] - force[real.argmin()]
    return complex(objective.weight_range * span + objective.weight_variance * spread)


def complex_slopes(subject: CycleObjective, x: Array) -> Array:
    steps = 1e-30j * np.eye(len(x))
    return np.array([complex_objective(subject, x + step).imag / 1e-30 for step in steps])


def draw_designs(device: Device, count: int, seed: int = 5) -> Array:
    rng = np.random.default_rng(seed)
    return np.array([machines.design_near(device, rng) for _ in range(count)])


@pytest.mark.parametrize("samples", [EVEN, ODD])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", ["wang2017", "compact"])
def test_value_and_gradient_against_complex_step(name: str, model: Model, samples: int) -> None:
    """Machine `compact` takes the standard deviation, `wang2017` the variance."""
    subject = turns(name, model, "casadi-vm", samples)
    assert (
        read_weights(subject.device.machine).kind
        == {"wang2017": "paper", "compact": "newton"}[name]
    )
    width = subject.device.upper - subject.device.lower
    for x in draw_designs(subject.device, 2):
        value, gradient = subject.gradient(x)
        expected = complex_slopes(subject, x) * width
        assert value == subject.value(x)
        assert value == pytest.approx(complex_objective(subject, x).real, rel=1e-11)
        assert np.abs(gradient * width - expected).max() <= 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["wang2017", "compact"])
def test_hessian_against_differences_of_the_gradient(name: str) -> None:
    subject = turns(name, "exact", "casadi-vm", EVEN)
    width = subject.device.upper - subject.device.lower
    x = draw_designs(subject.device, 1)[0]
    step = 1e-5 * width
    columns = [
        (subject.gradient(x + h)[1] - subject.gradient(x - h)[1]) / (2 * h.sum())
        for h in np.diag(step)
    ]
    expected = np.array(columns) * np.outer(width, width)
    hessian = subject.hessian(x) * np.outer(width, width)
    assert np.abs(hessian - hessian.T).max() <= 1e-12 * np.abs(hessian).max()
    assert np.abs(hessian - expected).max() <= 1e-6 * np.abs(expected).max()


@needs_compiler
@pytest.mark.parametrize("samples", [EVEN, ODD])
@pytest.mark.parametrize(
    ("name", "model"), [(n, "exact") for n in MACHINES] + [("wang2017", "printed")]
)
def test_all_ways_give_the_same(name: str, model: Model, samples: int) -> None:
    subjects = [turns(name, model, way, samples) for way in WAYS]
    assert [s.way for s in subjects] == list(WAYS)
    device = subjects[-1].device
    width = device.upper - device.lower
    for x in (device.design, *draw_designs(device, 2)):
        *other_results, (value, gradient) = [s.gradient(x) for s in subjects]
        for other, slopes in other_results:
            assert other == pytest.approx(value, rel=1e-12)
            assert (
                np.abs((slopes - gradient) * width).max() <= 1e-11 * np.abs(gradient * width).max()
            )
        for subject in subjects:
            assert subject.value(x) == pytest.approx(value, rel=1e-12)


@needs_compiler
@pytest.mark.parametrize("samples", [EVEN, ODD])
def test_half_a_turn_is_enough_where_both_sides_are_the_same(samples: int) -> None:
    """An odd number of samples has no half: the whole turn is looked at."""
    subject = turns("wang2017", "exact", "lanes", samples)
    angles = 2 * np.pi * np.arange(samples) / samples
    assert len(subject.angles) == (samples // 2 if samples % 2 == 0 else samples)
    device = subject.device
    force = device.support(device.prologue(device.design), angles)
    fields = dict(zip(FIELDS, subject.many(device.design[None])[0], strict=True))
    assert fields["range_N"] == pytest.approx(np.ptp(force), rel=1e-12)
    assert fields["variance_N2"] == pytest.approx(force.var(), rel=1e-12)
    assert fields["mean_N"] == pytest.approx(force.mean(), rel=1e-12)


@needs_compiler
def test_many_designs_are_each_by_itself() -> None:
    fast, slow = (turns("compact", "exact", way, EVEN) for way in ("lanes", "casadi-vm"))
    designs = draw_designs(fast.device, 7)
    rows = fast.many(designs)
    for quick, plain in zip(
        fast.many_gradients(designs), slow.many_gradients(designs), strict=True
    ):
        assert np.abs(quick - plain).max() <= 1e-11 * np.abs(plain).max()
    assert rows.shape == (7, len(FIELDS))
    assert rows == pytest.approx(slow.many(designs), rel=1e-11)
    assert rows[:, 0] == pytest.approx([fast.value(x) for x in designs], rel=1e-15)


@needs_compiler
def test_results_do_not_depend_on_history() -> None:
    """Memory is used again: a gradient after another design's value is that of its own design."""
    subject = turns("wang2017", "exact", "lanes", EVEN)
    first, second = draw_designs(subject.device, 2)
    value, gradient = subject.gradient(first)
    copied = gradient.copy()
    subject.value(second)
    subject.gradient(second)
    assert (gradient == copied).all()
    again, slopes = subject.gradient(first)
    assert (again, slopes.tolist()) == (value, copied.tolist())
    assert subject.copy().gradient(first)[0] == value


@pytest.mark.parametrize("way", [pytest.param("lanes", marks=needs_compiler), "casadi-vm"])
def test_threads_do_not_disturb_each_other(way: str) -> None:
    """Each has its own copy; copies share kernels."""
    subject = turns("wang2017", "exact", way, EVEN)
    designs = draw_designs(subject.device, 60).reshape(4, 15, -1)
    alone = [[subject.gradient(x)[0] for x in part] for part in designs]
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(4) as pool:
        patch.setenv("PLANTER_KERNELS", way)
        copies = [subject.copy() for _ in designs]
        gradients = pool.map(
            lambda objective, part: [objective.gradient(x)[0] for x in part], copies, designs
        )
        assert list(gradients) == alone


@pytest.mark.parametrize("way", [pytest.param("lanes", marks=needs_compiler), "casadi-vm"])
def test_threads_may_share_an_objective(way: str) -> None:
    """Memory is lent to each thread: values, gradients and streams of designs of eight threads are
    their own.
    """
    subject = turns("wang2017", "exact", way, EVEN)
    rounds = 40 if way == "lanes" else 2
    designs = draw_designs(subject.device, 8)

    def run(x: Array) -> list[tuple[float, list[float], float]]:
        results = [(*subject.gradient(x), subject.many(x[None])[0, 0]) for _ in range(rounds)]
        return [(value, gradient.tolist(), other) for value, gradient, other in results]

    alone = [run(x) for x in designs]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(run, designs)) == alone


@needs_compiler
def test_streams_of_designs_on_several_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of one object on threads of their own are the rows that one thread finds; a failure
    names its chunk.
    """
    subject = turns("wang2017", "exact", "lanes", EVEN)
    monkeypatch.setattr(objective, "CHUNK", 3)
    designs = draw_designs(subject.device, 40)
    values = objective.evaluate_many(subject.device, designs, EVEN, threads=4)
    assert np.array(
        [values.objective, values.range_N, values.variance_N2, values.mean_N]
    ).T.tolist() == (subject.many(designs).tolist())
    with_gradients = objective.evaluate_many(
        subject.device, designs, EVEN, threads=4, gradients=True
    )
    assert with_gradients.gradient is not None
    assert with_gradients.objective == pytest.approx(values.objective, rel=1e-12)
    for x, value, gradient in zip(
        designs, with_gradients.objective, with_gradients.gradient, strict=True
    ):
        alone = subject.gradient(x)
        assert (value, gradient.tolist()) == (alone[0], alone[1].tolist())
    designs[22, 0] = np.nan
    for gradients in (False, True):
        with pytest.raises(ComputationError, match="from row 21 on"):
            objective.evaluate_many(subject.device, designs, EVEN, threads=4, gradients=gradients)


@needs_compiler
def test_threads_sharing_memory_are_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case, held in step so that nothing is written at the same time: the other's
    design is found.
    """
    subject = turns("wang2017", "exact", "lanes", EVEN)
    first, second = draw_designs(subject.device, 2)
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


@pytest.mark.parametrize("way", [pytest.param("lanes", marks=needs_compiler), "casadi-vm"])
class TestRefused:
    def test_another_shape(self, way: str) -> None:
        subject = turns("wang2017", "exact", way, EVEN)
        for call in (subject.value, subject.gradient):
            for bad in (subject.device.design[:9], np.zeros((10, 2)), np.float64(1.0)):
                with pytest.raises(CallError, match="shape"):
                    call(bad)

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_non_finite_design_is_refused(self, way: str, bad: float) -> None:
        subject = turns("wang2017", "exact", way, EVEN)
        x = subject.device.design.copy()
        x[3] = bad
        for call in (subject.value, subject.gradient):
            with pytest.raises(CallError, match="finite"):
                call(x)

    def test_a_design_without_a_force(self, way: str) -> None:
        """An eccentricity beyond the radius: the curve has no real radius everywhere."""
        subject = turns("wang2017", "exact", way, EVEN)
        x = subject.device.design.copy()
        x[subject.device.names.index("e3_mm")] = 2 * x[subject.device.names.index("R3_mm")]
        for call in (subject.value, subject.gradient):
            with pytest.raises(ComputationError):
                call(x)


@needs_compiler
def test_successful_run_is_silent(capfd: pytest.CaptureFixture[str]) -> None:
    assert CycleObjective(build_device("wang2017", "exact"), EVEN).way == "lanes"
    assert capfd.readouterr() == ("", "")


def test_missing_compiler_gives_a_single_warning(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setattr(toolchain, "_warnings", [])
    subject = CycleObjective(build_device("wang2017", "exact"), EVEN)
    assert subject.way == "casadi-vm"
    expected = turns("wang2017", "exact", "casadi-vm", EVEN)
    assert subject.gradient(subject.device.design)[0] == expected.gradient(subject.device.design)[0]
    assert len(caplog.records) == 1


def test_pickled_turns_are_those_of_their_machine() -> None:
    """Another machine, model and number of samples than the built-in ones, and data that were
    changed afterwards.
    """
    device = build_device("compact", "printed")
    device.data[device.size :] *= 1.01
    turns = CycleObjective(device, EVEN)
    again = pickle.loads(pickle.dumps(turns))
    assert (again.samples, again.device.model, again.device.machine) == (
        EVEN,
        "printed",
        device.machine,
    )
    assert (
        again.value(device.design)
        == turns.value(device.design)
        != CycleObjective(build_device("compact", "printed"), EVEN).value(device.design)
    )
    alike = device.like(device.machine)
    assert alike.force is not device.force
    assert pickle.loads(pickle.dumps(alike)).named(alike.design) == alike.named(alike.design)
