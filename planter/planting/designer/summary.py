"""The designer's summary of a design: what its motor, bearings, gears and cam have to bear over a turn."""

from __future__ import annotations

import math

from planter.engine.summary import without_rounding
from planter.kernels import Array
from planter.numerics.arrays import to_degrees
from planter.planting.designer import stages
from planter.planting.designer.quantities import CONTACTS
from planter.planting.designer.results import DesignersSummary, PeakForce
from planter.planting.designer.turn import DesignTurn
from planter.planting.model import Device


def of(device: Device, x: Array) -> DesignersSummary:
    """The summary of a design x (p,) of a device: true extremes, one-sided at events, integrals by quadrature."""
    turn = DesignTurn(device, x)
    holding, cam = turn.largest("M_1"), turn.largest("cam")
    found, notes = stages.of(turn)
    return DesignersSummary(
        motor=turn.motor("M_L"),
        holding_torque_max_Nm=holding.value,
        holding_torque_max_phi_deg=to_degrees(holding.place),
        forces=[_force(turn, name) for name in (*CONTACTS, *(vector.name for vector in turn.machine.vectors))],
        stages=found,
        cam_pressure_angle_max_deg=math.degrees(cam.value),
        cam_pressure_angle_max_phi_deg=to_degrees(cam.place),
        shocks=list(turn.shocks()),
        notes=notes,
    )


def _force(turn: DesignTurn, name: str) -> PeakForce:
    high, low = (turn.extreme(name, sign) for sign in (1, -1))
    largest, least = without_rounding(high, low)
    return PeakForce(
        name=name,
        meaning=turn.rows[turn.names.index(name)].quantity.meaning,
        max_N=largest,
        max_phi_deg=to_degrees(high.place),
        min_N=least,
        min_phi_deg=to_degrees(low.place),
    )
