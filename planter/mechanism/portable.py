"""A mechanism of one's own as a program: what a page needs to compute its turn without Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from planter.engine.machine import LEAST_PIVOT
from planter.files import units
from planter.kernels.formulas import HOISTED
from planter.kernels.programs.program import Program, Step
from planter.mechanism.closing import closed
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine
from planter.mechanism.report.scene import GROUND, MARK, MARKS, MOST_CURVES, OBLIQUE, shown
from planter.view.portable import Input, Portable

OPEN = 1e-11
"""A loop is closed where Newton's next step is below this share of the coordinates' size."""
NOTES = (
    "Laws that must be obeyed, contacts that lift, limits and optima are not told here: save the file beside its "
    "generated functions, and planter turn tells them.",
)
Known = Mapping[str, ca.SX]


class Turning:
    """A mechanism's turn at `samples` angles."""

    def __init__(self, file: MechanismFile) -> None:
        self.machine, self.formulas = build_machine(file), file.model
        self.samples = self.machine.samples
        self.angles = 2 * np.pi * np.arange(self.samples) / self.samples
        self.loops = self.machine.loops is not None

    def portable(self) -> Portable:
        """All that a page needs."""
        return Portable(
            inputs=[Input(value.path, "data", k, value.factor) for k, value in enumerate(self.machine.values)],
            seen=Program("turn", {"angles": self.angles, "data": self.machine.data}, self._steps()),
            rows={"rows": len(self._drawn)},
            singles=list(self._singles),
            assumptions=self.formulas.sidecar["assumptions"],
            notes=NOTES,
        )  # fmt: skip

    def _steps(self) -> list[Step]:
        found = [Step(closed(self.formulas, "turn_loops", self.samples))] if self.loops else []
        if HOISTED in self._lane.name_in():
            prologue = self.formulas.function("prologue")
            data = ca.MX.sym("data", prologue.numel_in(0))
            found.append(Step(ca.Function("turn_prologue", [data], [prologue(data)], ["data"], [HOISTED])))
        names = ["angles", *self._lane.name_in()[1:]]
        values = ca.vertcat(*self._rows.values())
        rows = ca.Function("turn_rows", self._inputs, [ca.cse(values)], names, ["all"])
        found.append(Step(rows, tuple(name for name in names if name in ("angles", "loops"))))
        all_, taken = self._all, shown(self.samples).tolist()
        drawn = ca.horzcat(*(all_[taken, list(self._rows).index(key)] for key in self._drawn))
        found.append(Step(ca.Function("turn_drawn", [all_], [drawn], ["all"], ["rows"])))
        singles = ca.vertcat(*self._singles.values())
        found.append(Step(ca.Function("turn_singles", list(self._given.values()), [singles], list(self._given),
                                      ["singles"])))  # fmt: skip
        return found

    # --- along the angle ------------------------------------------------------------------------------

    @cached_property
    def _lane(self) -> ca.Function:
        return self.formulas.function("lane")

    @cached_property
    def _inputs(self) -> list[ca.SX]:
        return list(self._lane.sx_in())

    @cached_property
    def _rows(self) -> Known:
        """Everything at an angle by name, results in shown units by their keys first."""
        values = ca.vertsplit(self._lane(*self._inputs))
        quantities = list(zip(self.machine.quantities, values, strict=True))
        told = {q.key: value / q.factor for q, value in quantities if q.role == "result"}
        checked = {q.name: value for q, value in quantities if q.role in ("pivot", "states")}
        return {**told, **checked, **self._points, "angle": self._inputs[0] / units.factor("angle_deg")}

    @property
    def _keys(self) -> list[str]:
        return [quantity.key for quantity in self.machine.results]

    @cached_property
    def _points(self) -> Known:
        """Where points of bodies are drawn [mm], as `x BODY__POINT` and `y BODY__POINT`."""
        places = self.formulas.function("places")
        given = dict(zip(self._lane.name_in(), self._inputs, strict=True))
        at = dict(zip(self.formulas.outputs("places"), ca.vertsplit(places(*(given[n] for n in places.name_in()))),
                      strict=True))  # fmt: skip
        return {
            f"{axis} {point}": 1e3 * (at[f"{axis}_{point}"] - OBLIQUE * at.get(f"z_{point}", 0.0))
            for name in at
            for axis, _, point in [name.partition("_")]
            if axis in "xy"
        }

    @cached_property
    def _drawn(self) -> Sequence[str]:
        return ["angle", *self._keys[:MOST_CURVES], *self._points]

    # --- single numbers -------------------------------------------------------------------------------

    @cached_property
    def _all(self) -> ca.MX:
        return ca.MX.sym("all", self.samples, len(self._rows))

    @cached_property
    def _given(self) -> Mapping[str, ca.MX]:
        """What single numbers are made of."""
        loops = {name: ca.MX.sym(name, self.samples) for name in ("open", "sense")} if self.loops else {}
        return {"data": ca.MX.sym("data", len(self.machine.data)), "all": self._all, **loops}

    @cached_property
    def _singles(self) -> Mapping[str, ca.MX]:
        rows = dict(zip(self._rows, ca.horzsplit(self._all), strict=True))
        speed = self._given["data"][self.machine.speed]
        return {
            "seconds": 2 * np.pi / ca.fabs(speed),
            "sound": 1 / self._sound(rows),
            **{f"largest {key}": ca.mmax(rows[key]) for key in self._keys},
            **{f"least {key}": ca.mmin(rows[key]) for key in self._keys},
            **self._marks(rows),
        }

    def _sound(self, rows: Mapping[str, ca.MX]) -> ca.MX:
        """One where all loops are closed in one assembly and the equations determine their forces; else zero."""
        least = {"pivot": LEAST_PIVOT, "states": 0}
        checks = [ca.mmin(rows[q.name]) > least[q.role] for q in self.machine.quantities if q.role in least]
        if self.loops:
            sense = self._given["sense"]
            checks += [ca.mmax(self._given["open"]) < OPEN, ca.mmin(sense * sense[0]) > 0]
        found = ca.MX(1)
        for check in checks:
            found *= check
        return found

    def _marks(self, rows: Mapping[str, ca.MX]) -> Mapping[str, ca.MX]:
        """Corners of the marks at points of the ground."""
        both = [[row for name, row in rows.items() if name.startswith(f"{axis} ")] for axis in "xy"]
        apart = [ca.mmax(ca.vertcat(*of)) - ca.mmin(ca.vertcat(*of)) for of in both]
        size = ca.fmax(*apart) / MARKS
        return {
            f"{name} {k}": rows[name][0] + size * corner["xy".index(name[0])]
            for name in self._points
            if name[2:].startswith(f"{GROUND}__")
            for k, corner in enumerate(MARK)
        }
