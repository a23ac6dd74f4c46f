"""`planter simulate` and `planter sensitivity`: the results of a machine's own design, as the interface gives them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from planter.engine.machine import Machine
from planter.engine.sensitivity import SensitivityFound, build_goal
from planter.errors import InputError
from planter.kernels import Array
from planter.mechanism import cycle as mechanism
from planter.mechanism.cycle import Turn
from planter.mechanism.optimisation import compute
from planter.optimise.refined import Panels
from planter.planting import cycle as planting
from planter.planting import lifted, plausible
from planter.planting.designer import summary as designer
from planter.planting.model import Device
from planter.planting.objective import build_measures, weights
from planter.planting.requirements import record as requirements
from planter.planting.results.simulated import (
    At,
    CentreDistances,
    SimulationFound,
    Work,
)
from planter.planting.scores import curve_angles, true_extremes
from planter.records.record import build_frame

if TYPE_CHECKING:
    from pandas import DataFrame

FEWEST_SAMPLES, MOST_SAMPLES = 8, 100_000


@dataclass(frozen=True)
class Simulation:
    """A simulated cycle: its samples (n,) each [in shown units], and the result as `planter simulate --json` has it."""

    cycle: planting.Cycle
    result: SimulationFound
    device: Device

    def show(self) -> Any:
        """A widget of a notebook that shows the device as it moves. Raises InputError where anywidget is missing."""
        return self.device.show()

    def to_frame(self) -> DataFrame:
        """The cycle's columns as a table of pandas, each in the unit [that its name ends in], a row for each sample.

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        return build_frame(self.cycle.columns())

    def _repr_html_(self) -> str:
        from planter.planting.report.force import support_force
        from planter.report import style
        from planter.report.html import inlined

        found, device = self.result, self.device
        at, phi = device.prologue(device.design), curve_angles(device, device.design)
        figure = support_force({found.model: (np.degrees(phi), device.support(at, phi))}, found.weight_N)
        return found._repr_html_() + inlined(
            style.svg(figure), f"turn-{id(self)}", "vertical support force over a turn"
        )


@overload
def simulate(
    device: Device, samples: int | None = None, at_deg: Sequence[float] = (), lift_mm: float | None = None
) -> Simulation: ...


@overload
def simulate(device: Machine, samples: int | None = None, at_deg: Sequence[float] = ()) -> Turn: ...


def simulate(
    device: Device | Machine, samples: int | None = None, at_deg: Sequence[float] = (), lift_mm: float | None = None
) -> Simulation | Turn:
    """A machine's own design over a cycle of `samples` angles, and at single angles of its drive [deg].

    It may be any machine, as `load_mechanism` returns it. With `lift_mm`, the module of its teeth, what each assumption
    of a planting device does is found, too. Raises InputError for a number of samples out of range, for an angle that
    is not finite, and where the printed model's assumptions are to be lifted.
    """
    if isinstance(device, Machine):
        return mechanism.simulate(device, samples, at_deg)
    if lift_mm is not None and device.model != "exact":
        raise InputError("--lift is not allowed with --model printed: assumptions of the exact model can be lifted")
    count = checked_samples(device.machine.objective.samples if samples is None else samples)
    prologue = device.prologue(device.design)
    turn = planting.cycle(device, prologue, planting.angles(count))
    objective = weights(device.machine)
    sampled = planting.statistics(turn.support)
    result = SimulationFound(
        machine=device.machine.name,
        model=device.model,
        samples=count,
        design=device.named(device.design),
        weight_N=planting.weight(device),
        centre_distance_mm=CentreDistances(*map(float, planting.centre_distances(device, prologue) * 1e3)),
        support_force=sampled,
        objective=objective.value(sampled.range_N, sampled.variance_N2),
        warnings=[*plausible.warnings(device.machine), *planting.warnings(device, device.design, turn)],
        refined=true_extremes(device, device.design),
        work=work(device),
        at=at(device, at_deg),
        designer=designer.of(device, device.design),
        requirements=requirements.of(device),
        lifted=None if lift_mm is None else lifted.effects(device, lift_mm),
    )
    return Simulation(turn, result, device)


def checked_samples(samples: int) -> int:
    if not FEWEST_SAMPLES <= samples <= MOST_SAMPLES:
        allowed = f"it must be between {FEWEST_SAMPLES} and {MOST_SAMPLES}"
        raise InputError(f"--samples = {samples} is not allowed: {allowed}")
    return samples


def at(device: Device, angles_deg: Sequence[float]) -> list[At]:
    """Forces and motions at single carrier angles: of side 1, and totals."""
    if not angles_deg:
        return []
    degrees = np.asarray(angles_deg, dtype=float)
    if not np.isfinite(degrees).all():
        raise InputError(f"--at = {degrees[~np.isfinite(degrees)][0]} is not allowed: it must be a finite angle in deg")
    found = planting.cycle(device, device.prologue(device.design), np.radians(degrees))
    columns = {"phi_deg": degrees, **found.sides[0], **found.totals}
    return [At(**{field.name: float(columns[field.name][i]) for field in fields(At)}) for i in range(len(degrees))]


def work(device: Device) -> Work:
    """Work over a turn [J], by quadrature between joints: of the motor, and lost to friction at both cams."""
    panels = Panels(device.force, device.design)
    found = planting.cycle(device, device.prologue(device.design), panels.nodes)
    lost = found.sides[0]["F_E_loss_W"] + found.sides[1]["F_E_loss_W"]
    turn = 2 * np.pi * panels.weights
    return Work(
        input_J=float(turn @ found.totals["M_L_Nm"]),
        friction_J=float(turn @ lost) / device.machine.si("speed_rpm"),
    )


def sensitivity(
    device: Device | Machine, samples: int | None = None, least: str | None = None, all_values: bool = False
) -> SensitivityFound:
    """Return the sensitivity of the objective, or of the sum `least`, over samples.

    It is that in the design, or, with `all_values`, in all numbers of the machine's file. Of any other machine, as
    `load_mechanism` returns it, it is that of true extremes where neither `samples` nor the file say a number.
    """
    if isinstance(device, Machine):
        return compute(device, least, samples, all_values)
    count = checked_samples(device.machine.objective.samples if samples is None else samples)
    return compute(device.force.machine, least, count, all_values)


def objective_gradient(device: Device, samples: int) -> tuple[float, Array]:
    """Objective (31) of the machine's own design and its gradient in x (p,); an extreme's is that of its sample."""
    goal = build_goal(device.force.machine, build_measures(device.machine), samples)
    return goal.evaluate(device.design), goal.slope(device.design)
