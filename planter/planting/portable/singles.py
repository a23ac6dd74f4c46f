"""Single numbers of a planting device's turn, as expressions in its rows: of its drawing, and its readings."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial

import casadi as ca
import numpy as np

from planter.planting import cycle
from planter.planting.model import Device
from planter.planting.objective import read_weights
from planter.planting.portable.rows import TOLD, Rows, place

Named = Mapping[str, ca.MX]
INPUTS = ("x", "c", "h", "rows", "told")


class Singles:
    """Numbers of the design, the data and the prologue, and of rows side by side: `inputs`, in the order of INPUTS."""

    def __init__(self, rows: Rows, moments: int) -> None:
        self.rows, self.device = rows, rows.device
        samples = self.device.machine.objective.samples
        sizes = [symbol.shape for symbol in rows.inputs[1:]]
        sizes += [(moments, len(rows.drawn)), (samples, len(TOLD))]
        self.inputs = [ca.MX.sym(name, *size) for name, size in zip(INPUTS, sizes, strict=True)]

    @cached_property
    def all(self) -> Named:
        """All of them by name."""
        return {**self._drawn(), **self._read()}

    def _drawn(self) -> Named:
        _, c, _, drawn, _ = self.inputs
        rows = dict(zip(self.rows.drawn, ca.horzsplit(drawn), strict=True))
        x, y = rows["tip_machine_x_mm"], rows["tip_y_mm"]
        speed, forward = (c[place(self.device, f"operation.{key}")] for key in ("speed_rpm", "forward_speed_m_s"))
        seconds = 2 * np.pi / ca.fabs(speed)
        advance = 1e3 * forward * seconds
        planted = rows["tip_x_mm"][ca.find(y == ca.mmin(y))]
        return {
            **{f"{key} at first": rows[key][0] for key in ("x_A1_mm", "y_A1_mm", "x_B1_mm", "y_B1_mm")},
            "seconds": seconds,
            "left of the tip": ca.mmin(x),
            "right of the tip": ca.mmax(x),
            "right of the tip a turn later": ca.mmax(x) + advance,
            "lowest tip": ca.mmin(y),
            "top": ca.mmax(rows["y_B1_mm"]),
            **{f"plant {k}": planted + k * advance / 2 for k in (-1, 0, 1)},
        }

    def _read(self) -> Named:
        _, c, h, _, told = self.inputs
        support, torque, cam = ca.horzsplit(told)
        high, low = ca.mmax(support), ca.mmin(support)
        over = partial(cycle.name_over_samples, samples=self.device.machine.objective.samples)
        first, second = (1e3 * h[at] for at in cycle.find_distance_indices(self.device))
        return {
            over("objective (31)"): objective(self.device, support),
            over("range of the support force"): high - low,
            over("largest support force"): high,
            over("least support force"): low,
            "weight": self.device.formulas.function("weight")(c),
            over("largest motor torque"): ca.mmax(ca.fabs(torque)),
            over("largest force of the cam"): ca.mmax(cam),
            "centre distance of stage 1": first,
            "centre distance of stage 2": second,
        }


def objective(device: Device, force: ca.MX) -> ca.MX:
    """The device's objective of samples (n,) of its support force."""
    settings, apart = read_weights(device.machine), force - ca.sum1(force) / force.numel()
    variance = ca.dot(apart, apart) / force.numel()
    return settings.weight_range * (ca.mmax(force) - ca.mmin(force)) + settings.weighted(variance, ca.sqrt)
