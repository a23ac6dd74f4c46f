"""Programs of a planting device, by which a page without Python draws it and computes the gradient
of its objective.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, partial

import casadi as ca
import numpy as np

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.files import units
from planter.kernels.programs import Program, ProgramStep
from planter.papers.planting.model import Device, list_keys
from planter.report.subject import Input, Portable

SIDE = (
    "phi52_deg",
    "alpha_deg",
    "theta1_deg",
    "tip_x_mm",
    "tip_machine_x_mm",
    "tip_y_mm",
    "x_A1_mm",
    "y_A1_mm",
    "x_B1_mm",
    "y_B1_mm",
    "F_A1x_N",
    "F_A1y_N",
    "F_B1x_N",
    "F_B1y_N",
    "F_E_N",
)
"""Quantities of side 1 that are drawn."""
TOTALS = ("support_N", "M_L_Nm")
TOLD = ("support_N", "M_L_Nm", "F_E_N")
"""What of a turn is told, at the samples of the file."""
AXES = 4
"""x and y of the inner gear of a stage, then those of the outer."""
Known = Mapping[str, ca.SX]


def name_over_samples(name: str, samples: int) -> str:
    """Return the name of a number computed from samples of a cycle, not exactly."""
    return f"{name}, {samples} samples"


class DeviceColumns:
    """Expressions in the carrier angle, the design, the machine's data, and what a prologue finds:
    `inputs`.
    """

    def __init__(self, device: Device) -> None:
        self.device, self.inputs = device, device.functions.inputs

    @cached_property
    def plotted(self) -> Known:
        """Quantities of a cycle that are drawn, in display units."""
        values, phi = self._quantities, self.inputs[0]
        turned = phi / units.unit_factor("phi_deg")
        return {
            "phi_deg": turned,
            "planet's turn on the carrier": -values["alpha_deg"] - turned,
            "travel": 1e3
            * self._datum("forward_speed_m_s")
            * phi
            / ca.fabs(self._datum("speed_rpm")),
            **{key: values[key] for key in (*SIDE, *TOTALS)},
            **{
                f"{name}_N": ca.hypot(values[f"{name}x_N"], values[f"{name}y_N"])
                for name in ("F_A1", "F_B1")
            },
        }

    @property
    def sampled(self) -> Sequence[ca.SX]:
        """Quantities of a cycle that the readings use, in display units."""
        return [self._quantities[key] for key in TOLD]

    def outlines(self, stage: int) -> Sequence[ca.SX]:
        """Points of the inner and the outer gear of a stage, 0 or 1 [mm], in their bodies, from
        their own axes.

        They are those whose polar angle on the inner gear is the first contact's and as much more
        as the carrier angle.
        """
        start = self._at_start
        t, contact = start[f"t{stage + 1}"] + self.inputs[0], f"T{stage + 1}"
        at, first = self._contact(stage, t), self._contact(stage, start[f"t{stage + 1}"])
        formulas = self.device.formulas
        point = dict(zip(formulas.entries("point"), (t, at["r"], at["turned"]), strict=True))
        inputs = start | self._mounting | {"phi": ca.SX(0), contact: first["turned"]} | point
        points = formulas.composed(f"pair{stage + 1}", inputs)
        axes = ((0.0, 0.0), (start["x_A1"], start["y_A1"]), (start["x_B1"], start["y_B1"]))
        (x, y), (u, v) = (
            (points[f"x_{gear}"] - axis[0], points[f"y_{gear}"] - axis[1])
            for gear, axis in zip(("inner", "outer"), axes[stage:], strict=False)
        )
        return [
            1e3 * value for value in (x, y, *(_turned(u, v, start["alpha"]) if stage else (u, v)))
        ]

    @cached_property
    def _quantities(self) -> Known:
        """Quantities of side 1 and of both in shown units by their keys."""
        vectors = self.device.sidecar["vectors"]
        side, _, totals = self.device.functions.both
        values_by_key: dict[str, ca.SX] = {}
        for vector, values in (("side", side), ("totals", totals)):
            keys = list_keys(vectors[vector])
            values_by_key |= {
                key: v / units.unit_factor(key)
                for key, v in zip(keys, ca.vertsplit(values), strict=True)
            }
        return values_by_key

    @cached_property
    def _at_start(self) -> dict[str, ca.SX]:
        """Quantities of side 1 where the carrier angle is zero, by their names [SI]."""
        side = self.device.functions.side(ca.SX(0))
        return dict(zip(self.device.formulas.entries("side"), ca.vertsplit(side), strict=True))

    @cached_property
    def _mounting(self) -> dict[str, ca.SX]:
        """Mounting of the gears: the design's first entries, and the centre distances [SI]."""
        _, x, _, h = self.inputs
        mounting = dict(
            zip(self.device.formulas.entries("mounting"), ca.vertsplit(x), strict=False)
        )
        return mounting | {
            f"a{k}": h[place] for k, place in enumerate(self.device.distance_places, 1)
        }

    def _contact(self, stage: int, t: ca.SX) -> dict[str, ca.SX]:
        """Contact of a stage at a polar angle of its inner gear."""
        contact = self.device.stages[stage].contact.function
        parameters, hoisted = self.device.functions.lane_inputs(self.inputs[0])[
            2 + 2 * stage : 4 + 2 * stage
        ]
        return dict(zip(contact.name_out(), contact.call([t, parameters, hoisted]), strict=True))

    def _datum(self, key: str) -> ca.SX:
        return self.inputs[2][place(self.device, f"operation.{key}")]


def place(device: Device, path: str) -> int:
    """Return the index of a number of the file in the machine's data."""
    return [entry["shown"] for entry in device.sidecar["vectors"]["machine"]].index(path)


def _turned(x: ca.SX, y: ca.SX, by: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A point turned by an angle."""
    c, s = ca.cos(by), ca.sin(by)
    return c * x - s * y, s * x + c * y


Named = Mapping[str, ca.MX]
INPUTS = ("x", "c", "h", "rows", "told")


class Singles:
    """Numbers of the design, the data and the prologue, and of rows side by side: `inputs`, in the
    order of INPUTS.
    """

    def __init__(self, rows: DeviceColumns, moments: int) -> None:
        self.rows, self.device = rows, rows.device
        samples = self.device.machine.objective.samples
        sizes = [symbol.shape for symbol in rows.inputs[1:]]
        sizes += [(moments, len(rows.plotted)), (samples, len(TOLD))]
        self.inputs = [ca.MX.sym(name, *size) for name, size in zip(INPUTS, sizes, strict=True)]

    @cached_property
    def all(self) -> Named:
        """All of them by name."""
        return {**self._compute_drawing(), **self._compute_readings()}

    def _compute_drawing(self) -> Named:
        _, c, _, table, _ = self.inputs
        rows = dict(zip(self.rows.plotted, ca.horzsplit(table), strict=True))
        x, y = rows["tip_machine_x_mm"], rows["tip_y_mm"]
        speed, forward = (
            c[place(self.device, f"operation.{key}")] for key in ("speed_rpm", "forward_speed_m_s")
        )
        seconds = 2 * np.pi / ca.fabs(speed)
        advance = 1e3 * forward * seconds
        planted = rows["tip_x_mm"][ca.find(y == ca.mmin(y))]
        return {
            **{
                f"{key} at first": rows[key][0]
                for key in ("x_A1_mm", "y_A1_mm", "x_B1_mm", "y_B1_mm")
            },
            "seconds": seconds,
            "left of the tip": ca.mmin(x),
            "right of the tip": ca.mmax(x),
            "right of the tip a turn later": ca.mmax(x) + advance,
            "lowest tip": ca.mmin(y),
            "top": ca.mmax(rows["y_B1_mm"]),
            **{f"plant {k}": planted + k * advance / 2 for k in (-1, 0, 1)},
        }

    def _compute_readings(self) -> Named:
        _, c, h, _, samples = self.inputs
        support, torque, cam = ca.horzsplit(samples)
        high, low = ca.mmax(support), ca.mmin(support)
        over = partial(name_over_samples, samples=self.device.machine.objective.samples)
        first, second = (1e3 * h[at] for at in self.device.distance_places)
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
    settings, deviation = device.machine.objective, force - ca.sum1(force) / force.numel()
    variance = ca.dot(deviation, deviation) / force.numel()
    return settings.weight_range * (ca.mmax(force) - ca.mmin(force)) + settings.weighted(
        variance, ca.sqrt
    )


NOTES = (
    "Gears are drawn by their pitch curves, without teeth; events are not listed.",
    "Requirements are not computed here: save the file and run planter simulate.",
    "Improve runs a local optimisation from the current design, within its bounds and without "
    "requirements; "
    "planter optimise finds an optimum, with a certificate.",
)


def build_portable(device: Device, moments: int, corners: int) -> Portable:
    """The programs: `moments` of a turn, pitch curves of `corners` points, the last one the first
    again.
    """
    rows = DeviceColumns(device)
    singles = Singles(rows, moments)
    return Portable(
        inputs=_inputs(device),
        seen=_seen(rows, singles, moments, corners),
        rows={"rows": len(rows.plotted), "stage1": AXES, "stage2": AXES},
        singles=list(singles.all),
        gradient=_descent(device),
        design=[f"design.{name}" for name in device.names],
        assumptions=device.sidecar["assumptions"],
        notes=NOTES,
    )


def _inputs(device: Device) -> list[Input]:
    entries = device.sidecar["vectors"]["machine"]
    return [
        *(
            Input(f"design.{name}", "x", k, units.unit_factor(name))
            for k, name in enumerate(device.names)
        ),
        *(
            Input(entry["shown"], "c", k, units.unit_factor(entry["shown"]))
            for k, entry in enumerate(entries)
        ),
    ]


def _seen(rows: DeviceColumns, singles: Singles, moments: int, corners: int) -> Program:
    device, prologue = rows.device, rows.device.functions.prologue_function
    x, c = prologue.mx_in()
    data = {
        "x": device.design,
        "c": device.constants,
        "phi": device.engine.list_angles(moments),
        "sampled": device.engine.list_angles(),
        "around": 2 * np.pi * np.arange(corners) / (corners - 1),
    }
    return Program(
        f"{device.model}_seen",
        data,
        [
            ProgramStep(_named(device, "prologue", [x, c], [prologue(x, c)], ["x", "c"], ["h"])),
            _lanes(rows, "phi", "rows", rows.plotted.values()),
            _lanes(rows, "sampled", "told", rows.sampled),
            *(_lanes(rows, "around", f"stage{k + 1}", rows.outlines(k)) for k in (0, 1)),
            ProgramStep(
                _named(
                    device,
                    "single",
                    singles.inputs,
                    [ca.vertcat(*singles.all.values())],
                    INPUTS,
                    ["singles"],
                )
            ),
        ],
    )


def _lanes(rows: DeviceColumns, over: str, name: str, values: Iterable[ca.SX]) -> ProgramStep:
    """Rows over a quantity instead of the carrier angle."""
    rows_of_values = ca.cse(ca.vertcat(*values))
    f = ca.Function(
        f"{rows.device.model}_{name}", rows.inputs, [rows_of_values], [over, "x", "c", "h"], [name]
    )
    return ProgramStep(f, (over,))


def _named(
    device: Device,
    name: str,
    inputs: Sequence[ca.MX],
    outputs: Sequence[ca.MX],
    input_names: Sequence[str],
    output_names: Sequence[str],
) -> ca.Function:
    return ca.Function(f"{device.model}_{name}", inputs, outputs, input_names, output_names)


def _descent(device: Device) -> Program:
    """The objective and its gradient, the extremes staying at their samples; folded as the engine
    has it.
    """
    shares, response = device.force.offsets, device.force.response
    turn = sample_angles(device.machine.objective.samples, device.force.period)
    x, c = device.functions.tangent_function.mx_in()
    h, dh = device.functions.tangent_function(x, c)
    slopes = response.slopes_function
    force, g = (
        ca.MX.sym("force", len(turn) * len(shares)),
        ca.MX.sym("g", len(turn) * len(shares), 1 + x.numel()),
    )
    samples = ca.MX.sym("samples", len(turn))
    value = objective(device, samples)
    weighed = ca.Function("weighed", [samples], [value, ca.gradient(value, samples)])
    total, slope = weighed.call([sum(ca.vertsplit(force, len(turn)))])
    gradient = g[:, 1:].T @ ca.repmat(slope, len(shares), 1)
    data = {"x": device.design, "c": device.constants, "place": np.add.outer(shares, turn)}
    place, *more, tangent = device.functions.inputs + slopes.sx_in()[-1:]
    rows = slopes.call([place, ca.vertcat(*more[:2]), more[2], ca.SX(0, 1), tangent])
    names = ["place", "x", "c", "h", "dh"]
    over = ca.Function(
        f"{device.model}_slopes", [place, *more, tangent], rows, names, ["force", "g"]
    )
    outputs = ["objective", "gradient"]
    return Program(
        f"{device.model}_descent",
        data,
        [
            ProgramStep(
                _named(device, "tangent", [x, c], [h, ca.vec(dh.nz[:])], ["x", "c"], ["h", "dh"])
            ),
            ProgramStep(over, ("place",)),
            ProgramStep(
                _named(device, "weighed", [force, g], [total, gradient], ["force", "g"], outputs)
            ),
        ],
    )
