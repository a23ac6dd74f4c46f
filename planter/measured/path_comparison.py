"""`planter calibrate --data` without an angle or a time: a measured path laid over that of a machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planter.files.document import Document
from planter.kernels import Array
from planter.measured.calibration import (
    FITS,
    MachineBuilder,
    describe_fit,
    list_warnings,
    rebuild_machine,
    state_determined,
    state_shortfalls,
)
from planter.measured.curve import FRAME, Chosen
from planter.measured.findings import (
    FramePlacement,
    LargestDistance,
    ModelMeasured,
    PathFound,
)
from planter.measured.fit import STARTS, SearchEnd, fit_curve, prepare_searches
from planter.measured.path_curve import PathCurve, PathDistances
from planter.measured.reading import PATH_UNIT, Measurement
from planter.progress import Listener, ProgressPhase
from planter.task import AUTO, Means, Task


@dataclass(frozen=True)
class PathComparison:
    """Distances of measured points from a path, the path as points (2, n) of a cycle [mm], the
    machine file with the fitted inputs, if any, and the result.
    """

    distances: PathDistances
    path: Array
    machine: Document | None
    result: PathFound


def compare_path(
    build: MachineBuilder,
    model: str,
    measured: Measurement,
    bounds: Mapping[str, tuple[float, float]],
    quantities: Sequence[str],
    rebuild: Callable[[Mapping[str, float]], Document] | None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = AUTO,
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> PathComparison:
    """Compare measured points with the path of a point, after a fit of the inputs within `bounds`,
    if there are any.

    The other arguments are those of `planter.measured.calibration.calibrate`, and so are the
    errors.
    """
    machine = build()
    chosen = Chosen.from_bounds(machine, bounds, priors)
    curve = PathCurve(machine, chosen, measured, quantities)
    values, described, fitted, notes = np.zeros(0), None, None, list[str]()
    if bounds:
        phase = ProgressPhase("calibration", "start", STARTS, progress)
        arguments = {"chosen": chosen, "measured": measured, "quantities": quantities}
        task = Task(prepare_path_starts, {"build": build, **arguments})
        fit = fit_curve(curve, seed, STARTS, phase, task, means)
        values, described = fit.values, describe_fit(fit, measured)
        if rebuild is not None:
            fitted, notes = rebuild_machine(fit, rebuild)
    distances, arcs = curve.measure(values), curve.measure_arcs(values)
    angles = np.linspace(0, machine.turn, 1 + 2 * round(np.degrees(machine.turn)))
    largest, placement = _find_largest(distances), _describe_placement(curve, values)
    rms = float(np.sqrt(np.mean(distances.distances**2)))
    assert measured.reading is not None
    result = PathFound(
        machine=machine.name,
        model=model,
        quantity=list(quantities),
        unit=PATH_UNIT,
        statement=_state(rms, largest, placement, described),
        points=len(distances.distances),
        rms_mm=rms,
        mean_mm=float(distances.distances.mean()),
        largest=largest,
        length_mm=float(arcs(machine.turn)),
        placement=placement,
        outcome=None if described is None else described.outcome,
        fitted=[] if described is None else described.fitted,
        fit=described,
        treatment=[*measured.treatment, *notes],
        warnings=[] if described is None else list_warnings(described),
        reading=measured.reading,
    )
    return PathComparison(distances, curve.evaluate(values, angles)[0], fitted, result)


def prepare_path_starts(
    build: MachineBuilder, chosen: Chosen, measured: Measurement, quantities: Sequence[str]
) -> Callable[[Array], SearchEnd]:
    """Return the function that searches from values (n,), in a worker."""
    return prepare_searches(PathCurve(build(), chosen, measured, quantities))


def _find_largest(distances: PathDistances) -> LargestDistance:
    worst = int(np.abs(distances.distances).argmax())
    x, y = distances.points[:, worst]
    return LargestDistance(
        distance_mm=float(distances.distances[worst]),
        point=worst + 1,
        x_mm=float(x),
        y_mm=float(y),
        phi_deg=float(np.degrees(distances.angles[worst])),
        arc_mm=float(distances.arcs[worst]),
    )


def _describe_placement(curve: PathCurve, values: Array) -> FramePlacement:
    rotation, x, y = curve.find_pose(values)
    fitted = [name for name in FRAME if name in curve.chosen.names]
    return FramePlacement(float(np.degrees(rotation)), float(x), float(y), fitted)


def _state(
    rms: float,
    largest: LargestDistance,
    placement: FramePlacement,
    fit: ModelMeasured | None,
) -> str:
    """Return sentences on the distances, on the measured frame, and on the fit, if there is one."""
    sentences = [
        f"RMS distance {rms:.3g} {PATH_UNIT}, largest {largest.distance_mm:.3g} {PATH_UNIT} at "
        f"{largest.phi_deg:.4g}\N{DEGREE SIGN}, {largest.arc_mm:.4g} {PATH_UNIT} along the path"
    ]
    if placement.fitted:
        sentences.append(
            f"The measured frame is placed by the fit ({', '.join(placement.fitted)}): turned by "
            f"{placement.rotation_deg:.4g}\N{DEGREE SIGN}, origin at {placement.x_mm:.4g}, "
            f"{placement.y_mm:.4g} {PATH_UNIT}"
        )
    else:
        sentences.append("The measured frame is that of the machine; nothing of it was fitted")
    if fit is not None:
        sentences.append(FITS[fit.outcome].capitalize())
        sentences += [*state_shortfalls(fit), *state_determined(fit)]
    return ". ".join(sentences)
