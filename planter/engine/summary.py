"""What a designer reads off a cycle: true peaks with their angles, means, and jumps where a law
changes.

A cycle is split at its breakpoints; between them quantities are smooth, so that extremes are
roots of exact derivatives and integrals are right to rounding (`planter.numerics.piecewise`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.engine.curves import QuantityCurves
from planter.engine.machine import Machine, Quantity, Vector
from planter.engine.response import MachineResponse
from planter.engine.solvers.response import list_breakpoints
from planter.files import units
from planter.files.record import Record
from planter.kernels import Array
from planter.numerics.arrays import TURN, to_degrees
from planter.numerics.extrema import ExtremePoint
from planter.numerics.piecewise import PiecewiseFunctions
from planter.progress import name_step

ROUNDING = 1e-9
"""A jump or a peak below this share of the largest value over the cycle is rounding."""
SAME_ANGLE = 1e-8
"""Events closer than this are one, named by the first [rad]."""
REPEATS = 1e-7
"""Share of the largest value by which a quantity may miss after a cycle what it was at its
beginning.
"""


@dataclass(frozen=True)
class MotorTorque(Record):
    """Torque of the motor on the drive over a cycle: true extremes with their angles, integrals,
    power.
    """

    max_Nm: float
    max_phi_deg: float
    min_Nm: float
    min_phi_deg: float
    mean_Nm: float | None
    rms_Nm: float | None
    peak_power_W: float


@dataclass(frozen=True)
class QuantityPeak(Record):
    """True extremes of a quantity, or of the size of a vector, in `unit`, with their angles;
    one-sided where it jumps.

    Mean and root mean square are null if the quantity does not end the cycle as it began it.
    """

    name: str
    meaning: str
    unit: str
    max: float
    max_phi_deg: float
    min: float
    min_phi_deg: float
    mean: float | None
    rms: float | None


@dataclass(frozen=True)
class Shock(Record):
    """A finite jump over a turn: the event of a side, the quantity with its unit, its values just
    before and after.
    """

    event: str
    side: int
    phi_deg: float
    quantity: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True)
class CycleSummary(Record):
    """Design loads of a machine; `motor` is null unless a single motor turns the drive.

    `peaks` are those of all quantities and of sizes of vectors; `shocks` is empty where nothing
    jumps.
    """

    motor: MotorTorque | None
    peaks: list[QuantityPeak]
    shocks: list[Shock]


@dataclass(frozen=True)
class CycleRow:
    """A function of the angle by its graph in the machine's symbols, and whether its extremes or
    its jumps count.

    The graph of the size of a vector is that of its square (`is_square`).
    """

    quantity: Quantity
    graph: ca.SX
    has_peaks: bool = True
    has_jumps: bool = True
    is_square: bool = False


def build_rows(machine: Machine) -> list[CycleRow]:
    """Return the results of a machine, then the sizes of its vectors."""
    rows = [CycleRow(quantity, machine.graph(quantity.name)) for quantity in machine.results]
    return rows + [build_vector_row(machine, vector) for vector in machine.vectors]


def build_vector_row(machine: Machine, vector: Vector) -> CycleRow:
    """Return the size of a vector."""
    unit = machine.find_quantity(vector.components[0]).unit
    square = ca.sumsqr(ca.vertcat(*map(machine.graph, vector.components)))
    size = Quantity(vector.name, unit, vector.meaning, units.display_key(vector.name, unit))
    return CycleRow(size, square, has_jumps=False, is_square=True)


class PiecewiseCycle:
    """Rows of a machine over a cycle at a design x (p,), its own if none is given; in SI."""

    def __init__(self, machine: Machine, rows: Sequence[CycleRow], x: Array | None = None) -> None:
        self.machine, self.rows = machine, tuple(rows)
        self.names = tuple(row.quantity.name for row in rows)
        self._squares = np.array([row.is_square for row in rows])
        graphs = [(row.quantity, row.graph) for row in rows]
        response = MachineResponse(machine, (), more=graphs)
        self.point = response.at(machine.design if x is None else x)
        squares = [graph for graph, row in zip(graphs, rows, strict=True) if row.is_square]
        curves = QuantityCurves(machine, (), squares=squares)
        self.breakpoints = list_breakpoints(curves, self.point)
        breaks = np.array([place.angle for place in self.breakpoints])
        self.pieces = PiecewiseFunctions(
            lambda phi: self._take_roots(*response.derivatives(self.point, phi, is_loose=True)),
            breaks,
            machine.turn,
        )

    def _take_roots(self, values: Array, slopes: Array) -> tuple[Array, Array]:
        """Return rows and their slopes, of a square those of its root."""
        squares = self._squares
        sizes = np.sqrt(np.maximum(values[squares], 0.0))
        values[squares] = sizes
        slopes[squares] = np.divide(
            slopes[squares], 2 * sizes, out=np.zeros_like(sizes), where=sizes > 0
        )
        return values, slopes

    @cached_property
    def _extremes(self) -> dict[str, tuple[ExtremePoint, ExtremePoint]]:
        chosen = [
            index
            for index, row in enumerate(self.rows)
            if row.has_peaks and index not in self.pieces.poles
        ]
        response = MachineResponse(
            self.machine,
            (),
            more=[(self.rows[index].quantity, self.rows[index].graph) for index in chosen],
        )
        extremes = self.pieces.extremes(
            np.array(chosen), lambda phi: response.rates(self.point, phi, is_loose=True)
        )
        return {self.names[index]: both for index, both in zip(chosen, extremes, strict=True)}

    def extreme(self, name: str, sign: int) -> ExtremePoint:
        """Return the largest (+1) or least (-1) value of a row."""
        return self._extremes[name][sign > 0]

    def find_pole(self, name: str) -> float | None:
        """Return an angle at which a row has a pole, or is not finite [rad]: it has no true
        extremes or means.
        """
        return self.pieces.poles.get(self.names.index(name))

    def angle_deg(self, name: str, extreme: ExtremePoint) -> float:
        """Return where a row has an extreme, in [0, 360), or at the end of a turn that does not end
        as it began.
        """
        first, last = (side[self.names.index(name)] for side in self.pieces.ends)
        at_end = extreme.place >= self.machine.turn * (1 - SAME_ANGLE)
        if at_end and abs(last - first) > REPEATS * self.largest(name).value:
            return float(np.degrees(self.machine.turn))
        return to_degrees(extreme.place)

    def largest(self, name: str) -> ExtremePoint:
        """Return the size of the value of a row that is largest in size."""
        extreme = max(
            (self.extreme(name, sign) for sign in (1, -1)), key=lambda side: abs(side.value)
        )
        return ExtremePoint(extreme.place, abs(extreme.value))

    def motor(self, name: str, repeats: bool = True) -> MotorTorque:
        """Return what a torque on the drive asks of its motor."""
        row, speed = self.names.index(name), float(self.point.d[self.machine.speed])
        high, low = (self.extreme(name, sign) for sign in (1, -1))
        return MotorTorque(
            max_Nm=high.value,
            max_phi_deg=to_degrees(high.place),
            min_Nm=low.value,
            min_phi_deg=to_degrees(low.place),
            mean_Nm=float(self.pieces.mean[row]) if repeats else None,
            rms_Nm=float(self.pieces.rms[row]) if repeats else None,
            peak_power_W=max(abs(high.value), abs(low.value)) * abs(speed),
        )

    def shocks(self) -> Iterator[Shock]:
        """Yield the jumps that are more than rounding, in SI."""
        before, after = self.pieces.sides
        largest = np.abs(self.pieces.values).max(axis=1)
        for k, angle in enumerate(self.pieces.breaks):
            places = (p for p in self.breakpoints if abs(p.angle - angle) < SAME_ANGLE)
            place = next((p for p in places if not p.is_touch), None)
            if place is None:
                continue
            for row, entry in enumerate(self.rows):
                change = after[row, k] - before[row, k]
                if entry.quantity.unit == "rad":  # an angle that begins anew does not jump
                    change -= TURN * np.round(change / TURN)
                has_jump = entry.has_jumps and row not in self.pieces.poles
                if has_jump and abs(change) > ROUNDING * largest[row]:
                    yield Shock(
                        event=place.name,
                        side=place.side,
                        phi_deg=to_degrees(float(angle)),
                        quantity=entry.quantity.name,
                        unit=entry.quantity.unit,
                        before=float(before[row, k]),
                        after=float(after[row, k]),
                    )


def without_rounding(high: ExtremePoint, low: ExtremePoint) -> tuple[float, float]:
    """Return the values of two extremes, zero where one is rounding of the other."""
    rounding = ROUNDING * max(abs(high.value), abs(low.value))
    first, second = (
        extreme.value if abs(extreme.value) > rounding else 0.0 for extreme in (high, low)
    )
    return first, second


@name_step("finding true extremes, means and shocks of all quantities")
def summarise(cycle: PiecewiseCycle, changing: Collection[str] = ()) -> CycleSummary:
    """Return the designer's summary of a cycle, in display units, of what has no pole.

    `changing` are the keys of quantities that do not repeat after a cycle, which have no mean.
    Raises ComputationError where loops do not close.
    """
    machine = cycle.machine
    rows = [
        row for row in cycle.rows if row.quantity.key and cycle.find_pole(row.quantity.name) is None
    ]  # what has no key is no result, but may jump
    factors = {row.quantity.name: row.quantity.factor for row in cycle.rows}
    display_units = {
        row.quantity.name: units.display_unit(row.quantity.key)
        if row.quantity.key
        else row.quantity.unit
        for row in cycle.rows
    }
    motors = [
        name
        for name in machine.motors
        if cycle.find_pole(name) is None and _turns_the_drive(cycle, name)
    ]
    motor = None
    if len(motors) == 1:
        motor = cycle.motor(motors[0], repeats=machine.find_quantity(motors[0]).key not in changing)
    return CycleSummary(
        motor=motor,
        peaks=[_peak(cycle, row, is_changing(machine, row, changing)) for row in rows],
        shocks=[
            Shock(
                shock.event,
                shock.side,
                shock.phi_deg,
                shock.quantity,
                display_units[shock.quantity],
                shock.before / factors[shock.quantity],
                shock.after / factors[shock.quantity],
            )
            for shock in cycle.shocks()
        ],
    )


def summarise_machine(machine: Machine, changing: Collection[str] = ()) -> CycleSummary:
    """Return the designer's summary of a machine's own design, as `summarise`."""
    return summarise(PiecewiseCycle(machine, build_rows(machine)), changing)


def _turns_the_drive(cycle: PiecewiseCycle, name: str) -> bool:
    """Return whether the power of a motor is its torque times the drive's speed."""
    if f"P_{name}" not in cycle.names:
        return True
    torque, power = (cycle.pieces.values[cycle.names.index(key)] for key in (name, f"P_{name}"))
    speed = float(cycle.point.d[cycle.machine.speed])
    return bool(
        np.abs(power - torque * speed).max()
        <= ROUNDING * max(float(np.abs(power).max()), np.finfo(float).tiny)
    )


def is_changing(machine: Machine, row: CycleRow, changing: Collection[str]) -> bool:
    """Return whether a row is, or is made of, a quantity that does not repeat."""
    parts = next(
        (v.components for v in machine.vectors if v.name == row.quantity.name), (row.quantity.name,)
    )
    return any(machine.find_quantity(part).key in changing for part in parts)


def _peak(cycle: PiecewiseCycle, row: CycleRow, is_changing: bool) -> QuantityPeak:
    quantity, index = row.quantity, cycle.names.index(row.quantity.name)
    high, low = (cycle.extreme(quantity.name, sign) for sign in (1, -1))
    largest, smallest = without_rounding(high, low)
    mean, rms, factor = (
        float(cycle.pieces.mean[index]),
        float(cycle.pieces.rms[index]),
        quantity.factor,
    )
    return QuantityPeak(
        name=quantity.name,
        meaning=quantity.meaning,
        unit=units.display_unit(quantity.key),
        max=largest / factor,
        max_phi_deg=cycle.angle_deg(quantity.name, high),
        min=smallest / factor,
        min_phi_deg=cycle.angle_deg(quantity.name, low),
        mean=None if is_changing else mean / factor,
        rms=None if is_changing else rms / factor,
    )
