"""`planter simulate`, `sensitivity` and `validate` of a planting device, and warnings of
implausible values.

The plausible ranges are the project's own. They are wide: about a tenth to ten times the values of
hand-sized to tractor-drawn transplanters. A value outside is read, but a wrong unit or digit is
likely.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from planter.engine.goal import Goal
from planter.engine.machine import Machine
from planter.engine.sensitivity import SensitivityResult
from planter.errors import InputError
from planter.files import units
from planter.kernels import Array
from planter.measured.sensor_curve import SensorSignal
from planter.mechanism import cycle as mechanism
from planter.mechanism.cycle import MechanismCycle
from planter.mechanism.optimisation import compute_objective_sensitivity, evaluate_limits
from planter.mechanism.results import LimitResult
from planter.optimise.cycle_panels import CyclePanels
from planter.planting import cycle as planting
from planter.planting import lifted
from planter.planting.design_summary import summarise_design
from planter.planting.file import PlantingMachine
from planter.planting.model import Device, build_measures
from planter.planting.objective import evaluate_true_extremes, find_curve_angles, read_weights
from planter.planting.requirements import evaluate_device_requirements
from planter.planting.results import (
    CentreDistances,
    DeviceState,
    PlantingWarning,
    SimulationFound,
    Validation,
    WorkPerCycle,
)
from planter.records.record import build_frame

if TYPE_CHECKING:
    from pandas import DataFrame


class PlausibleRange(NamedTuple):
    """Sizes of a number, without its sign, in the unit that its path ends in; of a list, those of
    each item.
    """

    path: str
    low: float
    high: float
    reason: str


_BODY = "bodies of a planting device weigh from a few grams to some kilograms"
_INERTIA = "that is what bodies of such masses and of some millimetres to decimetres have"
_REACH = "a planting device fits between two rows"
_PUSH = "a spring closes the nozzle against a seedling's weight and inertia"

RANGES = (
    PlausibleRange(
        "operation.speed_rpm",
        2,
        300,
        "transplanters plant some tens of seedlings a minute and side",
    ),
    PlausibleRange("operation.gravity_m_s2", 9.7, 9.9, "it is 9.76 to 9.83 on the ground"),
    PlausibleRange("operation.forward_speed_m_s", 0, 3, "transplanters travel at walking pace"),
    PlausibleRange("contact.pressure_angle_deg", 10, 35, "gears are cut at 14.5 to 30"),
    PlausibleRange("contact.cam_friction_angle_deg", 0, 35, "friction coefficients are below 0.7"),
    PlausibleRange(
        "contact.tooth_friction_angle_deg", 0, 20, "friction coefficients of teeth are below 0.36"
    ),
    PlausibleRange("mass.sun_kg", 0.02, 10, _BODY),
    PlausibleRange("mass.middle_kg", 0.02, 10, _BODY),
    PlausibleRange("mass.planet_kg", 0.05, 20, _BODY),
    PlausibleRange("mass.carrier_kg", 0.1, 50, _BODY),
    PlausibleRange("mass.half_C1_kg", 0.002, 2, _BODY),
    PlausibleRange("mass.half_C2_kg", 0.01, 5, _BODY),
    PlausibleRange("inertia.J56_about_A1_kg_m2", 1e-6, 0.05, _INERTIA),
    PlausibleRange("inertia.J7_about_B1_kg_m2", 1e-5, 0.2, _INERTIA),
    PlausibleRange("inertia.C1_centroidal_xx_yy_zz_kg_m2", 1e-8, 0.01, _INERTIA),
    PlausibleRange("inertia.C2_centroidal_xx_yy_zz_kg_m2", 1e-7, 0.05, _INERTIA),
    PlausibleRange("centroid.sun_radius_mm", 0, 50, "a gear's centroid lies within the gear"),
    PlausibleRange("centroid.middle_radius_mm", 0, 50, "a gear's centroid lies within the gear"),
    PlausibleRange("centroid.planet_xy_mm", 0, 200, _REACH),
    PlausibleRange("nozzle.hinge_A_mm", 0, 300, _REACH),
    PlausibleRange("nozzle.C1_mm", 0, 300, _REACH),
    PlausibleRange("nozzle.C2_mm", 0, 400, _REACH),
    PlausibleRange("nozzle.hook_F_mm", 0, 300, _REACH),
    PlausibleRange(
        "nozzle.tip_distance_mm", 50, 600, "a nozzle reaches over the gears and into the soil"
    ),
    PlausibleRange("cam.rocker_length_mm", 5, 150, _REACH),
    PlausibleRange("cam.base_radius_mm", 5, 150, _REACH),
    PlausibleRange(
        "cam.opening_deg", 2, 60, "a nozzle half opens by some degrees, as wide as a seedling"
    ),
    PlausibleRange("spring.preload_N", 0, 500, _PUSH),
    PlausibleRange("spring.rate_N_m", 0, 20_000, _PUSH),
)


def find_implausible_values(machine: PlantingMachine) -> list[PlantingWarning]:
    """A warning for every value outside its range: what it is, what is usual, and why."""
    numbers = machine.numbers()
    return [
        warning
        for item in RANGES
        for path in _list_paths(item.path, numbers)
        if (warning := _check_value(item, path, numbers[path]))
    ]


def _list_paths(path: str, numbers: dict[str, float]) -> Iterator[str]:
    return (name for name in numbers if name == path or name.startswith(f"{path}["))


def _check_value(item: PlausibleRange, path: str, value: float) -> PlantingWarning | None:
    if item.low <= abs(value) <= item.high:
        return None
    unit = units.display_unit(path)
    usual = f"up to {item.high:g}" if item.low == 0 else f"{item.low:g} to {item.high:g}"
    message = (
        f"{path} = {value:g} {unit} is not what is usual, {usual} {unit}: {item.reason}; is "
        f"the unit right?"
    )
    return PlantingWarning(name="implausible_value", message=message)


FEWEST_SAMPLES, MOST_SAMPLES = 8, 100_000


@dataclass(frozen=True)
class Simulation:
    """A simulated cycle: its samples (n,) each [in shown units], and the result as
    `planter simulate --json` has it.

    `measured` is what the sensor sees, if the file has [measurement].
    """

    cycle: planting.DeviceCycleTable
    result: SimulationFound
    device: Device
    measured: SensorSignal | None = None

    def show(self) -> Any:
        """Return a notebook widget that animates the device.

        Raises InputError if anywidget is missing.
        """
        return self.device.show()

    def to_frame(self) -> DataFrame:
        """The cycle's columns as a table of pandas, each in the unit [that its name ends in], a row
        for each sample.

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        return build_frame(self.columns())

    def columns(self) -> dict[str, Array]:
        """Return columns (n,) of the cycle, and the sensor's signal if the file has one [in the
        units of the keys].
        """
        return {**self.cycle.columns(), **({} if self.measured is None else self.measured.column)}

    def _repr_html_(self) -> str:
        from planter.planting.report.forces import draw_support_force
        from planter.report import style
        from planter.report.html import inline_svg

        result, device = self.result, self.device
        at, phi = device.prologue(device.design), find_curve_angles(device, device.design)
        figure = draw_support_force(
            {result.model: (np.degrees(phi), device.support(at, phi))}, result.weight_N
        )
        return result._repr_html_() + inline_svg(
            style.render_svg(figure), f"turn-{id(self)}", "vertical support force over a turn"
        )


@overload
def simulate(
    device: Device,
    samples: int | None = None,
    at_deg: Sequence[float] = (),
    lift_mm: float | None = None,
) -> Simulation: ...


@overload
def simulate(
    device: Machine, samples: int | None = None, at_deg: Sequence[float] = ()
) -> MechanismCycle: ...


def simulate(
    device: Device | Machine,
    samples: int | None = None,
    at_deg: Sequence[float] = (),
    lift_mm: float | None = None,
) -> Simulation | MechanismCycle:
    """A machine's own design over a cycle of `samples` angles, and at single angles of its drive
    [deg].

    It may be any machine, as `load_mechanism` returns it. With `lift_mm`, the module of its teeth,
    what each assumption of a planting device does is found, too. Raises InputError for a number of
    samples out of range, for an angle that is not finite, and where the printed model's assumptions
    are to be lifted.
    """
    if isinstance(device, Machine):
        return mechanism.simulate_machine(device, samples, at_deg)
    if lift_mm is not None and device.model != "exact":
        raise InputError(
            "--lift needs --model exact: the printed model has no assumptions to relax"
        )
    count = check_samples(device.machine.objective.samples if samples is None else samples)
    prologue = device.prologue(device.design)
    turn = planting.evaluate_cycle(device, prologue, planting.sample_angles(count))
    objective, limits = read_weights(device.machine), evaluate_file_limits(device)
    measured = planting.measure_design(device, device.design, turn)
    refined = evaluate_true_extremes(device, device.design)
    sampled = replace(planting.compute_statistics(turn.support), mean_N=refined.mean_N)
    result = SimulationFound(
        machine=device.machine.name,
        model=device.model,
        samples=count,
        design=device.named(device.design),
        weight_N=planting.compute_weight(device),
        centre_distance_mm=CentreDistances(
            *map(float, planting.find_centre_distances(device, prologue) * 1e3)
        ),
        support_force=sampled,
        objective=objective.value(sampled.range_N, sampled.variance_N2),
        warnings=[
            *find_implausible_values(device.machine),
            *planting.find_cycle_warnings(device, device.design, turn),
        ],
        refined=refined,
        work=compute_work(device),
        at=evaluate_angles(device, at_deg),
        designer=summarise_design(device, device.design),
        requirements=evaluate_device_requirements(device),
        holds=limits,
        met=None if limits is None else all(limit.met for limit in limits),
        lifted=None if lift_mm is None else lifted.find_assumption_effects(device, lift_mm),
        measurement=None if measured is None else measured.result,
    )
    return Simulation(turn, result, device, measured)


def check_samples(samples: int) -> int:
    """Return a number of samples. Raises InputError if it is too small or too large."""
    if not FEWEST_SAMPLES <= samples <= MOST_SAMPLES:
        allowed = f"it must be between {FEWEST_SAMPLES} and {MOST_SAMPLES}"
        raise InputError.for_value("--samples", samples, allowed)
    return samples


def evaluate_angles(device: Device, angles_deg: Sequence[float]) -> list[DeviceState]:
    """Forces and motions at single carrier angles: of side 1, and totals."""
    if not angles_deg:
        return []
    degrees = np.asarray(angles_deg, dtype=float)
    if not np.isfinite(degrees).all():
        raise InputError.for_value(
            "--at", degrees[~np.isfinite(degrees)][0], "it must be a finite angle in deg"
        )
    cycle = planting.evaluate_cycle(device, device.prologue(device.design), np.radians(degrees))
    columns = {"phi_deg": degrees, **cycle.sides[0], **cycle.totals}
    return [
        DeviceState(**{field.name: float(columns[field.name][i]) for field in fields(DeviceState)})
        for i in range(len(degrees))
    ]


def compute_work(device: Device) -> WorkPerCycle:
    """Work over a turn [J], by quadrature between joints: of the motor, and lost to friction at
    both cams.
    """
    panels = CyclePanels(device.force, device.design)
    cycle = planting.evaluate_cycle(device, device.prologue(device.design), panels.nodes)
    lost = cycle.sides[0]["F_E_loss_W"] + cycle.sides[1]["F_E_loss_W"]
    turn = 2 * np.pi * panels.shares
    return WorkPerCycle(
        input_J=float(turn @ cycle.totals["M_L_Nm"]),
        friction_J=float(turn @ lost) / device.machine.si("speed_rpm"),
    )


def sensitivity(
    device: Device | Machine,
    samples: int | None = None,
    least: str | None = None,
    all_values: bool = False,
) -> SensitivityResult:
    """Return the sensitivity of the objective, or of the sum `least`, over samples.

    It is that in the design, or, with `all_values`, in all numbers of the machine's file. Of any
    other machine, as `load_mechanism` returns it, it is that of true extremes where neither
    `samples` nor the file say a number.
    """
    if isinstance(device, Machine):
        return compute_objective_sensitivity(device, least, samples, all_values)
    count = check_samples(device.machine.objective.samples if samples is None else samples)
    return compute_objective_sensitivity(device.force.machine, least, count, all_values)


def compute_objective_gradient(device: Device, samples: int) -> tuple[float, Array]:
    """Objective (31) of the machine's own design and its gradient in x (p,); an extreme's is that
    of its sample.
    """
    goal = Goal(device.force.machine, build_measures(device.machine), (), samples)
    return goal.evaluate(device.design), goal.slope(device.design)


def validate(device: Device) -> Validation:
    """Return requirements and warnings of a machine whose file and gears have passed every
    check.
    """
    machine, limits = device.machine, evaluate_file_limits(device)
    return Validation(
        machine=machine.name,
        valid=True,
        design=list(device.names),
        own_numbers=machine.own_numbers(),
        requirements=evaluate_device_requirements(device),
        holds=limits,
        met=None if limits is None else all(limit.met for limit in limits),
        warnings=find_implausible_values(machine),
    )


def evaluate_file_limits(device: Device) -> list[LimitResult] | None:
    """Return the limits of a device's file on measures with their values at its own design, None if
    it has none.
    """
    return evaluate_limits(device.force.machine) if device.machine.measure_limits else None
