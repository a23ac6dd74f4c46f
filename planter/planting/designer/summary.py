"""The designer's summary of a design: what its motor, bearings, gears and cam have to bear over a turn."""

from __future__ import annotations

import math

import numpy as np

from planter.kernels import Array
from planter.numerics.angles import turn_deg
from planter.numerics.extremes import Extreme
from planter.planting.designer import stages
from planter.planting.designer.quantities import CONTACTS, VECTORS
from planter.planting.designer.results import DesignersSummary, MotorTorque, PeakForce, Shock
from planter.planting.designer.turn import DesignTurn
from planter.planting.model import Device

ROUNDING = 1e-9
"""A jump below this share of the largest value over the turn is rounding."""
SAME = 1e-8
"""Events closer than this are one, and told by the first [rad]."""


def of(device: Device, x: Array) -> DesignersSummary:
    """The summary of a design x (p,) of a device: true extremes, one-sided at events, integrals by quadrature."""
    turn = DesignTurn(device, x)
    holding, cam = turn.largest("M_1"), turn.largest("cam")
    found, notes = stages.of(turn)
    return DesignersSummary(
        motor=_motor(turn),
        holding_torque_max_Nm=holding.value,
        holding_torque_max_phi_deg=turn_deg(holding.place),
        forces=[
            *(_force(turn, name, turn.extreme(name, 1), turn.extreme(name, -1)) for name in CONTACTS),
            *(
                _force(turn, name, turn.size(name, 1), turn.size(name, -1))
                for name in VECTORS
                if name in turn.quantities.rows
            ),
        ],
        stages=found,
        cam_pressure_angle_max_deg=math.degrees(cam.value),
        cam_pressure_angle_max_phi_deg=turn_deg(cam.place),
        shocks=_shocks(turn),
        notes=notes,
    )


def _motor(turn: DesignTurn) -> MotorTorque:
    row = turn.quantities.names.index("M_L")
    high, low = (turn.extreme("M_L", sign) for sign in (1, -1))
    return MotorTorque(
        max_Nm=high.value,
        max_phi_deg=turn_deg(high.place),
        min_Nm=low.value,
        min_phi_deg=turn_deg(low.place),
        mean_Nm=float(turn.pieces.mean[row]),
        rms_Nm=float(turn.pieces.rms[row]),
        peak_power_W=max(abs(high.value), abs(low.value)) * turn.device.machine.si("speed_rpm"),
    )


def _force(turn: DesignTurn, name: str, high: Extreme, low: Extreme) -> PeakForce:
    rounding = ROUNDING * max(abs(high.value), abs(low.value))
    return PeakForce(
        name=name,
        meaning=turn.quantities.rows[name].meaning,
        max_N=high.value if abs(high.value) > rounding else 0.0,
        max_phi_deg=turn_deg(high.place),
        min_N=low.value if abs(low.value) > rounding else 0.0,
        min_phi_deg=turn_deg(low.place),
    )


def _shocks(turn: DesignTurn) -> list[Shock]:
    """Jumps that are more than rounding: of accelerations, forces and torques, at the events of both sides."""
    before, after = turn.pieces.sides
    largest = np.abs(turn.pieces.values).max(axis=1)
    found = []
    for k, angle in enumerate(turn.pieces.breaks):
        event = next(one for one in turn.events if abs(one.angle - angle) < SAME)
        for row, (name, entry) in enumerate(turn.quantities.rows.items()):
            if entry.jumps and abs(after[row, k] - before[row, k]) > ROUNDING * largest[row]:
                found.append(
                    Shock(
                        event=event.name, side=event.side, phi_deg=turn_deg(float(angle)), quantity=name,
                        unit=entry.unit, before=float(before[row, k]), after=float(after[row, k]),
                    )
                )  # fmt: skip
    return found
