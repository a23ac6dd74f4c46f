"""`planter calibrate`: inputs of a planting device fitted to a paper's reported force, or to
measured data.

For a reported force the flanks of the cam begin where the paper sees the nozzles open and close, by
any of the usual laws; every other input has plausible bounds. Both models are fitted, first with a
cam that only pushes.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from planter import paths
from planter.engine.machine import Machine
from planter.errors import InputError
from planter.jobs import run_in_order
from planter.kernels import Array
from planter.papers.planting import functions
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from planter.papers.planting.objective import evaluate_true_extremes
from planter.papers.planting.plausible import find_implausible_values
from planter.papers.planting.results import (
    CalibrationFound,
    CalibrationTradeoff,
    Distance,
    Fitted,
    ModelFitted,
    OtherModel,
    Statistics,
)
from planter.papers.planting.unpublished_inputs import (
    DEG,
    MET,
    CalibrationForce,
    CalibrationInputs,
    Figures,
    ForceFit,
    compute_flank_angles,
    count_determined,
    fit_from_starts,
    fit_nearest,
    load_calibration_data,
)
from planter.progress import Listener, ProgressPhase
from planter.task import AUTO, Means, Task

SEED = 0
STARTS = {"lanes": 24}
"""Starts of a law's search, where the force runs in machine code; one by one they are the machine's
own and random.
"""
SLOW_STARTS = 7
POLISHED = 2
"""Fits of a law that are drawn to the machine's own values."""
WEIGHTS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Weights of the variance beside the extremes, for the best misses."""
FLANK = "cam.flank"
AT_BOUND = 1e-6


def calibrate(
    machine: PlantingMachine,
    model: Model,
    target: str,
    laws: Sequence[str] = (),
    progress: Listener | None = None,
    means: Means = AUTO,
) -> CalibrationFound:
    """ForceFit the undisclosed inputs of a machine to a target in both models; the result speaks of
    `model` first.

    `laws` are the laws of the cam's flanks to try, by default all; `means` says what fits them,
    with the same results. Raises InputError for a target or a law that there is not.
    """
    figures = _find_target(target)
    for law in laws:
        _check_choice("--flank", law, functions.list_flank_laws())
    flank_laws = tuple(laws) or functions.list_flank_laws()
    jobs = [(fitted_model, law) for fitted_model in MODELS for law in flank_laws]
    phase, laws_fits = (
        ProgressPhase("calibration", "law", len(jobs), progress),
        LawFits(machine, figures),
    )
    points: list[Array] = []
    task = Task(LawFits, {"machine": machine, "figures": dict(figures)})
    for z in run_in_order(
        task, jobs, means, laws_fits, lambda z: z, lambda: phase.report_if_slow(None)
    ):
        phase.advance(", ".join(jobs[len(points)]))
        points.append(z)
    best: dict[Model, ForceFit] = {}
    records: dict[str, ModelFitted] = {}
    for fitted_model in MODELS:
        pairs = [(job, z) for job, z in zip(jobs, points, strict=True) if job[0] == fitted_model]
        fits = [ForceFit(laws_fits.build_force(job), z, figures) for job, z in pairs]
        best[fitted_model] = fit = min(fits, key=lambda fit: fit.rank)
        records[fitted_model] = _describe_fit(
            fit, fitted_model, target, () if fit.met else _search_best_misses(fits)
        )
    own_fit, other = best[model], next(m for m in MODELS if m != model)
    other_device = _build_fitted_device(own_fit, other)
    other_force = Statistics.of_samples(_sample_support(other_device))
    other_mean = evaluate_true_extremes(other_device, other_device.design).mean_N
    device = own_fit.force.device
    return CalibrationFound(
        **vars(records[model]),
        machine=machine.name,
        model=model,
        target=dict(figures),
        events={
            f"{flank}_begins_deg": angle / DEG
            for flank, angle in compute_flank_angles(device).items()
        },
        other_model=OtherModel(other_force.range_N, other_force.variance_N2, other_mean),
        models=records,
    )


def with_flank(machine: PlantingMachine, law: str) -> PlantingMachine:
    """A machine with another law of its cam's flanks."""
    table = machine.table()
    return PlantingMachine.read(
        {**table, "cam": {**table["cam"], "flank": law}}, machine.source, changed=machine.changed
    )


def _find_target(name: str) -> Figures:
    targets: dict[str, Figures] = load_calibration_data()["target"]
    _check_choice("--target", name, targets)
    return targets[name]


def _check_choice(option: str, name: str, allowed: Collection[str]) -> None:
    if name not in allowed:
        raise InputError.for_value(option, name, paths.suggest_names(name, allowed))


class LawFits:
    """Best fits by model and law of the cam's flanks: the jobs of a worker."""

    def __init__(self, machine: PlantingMachine, figures: Figures) -> None:
        self._machine, self._figures = machine, figures
        self._forces: dict[tuple[Model, str], CalibrationForce] = {}

    def build_force(self, job: tuple[Model, str]) -> CalibrationForce:
        """Return the force of a model with a law."""
        if job not in self._forces:
            model, law = job
            device = Device(with_flank(self._machine, law), model)
            self._forces[job] = CalibrationForce(device, CalibrationInputs.with_events(device))
        return self._forces[job]

    def __call__(self, job: tuple[Model, str]) -> Array:
        """Return the point (n,) of the best fit."""
        return _search_best_fit(self.build_force(job), self._figures).z


def _search_best_fit(force: CalibrationForce, figures: Figures) -> ForceFit:
    """Return the fit with a cam that only pushes if it meets the target, otherwise with one that
    may pull.
    """
    equal = np.ones(len(figures))
    candidates: list[ForceFit] = []
    for pushing in (True, False):
        fits = sorted(
            fit_from_starts(force, figures, pushing, _draw_starts(force), equal),
            key=lambda fit: fit.rank,
        )
        candidates += [fit_nearest(fit, pushing) if fit.met else fit for fit in fits[:POLISHED]]
        if any(fit.met for fit in candidates):
            break
    return min(candidates, key=lambda fit: fit.rank)


def _draw_starts(force: CalibrationForce) -> list[Array]:
    rng = np.random.default_rng(SEED)
    count = STARTS.get(force.way, SLOW_STARTS)
    return [force.file_point(), *(rng.random(len(force.inputs)) for _ in range(count - 1))]


def _search_best_misses(fits: Sequence[ForceFit]) -> list[CalibrationTradeoff]:
    """The best misses of the two best laws, from extremes alone to variance alone; those that
    others beat left out.
    """
    fits = [
        candidate
        for fit in sorted(fits, key=lambda fit: fit.worst)[:2]
        for weight in WEIGHTS
        for candidate in fit_from_starts(
            fit.force, fit.target, True, [fit.z], np.array([1.0, 1.0, weight])
        )
    ]
    pushing = [fit for fit in fits if fit.pushes]
    undominated = [fit for fit in pushing if not any(_dominates(other, fit) for other in pushing)]
    return [
        CalibrationTradeoff(
            _list_choices(fit),
            fit.curve.figures(),
            fit.curve.range,
            {k: 100 * v for k, v in fit.misses.items()},
        )
        for fit in sorted(undominated, key=lambda fit: abs(fit.misses["variance_N2"]))
    ]


def _dominates(fit: ForceFit, other: ForceFit) -> bool:
    misses, other_misses = (np.abs(list(each.misses.values())) for each in (fit, other))
    return bool((misses <= other_misses).all() and (misses < other_misses).any())


def _list_choices(fit: ForceFit) -> dict[str, str]:
    return {FLANK: fit.force.device.machine.cam.flank}


def _describe_fit(
    fit: ForceFit, model: Model, target: str, front: Sequence[CalibrationTradeoff]
) -> ModelFitted:
    return ModelFitted(
        met=fit.met,
        statement=_state_result(fit, model, target),
        choices=_list_choices(fit),
        fitted=[Fitted(**row) for row in fit.force.inputs.table(fit.z)],
        reached=fit.curve.figures(),
        miss_percent={key: 100 * miss for key, miss in fit.misses.items()},
        cam_pushes=fit.pushes,
        least_push_N=float(fit.curve.push.min()),
        distance=_measure_distance(fit),
        rank=count_determined(fit),
        front=list(front) or None,
    )


def _state_result(fit: ForceFit, model: Model, target: str) -> str:
    """Whether a target is met, how, and how far from the machine's own inputs."""
    contact = "a cam that only pushes" if fit.pushes else "a cam that would have to pull"
    if fit.met:
        return (
            f"The target {target} is met by the {model} model, every number of it within "
            f"{100 * MET:g} %, with "
            f"{contact} and {_list_choices(fit)[FLANK]} flanks; the inputs lie {fit.distance:.2g} "
            f"widths of their "
            "bounds (root mean square) from the machine's own."
        )
    misses = ", ".join(
        f"{key} by {100 * miss:+.1f} %" for key, miss in fit.misses.items() if abs(miss) > MET
    )
    return (
        f"The target {target} is missed by the {model} model: {misses}, with {contact}. No values "
        f"within the "
        "bounds that were tried come nearer."
    )


def _measure_distance(fit: ForceFit) -> Distance:
    on = [p for p, z in zip(fit.force.inputs.paths, fit.z, strict=True) if min(z, 1 - z) < AT_BOUND]
    unusual = [warned.message for warned in find_implausible_values(fitted_machine(fit))]
    return Distance(fit.distance, on, unusual)


def fitted_machine(fit: ForceFit) -> PlantingMachine:
    """The machine with the fitted inputs."""
    rows = fit.force.inputs.table(fit.z)
    return fit.force.device.machine.with_numbers({row["name"]: row["value"] for row in rows})


def _build_fitted_device(fit: ForceFit, model: Model) -> Device:
    """The fitted machine in a model."""
    return Device(fitted_machine(fit), model)


def _sample_support(device: Device) -> Array:
    at = device.prologue(device.design)
    return device.support(at, device.engine.list_angles())


def build_engine_machine(machine: PlantingMachine, model: Model) -> Machine:
    """Return the machine of a device in a model."""
    return Device(machine, model).engine
