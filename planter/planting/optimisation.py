"""`planter optimise`: an optimum with its certificate, and both designs scored in both models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from planter.errors import InputError
from planter.kernels import Array
from planter.optimise import pareto
from planter.optimise.descent import STATIONARY
from planter.optimise.hybrid import Method
from planter.optimise.pareto import Compromise
from planter.optimise.problem import Problem
from planter.optimise.range_and_spread import Sampling
from planter.parallel.task import AUTO, Means
from planter.planting import search
from planter.planting.designer import summary as designer
from planter.planting.functions import MODELS
from planter.planting.model import Device
from planter.planting.objective import problem
from planter.planting.results.optimised import FrontPoint, OptimisationFound, OptimumFound, Scores
from planter.planting.scores import sampled_score, true_extremes
from planter.planting.search import Interrupted, Optimum, Table
from planter.planting.simulation import checked_samples
from planter.progress import Listener
from planter.records.record import build_frame

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True)
class Optimisation:
    """What was found, the models' devices by name, and the result as the interface gives it."""

    found: Optimum
    devices: dict[str, Device]
    result: OptimisationFound
    front: Sequence[Compromise] = ()

    def show(self) -> Any:
        """A widget of a notebook that shows the optimum as it moves, the path of the tip before beneath.

        Raises InputError where anywidget is missing.
        """
        from planter.planting.report.scene import scene
        from planter.view.widget import widget

        device = self.devices[self.result.model]
        return widget(scene(device, self.found.design, device.design))

    def to_frame(self) -> DataFrame:
        """The design before and after as a table of pandas, a row for each parameter, values in the unit [of its name].

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        start, best = self.result.start_design, self.result.design
        return build_frame([{"parameter": name, "start": start[name], "optimum": best[name]} for name in best])

    def _repr_html_(self) -> str:
        return self.result._repr_html_()


def optimise(
    device: Device,
    method: Method = "hybrid",
    samples: str | None = None,
    seed: int = 0,
    starts: int | None = None,
    progress: Listener | None = None,
    keep: Callable[[Table], None] | None = None,
    means: Means = AUTO,
) -> Optimisation:
    """The best design of a device within its bounds; `keep` is handed the best so far as it is found.

    `samples` is "refined", the default, for true extremes and integrals, or a number of angles of a cycle. Raises
    InputError for `samples` that are neither, Interrupted with what was found so far when the user stops the search.
    """
    sampling = sampling_of(samples)
    device = Device(device.machine, device.model)
    device.compile(sampling == "refined")
    found = search.run(device, method, sampling, seed, starts, progress, keep, means=means)
    try:
        return scored(device, found)
    except KeyboardInterrupt:
        raise Interrupted(found, device.scale) from None


def with_front(found: Optimisation, progress: Listener | None = None) -> Optimisation:
    """The same with the front of range and variance: its designs, from least range to least variance."""
    device = found.devices[found.result.model]
    front = pareto.sweep(device.force, found.found.sampling, pareto.FRONT_POINTS, progress)
    points = [
        FrontPoint(one.evaluation.look.range, one.evaluation.look.variance, device.named(one.design)) for one in front
    ]
    return replace(found, front=front, result=replace(found.result, front=points))


def scored(device: Device, found: Optimum) -> Optimisation:
    """An optimum beside the design it started from, and both in both models."""
    sampling, shown = found.sampling, found.shown(device.scale)
    devices: dict[str, Device] = {
        model: device if model == device.model else Device(device.machine, model) for model in MODELS
    }
    tasks = {model: problem(other, sampling) for model, other in devices.items()}
    start = tasks[device.model].reference.look
    result = OptimisationFound(
        machine=device.machine.name,
        model=device.model,
        **vars(shown),
        sampled=sampled_score(device, found.design),
        refined=true_extremes(device, found.design),
        seed=found.seed,
        start_design=device.named(device.design),
        start_range_N=start.range,
        start_variance_N2=start.variance,
        cross={model: _scores(task, found.design) for model, task in tasks.items()},
        statement=statement(start.range, shown, device.size),
        designer=designer.of(device, found.design),
        start_designer=designer.of(device, device.design),
    )
    return Optimisation(found, devices, result)


def statement(start_range_N: float, found: OptimumFound, parameters: int) -> str:
    """What an optimisation came to, in one sentence: the range before and after, how sure, and what holds it."""
    share = 100 * (found.range_N / start_range_N - 1)
    proof = found.certificate
    sure = proof.kkt_residual < STATIONARY and (proof.agreeing_starts > 1 or not proof.starts)
    told = [f"the box binds in {len(proof.active_bounds)} of {parameters}"]
    if proof.active_requirements is not None:
        told.append(f"requirements that bind: {len(proof.active_requirements)}")
    if not sure:
        told.append(f"KKT residual {proof.kkt_residual:.1e}, {proof.agreeing_starts} of {proof.starts} starts agree")
    word = "certified" if sure else "not certified"
    over = "" if found.samples == "refined" else f" over {found.samples} samples"
    return f"range {start_range_N:#.4g} to {found.range_N:#.4g} N{over}, {share:+.1f} %, {word}; {'; '.join(told)}"


def sampling_of(text: str | None) -> Sampling:
    """A number of samples of a cycle, or "refined", the default, for its true extremes and integrals."""
    if text is None or text == "refined":
        return "refined"
    try:
        return checked_samples(int(text))
    except ValueError:
        allowed = "it must be a number of angles or refined"
        raise InputError(f"--samples = {text} is not allowed: {allowed}") from None


def _scores(task: Problem, x: Array) -> Scores:
    """Objective of the machine file's own design and of the optimum x (p,) in one model."""
    return Scores(start=task.reference.objective, optimum=task.score(x).objective)
