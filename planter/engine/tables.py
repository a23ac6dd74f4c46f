"""Tables of the designer's summary, the sensitivity and the drive, for the terminal and for
pages.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planter.engine.drive import DriveResult
from planter.engine.machine import Machine
from planter.engine.sensitivity import Direction, SensitivityResult
from planter.engine.summary import CycleSummary, MotorTorque, Shock
from planter.files import units
from planter.report.html import KeyFigure, Table
from planter.report.labels import clean_zero

MEANING = "meaning"
"""Column for which a terminal is too narrow."""
Cells = Sequence[str | float | None]
ON_THE_SCREEN = ("N", "N m", "W")
"""Units of the peaks that are shown; results have all."""
WEAK, MOST_COMBINATIONS = 1e-3, 4
"""Least strength and number of the combinations that are shown; results have all."""
ROUNDING = 1e-12
"""Means below this share of the root mean square are shown as zero."""


def summary_tables(summary: CycleSummary) -> Iterator[Table]:
    """Yield the torque of the motor, peaks of forces, torques and powers, and the largest shock of
    each kind.
    """
    if summary.motor is not None:
        rows: list[Cells] = [
            *motor_rows(summary.motor),
            ("peak power / W", summary.motor.peak_power_W, None),
        ]
        yield Table(("", "N m", "phi / deg"), rows, "Torque of the motor on the drive")
    peaks = [peak for peak in summary.peaks if peak.unit in ON_THE_SCREEN]
    if peaks:
        head = ("", "largest", "phi / deg", "least", "phi / deg", "mean", "unit")
        cells = [
            (p.name, p.max, p.max_phi_deg, p.min, p.min_phi_deg, round_mean(p.mean, p.rms), p.unit)
            for p in peaks
        ]
        yield Table(head, cells, "Peaks, true extremes over a cycle")
    yield from shock_tables(summary.shocks, "Shocks: the largest jump of each kind")


def sensitivity_tables(result: SensitivityResult) -> Iterator[Table]:
    """Yield the gradient, then the combinations that matter and the directions that do not."""
    over = "true extremes and integrals" if result.kind == "true" else f"{result.samples} samples"
    rounding = ROUNDING * max(map(abs, result.scaled.values()))
    rows: list[Cells] = [
        (
            name,
            *((value, result.scaled[name]) if abs(result.scaled[name]) > rounding else (0.0, 0.0)),
            _per(name),
        )
        for name, value in result.gradient.items()
    ]
    caption = f"Gradient of the objective over {over}, {result.objective:.6g}"
    yield Table(("parameter", "slope", "times width", "slope's unit"), rows, caption)
    combinations = [part for part in result.combinations if part.strength >= WEAK][
        :MOST_COMBINATIONS
    ]
    cells = [
        (name, *(_short(part.weights.get(name)) for part in combinations))
        for name in result.gradient
        if any(name in part.weights for part in combinations)
    ]
    head = ("parameter", *(f"{part.strength:.3g}" for part in combinations))
    yield Table(
        head, cells, "Combinations that matter, by their strength; weights in parts of widths"
    )


def _per(name: str) -> str:
    """Return the unit of a slope in a value, of the objective's unit."""
    unit = units.display_unit(name)
    return f"1/({unit})" if "/" in unit or " " in unit else f"1/{unit}" if unit else ""


def _short(value: float | None) -> float | None:
    """Return a number to three digits."""
    return None if value is None else float(f"{value:.3g}")


def sensitivity_sentences(result: SensitivityResult) -> Iterator[str]:
    """Yield how many combinations matter, and each direction without effect."""
    return describe_directions(
        result.effective_parameters, len(result.gradient), result.insensitive
    )


def describe_directions(
    effective: int, parameters: int, insensitive: Sequence[Direction]
) -> Iterator[str]:
    """Yield how many combinations of parameters matter, and each direction without effect."""
    yield f"{effective} of {parameters} parameters affect the objective."
    for direction in insensitive:
        text = ", ".join(
            f"{name} {weight:+.3g}" for part in direction for name, weight in part.items()
        )
        yield f"no effect: {text}"


def drive_tables(result: DriveResult) -> Iterator[Table]:
    """Yield motor and flywheel, and the speed over a cycle that repeats itself."""
    motor, speed = result.motor, result.speed
    yield Table(
        ("", "", "unit"),
        [
            ("stall torque", motor.stall_Nm, "N m"),
            ("speed without load", motor.idle_rpm, "r/min"),
            ("flywheel", motor.flywheel_kgm2, "kg m2"),
            ("inertia of the machine at the drive, mean", result.inertia_mean_kgm2, "kg m2"),
            ("inertia of the machine at the drive, largest", result.inertia_max_kgm2, "kg m2"),
            ("work of the motor over a turn", result.motor_work_J, "J"),
            ("work of friction over a turn", result.friction_work_J, "J"),
            ("power that is missing, at most", clean_zero(result.imbalance_W), "W"),
        ],
        "Motor, flywheel and work of a cycle",
    )
    yield Table(
        ("", "", "unit"),
        [
            ("mean", speed.mean_rpm, "r/min"),
            (f"largest, at {speed.max_deg:.4g} deg", speed.max_rpm, "r/min"),
            (f"least, at {speed.min_deg:.4g} deg", speed.min_rpm, "r/min"),
            ("range over mean", speed.fluctuation, "1"),
        ],
        "Speed of the drive over a cycle that repeats itself",
    )


def list_drive_figures(result: DriveResult) -> list[KeyFigure]:
    """Return how much the speed of a drive varies, and its extremes."""
    speed = result.speed
    return [
        KeyFigure(f"{100 * speed.fluctuation:.3g}", "%", "range of the speed over its mean"),
        KeyFigure(f"{speed.max_rpm:.4g}", "r/min", f"largest speed, at {speed.max_deg:.4g} deg"),
        KeyFigure(f"{speed.min_rpm:.4g}", "r/min", f"least speed, at {speed.min_deg:.4g} deg"),
    ]


def driven_quantities(result: DriveResult, machine: Machine) -> Table:
    """Return forces, torques and powers on the motor, and at constant speed, on the page with their
    meanings.
    """
    meanings = {quantity.key: quantity.meaning for quantity in machine.results}
    head = ("", MEANING, "driven, largest", "least", "constant, largest", "least", "change", "unit")
    rows = [
        (
            key.removesuffix(units.unit_suffix(key)),
            meanings[key],
            q.max,
            q.min,
            q.constant_max,
            q.constant_min,
            q.change,
            q.unit,
        )
        for key, q in result.quantities.items()
        if q.unit in ON_THE_SCREEN
    ]
    return Table(
        head,
        rows,
        "Forces, torques and powers, and those at constant mean speed",
        page_columns=(MEANING,),
    )


def motor_rows(motor: MotorTorque) -> list[Cells]:
    """Return extremes and integrals of a motor's torque."""
    return [
        ("largest", motor.max_Nm, motor.max_phi_deg),
        ("least", motor.min_Nm, motor.min_phi_deg),
        ("mean", round_mean(motor.mean_Nm, motor.rms_Nm), None),
        ("root mean square", motor.rms_Nm, None),
    ]


def shock_tables(shocks: Sequence[Shock], caption: str) -> Iterator[Table]:
    """Yield the shocks that are largest, if anything jumps."""
    worst = [
        (s.event, s.phi_deg, s.quantity, s.before, s.after, s.unit) for s in find_worst(shocks)
    ]
    if worst:
        yield Table(("event", "phi / deg", "of", "from", "to", "unit"), worst, caption)


def find_worst(shocks: Sequence[Shock]) -> list[Shock]:
    """Return, of each event of side 1 and each unit, the shock that is largest; other sides have
    the same later.
    """
    worst: dict[tuple[str, str], Shock] = {}
    for shock in shocks:
        last = worst.get((shock.event, shock.unit))
        if shock.side == 1 and (
            last is None or abs(shock.after - shock.before) > abs(last.after - last.before)
        ):
            worst[shock.event, shock.unit] = shock
    return list(worst.values())


def round_mean(mean: float | None, rms: float | None) -> float | None:
    """Return a mean as it is shown: zero where it is rounding."""
    if mean is None or rms is None:
        return None
    return mean if abs(mean) > ROUNDING * rms else 0.0
