"""The planting device over a cycle: its quantities, samples of them, statistics and warnings, in
either model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.engine.response import DesignPoint
from planter.files import units
from planter.kernels import Array
from planter.measured.sensor_curve import SensorSignal, measure_cycle
from planter.numerics.extrema import index_first_extremum
from planter.planting.model import Device
from planter.planting.results import PlantingWarning, Statistics


@dataclass(frozen=True)
class DeviceQuantity:
    """A quantity of side 1, of side 2, half a turn behind, or, with side 0, of both together.

    `name` is a plain word, that of the equations, on side 2 with `_2` behind it; `unit` its SI
    unit; `key` its key in tables, which ends in the unit there.
    """

    name: str
    unit: str
    key: str
    meaning: str
    source: str
    side: int


def list_device_quantities(sidecar: Mapping[str, Any]) -> list[DeviceQuantity]:
    """Return the columns of side 1, of side 2, and of both, in the order of `Device.cycle`."""
    vectors = sidecar["vectors"]
    return [
        *_build_quantities(vectors["side"], 1),
        *_build_quantities(vectors["side"], 2),
        *_build_quantities(vectors["totals"], 0),
    ]


def list_keys(entries: Sequence[Mapping[str, str]]) -> list[str]:
    """Keys of a vector's entries in tables, each ending in the unit that is shown."""
    return [
        entry.get("shown") or units.display_key(entry["name"], entry["unit"]) for entry in entries
    ]


def name_second_side(key: str) -> str:
    """The key of a quantity on side 2.

    >>> name_second_side("F_B1x_N"), name_second_side("ratio")
    ('F_B1x_2_N', 'ratio_2')
    """
    suffix = units.unit_suffix(key)
    return f"{key.removesuffix(suffix)}_2{suffix}"


def _build_quantities(entries: Sequence[Mapping[str, str]], side: int) -> Iterator[DeviceQuantity]:
    for entry, key in zip(entries, list_keys(entries), strict=True):
        if side == 2:
            yield DeviceQuantity(
                f"{entry['name']}_2",
                entry["unit"],
                name_second_side(key),
                entry["meaning"],
                entry["source"],
                side,
            )
        else:
            yield DeviceQuantity(
                entry["name"], entry["unit"], key, entry["meaning"], entry["source"], side
            )


Columns = dict[str, Array]


@dataclass(frozen=True)
class DeviceCycleTable:
    """Quantities at carrier angles `phi` [rad], each (n,), under the keys they are shown with, in
    shown units.

    `sides` are those of side 1 and of side 2, half a turn behind; `totals` those of what both
    share.
    """

    phi: Array
    sides: tuple[Columns, Columns]
    totals: Columns

    @property
    def support(self) -> Array:
        """Vertical support force [N], (n,)."""
        return self.totals["support_N"]

    def columns(self) -> Columns:
        """Return all columns: the angle, side 1, side 2 with `_2` in the names, totals."""
        second = {name_second_side(key): values for key, values in self.sides[1].items()}
        return {"phi_deg": np.degrees(self.phi), **self.sides[0], **second, **self.totals}


def evaluate_cycle(device: Device, at: DesignPoint, phi: Array) -> DeviceCycleTable:
    """All forces and motions at carrier angles (n,) [rad]."""
    outputs = device.cycle(at, phi)
    vectors = device.sidecar["vectors"]
    first, second = (
        _to_display_columns(vectors["side"], outputs[name]) for name in ("side1", "side2")
    )
    return DeviceCycleTable(
        np.asarray(phi, dtype=float),
        (first, second),
        _to_display_columns(vectors["totals"], outputs["totals"]),
    )


def _to_display_columns(entries: Sequence[Mapping[str, str]], rows: Array) -> Columns:
    return {
        key: row / units.unit_factor(key) for key, row in zip(list_keys(entries), rows, strict=True)
    }


def sample_angles(samples: int) -> Array:
    """Carrier angles of a cycle's samples [rad]: 2 pi i / N."""
    return 2 * np.pi * np.arange(samples) / samples


def name_over_samples(name: str, samples: int) -> str:
    """Return the name of a number computed from samples of a cycle, not exactly."""
    return f"{name}, {samples} samples"


def compute_statistics(force: Array) -> Statistics:
    """Extremes, range, mean and population variance of samples (n,) of a force [N]."""
    high, low = float(force.max()), float(force.min())
    return Statistics(high, low, high - low, float(force.mean()), float(force.var()))


def find_centre_distances(device: Device, at: DesignPoint) -> Array:
    """Centre distances of both stages [m], (2,)."""
    return at.h[find_distance_indices(device)]


def find_distance_indices(device: Device) -> list[int]:
    """Return the indices of the centre distances of both stages in the prologue."""
    return [0, 1 + device.stages[0].terms]


def compute_weight(device: Device) -> float:
    """Weight of everything that the frame carries [N]."""
    return device.formulas.at("weight", machine=device.constants)["weight"]


ONE_SIDED = {
    "F_E_N": ("roller_contact", "the cam would have to pull the roller"),
    "F_NP_N": ("tooth_contact_P", "the teeth of sun and gear 5 would have to pull"),
    "F_NQ_N": ("tooth_contact_Q", "the teeth of gear 6 and planet would have to pull"),
}
"""Contacts that can only push, by the key of their force."""


def find_cycle_warnings(device: Device, x: Array, turn: DeviceCycleTable) -> list[PlantingWarning]:
    """Lost contacts over the cycle and values outside the machine's bounds."""
    warnings = [
        _describe_lost_contact(turn, key, name, text)
        for key, (name, text) in ONE_SIDED.items()
        if turn.sides[0][key].min() < 0
    ]
    low, high = device.lower / device.scale, device.upper / device.scale
    for name, value, a, b in zip(device.names, x / device.scale, low, high, strict=True):
        if not a <= value <= b:
            warnings.append(
                PlantingWarning(
                    name="design_out_of_bounds",
                    phi_deg=0.0,
                    message=f"{name} = {value:.6g} lies outside its bounds [{a:g}, {b:g}]",
                )
            )
    return warnings


def _describe_lost_contact(
    turn: DeviceCycleTable, key: str, name: str, text: str
) -> PlantingWarning:
    force = turn.sides[0][key]
    pulled = force < 0
    worst = index_first_extremum(turn.phi, force, -1)
    share = 100 * pulled.mean()
    message = (
        f"{text}: by up to {-force[worst]:.3g} N on side 1, over {share:.0f} % of the turn; "
        f"side 2 half a turn later"
    )
    return PlantingWarning(name=name, phi_deg=float(np.degrees(turn.phi[worst])), message=message)


def measure_design(device: Device, x: Array, turn: DeviceCycleTable) -> SensorSignal | None:
    """Return what the sensor of the file sees over a turn of a design x (p,) [SI], None if the file
    states none.
    """
    if device.machine.measurement is None:
        return None
    machine = device.force.machine
    return measure_cycle(machine.with_data(machine.build_data(x)), turn.phi, turn.columns())
