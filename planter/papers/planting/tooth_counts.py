"""Integer tooth numbers of standard modules: the numbers that a design shall have, and the
constraints they imply.

A stage with z teeth of module m has an inner pitch curve of length pi m z, which is an equality
constraint of the optimisation. The bounds of a design permit a range of lengths, and so of tooth
numbers.
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.engine.solvers.constraints import Constraints, DesignBox, NamedConstraint
from planter.engine.solvers.expressions import SmoothObjective
from planter.engine.solvers.local_search import search_from_points
from planter.engine.solvers.problem import Problem
from planter.errors import InputError
from planter.gears import request
from planter.gears.geometry.cutting import MIN_TEETH
from planter.gears.geometry.stage import PitchLength, StageCandidate
from planter.kernels import Array, Flags, Integers
from planter.papers.planting.model import Device

LENGTH_SCALE = 1e-3
"""Deviation of a length that counts as one step of a constraint [m]."""
LENGTH_TOLERANCE = 1e-9
"""Share of a length by which rounding may put it outside its range."""


@dataclass(frozen=True)
class ToothCountSpec:
    """Modules [m] and tooth numbers of the inner gears of stages 1 and 2.

    A stage without a module is left as it is; for one with a module but no number the best number
    is searched for.
    """

    modules: tuple[float | None, ...]
    teeth: tuple[int | None, ...]

    @property
    def stages(self) -> tuple[int, ...]:
        """The stages, 0 and 1, that have a module."""
        return tuple(k for k, module in enumerate(self.modules) if module is not None)

    @property
    def is_complete(self) -> bool:
        """Whether all tooth numbers are known."""
        return all(self.teeth[k] is not None for k in self.stages)

    def with_teeth(self, counts: Sequence[int]) -> ToothCountSpec:
        """Return a copy with tooth numbers for the stages that have a module."""
        by_stage = dict(zip(self.stages, counts, strict=True))
        return replace(self, teeth=tuple(by_stage.get(k, z) for k, z in enumerate(self.teeth)))

    def circular_pitch(self, stage: int) -> float:
        """Return the arc of the pitch curve per tooth [m] of a stage that has a module."""
        return float(np.pi * (self.modules[stage] or 0.0))

    def length(self, stage: int) -> float:
        """Return the length of the pitch curve [m] of a stage whose tooth number is known."""
        return self.circular_pitch(stage) * (self.teeth[stage] or 0)

    def __str__(self) -> str:
        """Return the tooth numbers as part of a sentence: 31 teeth of 2 mm on stage 1 and 33 teeth
        of ....
        """
        return " and ".join(
            f"{self.teeth[k]} teeth of {1e3 * (self.modules[k] or 0.0):.6g} mm on stage {k + 1}"
            for k in self.stages
        )


def parse_tooth_count_options(
    module: float | None, module1: float | None, module2: float | None, teeth: str | None
) -> ToothCountSpec | None:
    """Return what the options of a command ask for, modules in mm; None if they ask for no integer
    tooth numbers.

    Raises InputError if there are tooth numbers without a module, too many or too few of them, or
    one below the minimum of a gear.
    """
    modules = request.parse_modules(module, module1, module2)
    counts = request.parse_tooth_counts(teeth)
    spec = ToothCountSpec(tuple(None if m is None else m * 1e-3 for m in modules), (None, None))
    if not spec.stages:
        if counts:
            raise InputError(
                f"--teeth {teeth} needs a module: add --module, or --module1 and --module2"
            )
        return None
    if not counts:
        return spec
    if len(counts) != len(spec.stages):
        allowed = (
            "Z1,Z2"
            if len(spec.stages) == 2
            else f"Z, the teeth of stage {spec.stages[0] + 1}, which has one"
        )
        raise InputError(f"--teeth {teeth}: it must be {allowed}, one for each stage with a module")
    if min(counts) < MIN_TEETH:
        raise InputError(f"--teeth {teeth}: every gear needs at least {MIN_TEETH} teeth")
    return spec.with_teeth(counts)


class PitchLengthConstraints(Constraints):
    """Lengths of pitch curves as equality constraints: one for each stage of `spec`; designs x are
    (p,) in SI.

    They cannot be relaxed: if other constraints conflict with them, those are reported.
    """

    def __init__(self, device: Device, spec: ToothCountSpec) -> None:
        self.device = device
        self.parameter_indices = [find_stage_parameters(device, k) for k in spec.stages]
        self.curves = [build_pitch_length(device, k) for k in spec.stages]
        self.kinds = [
            NamedConstraint(constraint_name(k), ("min", "max"), "mm", LENGTH_SCALE * 1e3)
            for k in spec.stages
        ]
        self.owner: Integers = np.arange(len(self.kinds))
        self._set_spec(spec)

    def _set_spec(self, spec: ToothCountSpec) -> None:
        self.spec = spec
        self.lower = self.upper = np.array([spec.length(k) for k in spec.stages]) / LENGTH_SCALE

    def with_spec(self, spec: ToothCountSpec) -> PitchLengthConstraints:
        """Return a copy for other tooth numbers on the same stages."""
        constraints = copy.copy(self)
        constraints._set_spec(spec)
        return constraints

    @property
    def giving(self) -> Flags:
        return np.zeros(len(self.kinds), dtype=bool)

    @property
    def equations(self) -> PitchLengthConstraints:
        return self

    def lengths(self, x: Array) -> list[float]:
        """Return the lengths at a design (p,) [m]."""
        return [
            curve.at(x[at]).value
            for curve, at in zip(self.curves, self.parameter_indices, strict=True)
        ]

    def values(self, x: Array) -> Array:
        """Return the scaled pitch lengths of a design x (p,)."""
        return np.array(self.lengths(x)) / LENGTH_SCALE

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian of the scaled pitch lengths in a design x (p,)."""
        rows = np.zeros((len(self.curves), len(x)))
        for row, curve, at in zip(rows, self.curves, self.parameter_indices, strict=True):
            row[at] = curve.at(x[at]).gradient / LENGTH_SCALE
        return rows

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the weighted sum (p, p) of the Hessians of the scaled pitch lengths at a design x
        (p,).
        """
        total = np.zeros((len(x), len(x)))
        for weight, curve, at in zip(weights, self.curves, self.parameter_indices, strict=True):
            total[np.ix_(at, at)] += weight / LENGTH_SCALE * curve.at(x[at]).hessian
        return total


def constraint_name(stage: int) -> str:
    """Return the name of a stage's constraint in results."""
    return f"pitch_length_{stage + 1}"


def find_stage_parameters(device: Device, stage: int) -> Integers:
    """Return the indices of a stage's parameters in the design vector."""
    return device.of_stage(stage, np.arange(device.size, dtype=float)).astype(np.int64)


def build_pitch_length(device: Device, stage: int) -> PitchLength:
    """Return the length of a stage's pitch curve, exact to rounding at the design and at the
    corners of its bounds.
    """
    at, source = find_stage_parameters(device, stage), device.machine.source
    corners = itertools.product(*zip(device.lower[at], device.upper[at], strict=True))
    candidates = [
        StageCandidate(device.design[at], lambda key: f"{source}: design.{key}"),
        *(
            StageCandidate(np.array(corner), lambda key: f"{source}: bounds.{key}")
            for corner in corners
        ),
    ]
    return PitchLength(device.stages[stage], candidates)


@dataclass(frozen=True)
class PitchLengthRange:
    """Shortest and longest pitch curve of a stage within the bounds [m], and the circular pitch
    [m].
    """

    stage: int
    shortest: float
    longest: float
    pitch: float

    @property
    def teeth(self) -> range:
        """The tooth numbers that the bounds permit."""
        first = math.ceil(self.shortest * (1 - LENGTH_TOLERANCE) / self.pitch)
        return range(first, math.floor(self.longest * (1 + LENGTH_TOLERANCE) / self.pitch) + 1)

    def find_tooth_count(self, length: float) -> int:
        """Return the permitted tooth number that is nearest to a length [m]."""
        return min(self.teeth, key=lambda z: abs(z * self.pitch - length))

    def check(self, teeth: int | None) -> None:
        """Raise InputError unless a tooth number is permitted, or any number if it is None."""
        module = f"{1e3 * self.pitch / np.pi:.6g} mm"
        if teeth is None and not self.teeth:
            below = math.floor(self.shortest / self.pitch)
            hint = " and ".join(self._describe_modules(z) for z in (below, below + 1))
            raise InputError(
                f"whole teeth of {module} do not fit on stage {self.stage + 1}: {self}; {hint}"
            )
        if teeth is not None and teeth not in self.teeth:
            hint = self._describe_modules(teeth)
            raise InputError(
                f"{teeth} teeth of {module} do not fit on stage {self.stage + 1}: {self}; {hint}"
            )

    def _describe_modules(self, teeth: int) -> str:
        """Return which modules the bounds permit with a tooth number."""
        low, high = (1e3 * length / (np.pi * teeth) for length in (self.shortest, self.longest))
        return f"{teeth} teeth take a module of {low:.6g} to {high:.6g} mm"

    def __str__(self) -> str:
        return (
            f"within the bounds the pitch curve of stage {self.stage + 1} is "
            f"{self.shortest * 1e3:.6g} to "
            f"{self.longest * 1e3:.6g} mm long, {self.shortest / self.pitch:.5g} to "
            f"{self.longest / self.pitch:.5g} "
            "of them"
        )


def compute_length_ranges(constraints: PitchLengthConstraints) -> list[PitchLengthRange]:
    """Return the range of every stage that shall have an integer tooth number."""
    device, spec = constraints.device, constraints.spec
    ranges = []
    for k, curve, at in zip(
        spec.stages, constraints.curves, constraints.parameter_indices, strict=True
    ):
        shortest, longest = (
            _find_extreme_length(curve, device.lower[at], device.upper[at], sign)
            for sign in (1, -1)
        )
        ranges.append(PitchLengthRange(k, shortest, longest, spec.circular_pitch(k)))
    return ranges


class _SignedLength:
    """A length or its negative, as a `Function`."""

    def __init__(self, curve: PitchLength, sign: int) -> None:
        self.curve, self.sign = curve, sign

    def value(self, x: Array) -> float:
        return self.sign * self.curve.at(x).value

    def gradient(self, x: Array) -> Array:
        return self.sign * self.curve.at(x).gradient

    def hessian(self, x: Array) -> Array:
        return self.sign * self.curve.at(x).hessian


def _find_extreme_length(curve: PitchLength, lower: Array, upper: Array, sign: int) -> float:
    """Return the shortest length within bounds (sign +1), or the longest (-1).

    Local searches begin at the centre of the bounds and at the best of their corners.
    """
    signed = _SignedLength(curve, sign)
    names = tuple(str(k) for k in range(len(lower)))
    centre = (lower + upper) / 2
    problem = Problem(
        SmoothObjective(signed, len(lower), curve.at(centre).value),
        DesignBox.shares(names, lower, upper, centre),
    )
    corners = (
        np.array(corner, dtype=float) for corner in itertools.product((0, 1), repeat=len(lower))
    )
    best = min(corners, key=lambda u: signed.value(problem.design(u)))
    ends = [best, *(minimum.u for minimum in search_from_points(problem, [problem.start, best]))]
    return sign * min(signed.value(problem.design(u)) for u in ends)
