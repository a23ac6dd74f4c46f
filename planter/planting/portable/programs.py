"""The programs of a planting device: what is seen of it, and the gradient of its objective."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca
import numpy as np

from planter.files import units
from planter.kernels.programs.program import Program, Step
from planter.optimise.samples import angles
from planter.planting import cycle
from planter.planting.model import Device
from planter.planting.portable.rows import AXES, Rows
from planter.planting.portable.singles import INPUTS, Singles, objective
from planter.view.subject import Input, Portable

NOTES = (
    "Gears are drawn by their pitch curves, without teeth; events are not listed.",
    "Requirements are not computed here: save the file and run planter simulate.",
    "Improve runs a local optimisation from the current design, within its bounds and without requirements; "
    "planter optimise finds an optimum, with a certificate.",
)


def portable(device: Device, moments: int, corners: int) -> Portable:
    """The programs: `moments` of a turn, pitch curves of `corners` points, the last one the first again."""
    rows = Rows(device)
    singles = Singles(rows, moments)
    return Portable(
        inputs=_inputs(device),
        seen=_seen(rows, singles, moments, corners),
        rows={"rows": len(rows.drawn), "stage1": AXES, "stage2": AXES},
        singles=list(singles.all),
        gradient=_descent(device),
        design=[f"design.{name}" for name in device.names],
        assumptions=device.sidecar["assumptions"],
        notes=NOTES,
    )


def _inputs(device: Device) -> list[Input]:
    entries = device.sidecar["vectors"]["machine"]
    return [
        *(Input(f"design.{name}", "x", k, units.factor(name)) for k, name in enumerate(device.names)),
        *(Input(entry["shown"], "c", k, units.factor(entry["shown"])) for k, entry in enumerate(entries)),
    ]


def _seen(rows: Rows, singles: Singles, moments: int, corners: int) -> Program:
    device, prologue = rows.device, rows.device.functions.prologue_function
    x, c = prologue.mx_in()
    given = {
        "x": device.design, "c": device.constants, "phi": cycle.sample_angles(moments),
        "sampled": cycle.sample_angles(device.machine.objective.samples),
        "around": 2 * np.pi * np.arange(corners) / (corners - 1),
    }  # fmt: skip
    return Program(f"{device.model}_seen", given, [
        Step(_named(device, "prologue", [x, c], [prologue(x, c)], ["x", "c"], ["h"])),
        _lanes(rows, "phi", "rows", rows.drawn.values()),
        _lanes(rows, "sampled", "told", rows.told),
        *(_lanes(rows, "around", f"stage{k + 1}", rows.outlines(k)) for k in (0, 1)),
        Step(_named(device, "single", singles.inputs, [ca.vertcat(*singles.all.values())], INPUTS, ["singles"])),
    ])  # fmt: skip


def _lanes(rows: Rows, over: str, name: str, values: Iterable[ca.SX]) -> Step:
    """Rows over what stands in the place of the carrier angle."""
    found = ca.cse(ca.vertcat(*values))
    f = ca.Function(f"{rows.device.model}_{name}", rows.inputs, [found], [over, "x", "c", "h"], [name])
    return Step(f, (over,))


def _named(
    device: Device, name: str, inputs: Sequence[ca.MX], outputs: Sequence[ca.MX], given: Sequence[str],
    found: Sequence[str],
) -> ca.Function:  # fmt: skip
    return ca.Function(f"{device.model}_{name}", inputs, outputs, given, found)


def _descent(device: Device) -> Program:
    """The objective and its gradient, the extremes staying at their samples; folded as the engine has it."""
    shares, response = device.force.offsets, device.force.response
    turn = angles(device.machine.objective.samples, device.force.period)
    x, c = device.functions.tangent_function.mx_in()
    h, dh = device.functions.tangent_function(x, c)
    slopes = response.slopes_function
    force, g = ca.MX.sym("force", len(turn) * len(shares)), ca.MX.sym("g", len(turn) * len(shares), 1 + x.numel())
    samples = ca.MX.sym("samples", len(turn))
    value = objective(device, samples)
    weighed = ca.Function("weighed", [samples], [value, ca.gradient(value, samples)])
    found, slope = weighed.call([sum(ca.vertsplit(force, len(turn)))])
    gradient = g[:, 1:].T @ ca.repmat(slope, len(shares), 1)
    given = {"x": device.design, "c": device.constants, "place": np.add.outer(shares, turn)}
    place, *more, tangent = device.functions.inputs + slopes.sx_in()[-1:]
    rows = slopes.call([place, ca.vertcat(*more[:2]), more[2], ca.SX(0, 1), tangent])
    names = ["place", "x", "c", "h", "dh"]
    over = ca.Function(f"{device.model}_slopes", [place, *more, tangent], rows, names, ["force", "g"])
    return Program(f"{device.model}_descent", given, [
        Step(_named(device, "tangent", [x, c], [h, dh.nz[:]], ["x", "c"], ["h", "dh"])),
        Step(over, ("place",)),
        Step(_named(device, "weighed", [force, g], [found, gradient], ["force", "g"], ["objective", "gradient"])),
    ])  # fmt: skip
