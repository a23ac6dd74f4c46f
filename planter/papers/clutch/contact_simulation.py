"""Motion of a clutch in contact at engagement and cut-off, and the comparison with a dog clutch.

Steps are chosen by the integrator's error control, which sees every contact begin and end: the
forces are continuous there, and no step is longer than `LONGEST`. States are sampled on a fine
grid; peaks are then searched between points.

The loads that the paper prints depend on inputs that it does not disclose. The results here are for
stated inputs, with the sensitivity of both clutches' loads to each of them. A load that stays is
not an impact: the two are not compared.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

from planter.errors import ComputationError, Interrupted
from planter.kernels import Kernel, formulas
from planter.papers.clutch import contact_dynamics
from planter.papers.clutch.contact_dynamics import (
    ANGLE,
    FREE,
    OUTPUT,
    POWERS,
    REULEAUX,
    SIZE,
    TIME,
    TRAVEL,
    WORKS,
    Array,
    ClutchDynamics,
    ContactInputs,
    build_contact_inputs,
)
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.modal_engagement import FACTORS, PAPERS
from planter.papers.clutch.results import (
    ClutchLoads,
    ContactEngagement,
    ContactLoadSensitivity,
    EnergyBalance,
    Outcome,
    PhaseLoads,
    TeethInSleeve,
)
from planter.progress import Listener, ProgressPhase

STEP = 2e-5
"""Distance of the points of the grid [s]."""
LONGEST = 5e-5
"""Longest step of the integrator [s]: at the speeds of a planter, contacts close by a few
micrometres in it.
"""
TOLERANCE = 1e-9
"""Relative tolerance; the absolute one is a thousandth of it, in SI units."""
FINE = 64
"""Points between two of the grid when a peak is looked for."""


@dataclass(frozen=True)
class ContactRun:
    """A motion on a grid: states (SIZE, n), and the rows computed from them, by name."""

    clutch: ClutchDynamics
    inputs: ContactInputs
    states: Array
    seen: dict[str, Array]
    tolerance: float

    @property
    def time(self) -> Array:
        """Time since the link began to move [s], (n,)."""
        return self.states[TIME]

    @property
    def load(self) -> Array:
        """Sum of the normal forces on teeth or jaws [N], (n,)."""
        return self.seen["load"][0]

    @property
    def speed(self) -> Array:
        """Speed of the output [rad/s], (n,)."""
        return self.states[FREE + OUTPUT]

    @property
    def link_deg(self) -> Array:
        """Angle of the link [deg], (n,)."""
        return np.degrees(self.seen["link"][0])

    @property
    def ahead(self) -> Array:
        """Rotation of the input against the output [rad], (n,)."""
        return self.states[ANGLE] - self.states[OUTPUT]

    def energy(self) -> EnergyBalance:
        """Return supplied work, stored energy, lost work, and the imbalance of their sum [J]."""
        work = dict(zip(POWERS, self.states[WORKS:, -1] - self.states[WORKS:, 0], strict=True))
        supplied = work["input"] + work["linkage"]
        lost = sum(work.values()) - supplied
        stored = float(self.seen["energy"][0, -1] - self.seen["energy"][0, 0])
        return EnergyBalance(
            input_J=supplied, stored_J=stored, lost_J=lost, imbalance_J=supplied - stored - lost
        )

    def peak(self) -> float:
        """Return the largest load [N], searched also between the points of the grid."""
        top = max(int(np.argmax(self.load)) - 1, 0)
        close_up = integrate_motion(
            self.clutch, self.inputs, self.states[:, top], 2 * STEP, STEP / FINE, self.tolerance
        )
        return float(max(close_up.load.max(), self.load.max()))


def integrate_motion(
    clutch: ClutchDynamics,
    inputs: ContactInputs,
    start: Array,
    duration: float,
    step: float = STEP,
    tolerance: float = TOLERANCE,
) -> ContactRun:
    """Return the motion from a state (SIZE,) over a duration [s].

    Raises ComputationError if the integrator fails.
    """
    vector = inputs.vector()
    count = round(duration / step)
    motion = _integrator(clutch, count, duration, tolerance)
    ran = motion(x0=start, p=vector)["x"]
    states = np.column_stack([start, ran])
    return ContactRun(clutch, inputs, states, clutch.columns(states, vector), tolerance)


def _integrator(clutch: ClutchDynamics, count: int, duration: float, tolerance: float) -> Kernel:
    options = {
        "reltol": tolerance,
        "abstol": 1e-3 * tolerance,
        "max_step_size": min(LONGEST, duration),
        "max_num_steps": 10_000_000,
    }
    grid = np.linspace(0, duration, count + 1)[1:]
    solver = ca.integrator("motion", "cvodes", clutch.dae, 0, grid, options)
    start, p = ca.MX.sym("x0", clutch.dae["x"].shape[0]), ca.MX.sym("p", clutch.dae["p"].shape[0])
    return Kernel(
        ca.Function(
            f"{clutch.name}_motion", [start, p], [solver(x0=start, p=p)["xf"]], ["x0", "p"], ["x"]
        )
    )


def find_clear_state(
    clutch: ClutchDynamics, inputs: ContactInputs, phase: float, time: float
) -> Array:
    """Return a state (SIZE,) at rest with the input at `phase` [rad], the body as far as possible
    from every surface.

    Raises ComputationError if teeth, shaft and sleeve leave the body no clearance.
    """
    state = np.zeros(SIZE)
    state[TRAVEL], state[ANGLE], state[TIME] = inputs.travel, phase, time
    vector = inputs.vector()

    def depth(place: Array) -> float:
        state[:2] = place * 1e-3
        return -1e3 * float(clutch.columns(state, vector)["gaps"][:-FIXED].min())

    searches = [
        scipy.optimize.minimize(depth, start, method="Nelder-Mead", options=SEARCH)
        for start in _starts()
    ]
    best = min(searches, key=lambda search: float(search.fun))
    if best.fun > 0:
        raise ComputationError(
            f"the {clutch.name} clutch cannot be cut off at an input angle of "
            f"{np.degrees(phase):.6g} deg: "
            f"in every position of the body, surfaces overlap by {best.fun:.3g} mm"
        )
    state[:2] = best.x * 1e-3
    return state


def coaxial_overlap(clutch: ClutchDynamics, inputs: ContactInputs) -> float:
    """Return the smallest overlap [m] of teeth and shaft over all rotations of the centred body, 0
    without overlap.
    """
    states = np.zeros((SIZE, ROTATIONS))
    states[ANGLE] = np.linspace(0, clutch.pitch, ROTATIONS)
    gaps = clutch.columns(states, inputs.vector())["gaps"][: clutch.carriers]
    return max(0.0, -float(gaps.min(axis=0).max()))


def min_root_radius(inputs: ContactInputs) -> float:
    """Return the smallest root radius [m] at which teeth pass the corners: a tip on a corner lifts
    the body.
    """
    model = formulas.load(REULEAUX)
    return model.at("clear", tooth_shape=inputs.packed(model.entries("tooth_shape")))["least_root"]


ROTATIONS = 1201
"""Rotations tried over the pitch of the teeth."""
FIXED = 2
"""Contacts that the body's place does not bear on, the last of a clutch's: bearing and linkage."""
SEARCH = {"xatol": 1e-7, "fatol": 1e-7}


def _starts() -> Array:
    """Eccentricities [mm] from where the search begins."""
    angles = np.arange(6) * np.pi / 3
    return np.vstack([np.zeros(2), 0.4 * np.column_stack([np.cos(angles), np.sin(angles)])])


def restart_state(run_end: Array) -> Array:
    """Return the end of a motion as the start of the next, with clock and works reset to zero."""
    state = run_end.copy()
    state[TIME], state[WORKS:] = 0.0, 0.0
    return state


Mask = NDArray[np.bool_]

SETTLE_S, CALM_S = 0.02, 0.1
"""Time before the link first moves, and after everything should have happened [s]."""
SPARE = 1.2
"""Pitches of teeth or jaws that the input turns through after the link has come to rest, so that
they meet.
"""
BAND = 0.02
"""Share of the input speed within which the output counts as engaged, or as at rest."""


@dataclass(frozen=True)
class SwitchingRun:
    """Engagement, then cut-off from where it ended."""

    engagement: ContactRun
    cut_off: ContactRun

    def energy(self) -> EnergyBalance:
        """Return the energy balance of engagement and cut-off together [J]."""
        return sum_energies([self.engagement.energy(), self.cut_off.energy()])

    def to_result(self) -> ClutchLoads:
        """Return loads, impacts, slips, times and energy as the command reports them."""
        first = self.engagement
        passed = find_slips(first)
        return ClutchLoads(
            outcome=classify_engagement(first),
            N_max_N=first.peak(),
            N_single_max_N=float(first.seen["normal"][: first.clutch.carriers].max()),
            N_end_N=float(first.load[-1]),
            impacts=count_impacts(first),
            slips=len(passed),
            first_slip_s=float(passed[0]) if len(passed) else None,
            engaged_s=engagement_time(first),
            cut_off_s=rest_time(self.cut_off),
            cut_off_N_max_N=float(self.cut_off.load.max()),
            energy=self.energy(),
        )


def simulate_engagement(
    clutch: ClutchDynamics, inputs: ContactInputs, phase: float, tolerance: float = TOLERANCE
) -> ContactRun:
    """Return the engagement from the input at `phase` [rad], output at rest, until teeth or jaws
    rest again.

    Raises ComputationError if the body has no clearance, surfaces overlap too far, or the
    integrator fails.
    """
    begin = find_clear_state(clutch, inputs, phase, -SETTLE_S)
    duration = SETTLE_S + inputs.switching_s + SPARE * clutch.pitch / inputs.input_speed + CALM_S
    run = integrate_motion(clutch, inputs, begin, duration, tolerance=tolerance)
    depth, deepest = (
        -float(run.seen["gaps"][: clutch.carriers].min()),
        min(inputs.fillet, inputs.edge),
    )
    if depth > deepest:
        raise ComputationError(
            f"{clutch.name} clutch: surfaces go {depth * 1e3:.3g} mm deep into each other, which "
            f"must be less than the {deepest * 1e3:.3g} mm of their rounding: "
            f"contact.stiffness_N_m15 = {inputs.stiffness:g} is too small"
        )
    return run


def simulate_switching(clutch: ClutchDynamics, inputs: ContactInputs, phase: float) -> SwitchingRun:
    """Return engagement and cut-off. Raises ComputationError as `simulate_engagement` does."""
    first = simulate_engagement(clutch, inputs, phase)
    begin = restart_state(first.states[:, -1])
    return SwitchingRun(
        first, integrate_motion(clutch, inputs.back(), begin, inputs.switching_s + CALM_S)
    )


def count_impacts(run: ContactRun) -> int:
    """Return the number of times that the load rises from zero once the link moves."""
    load = run.load[run.time >= 0]
    return int(np.count_nonzero((load[1:] > 0) & (load[:-1] == 0)))


def find_slips(run: ContactRun) -> Array:
    """Return the times [s] at which teeth in reach pass the corners of the shaft, or jaws the tips
    of opposite jaws.

    They should hold from the time on at which the sleeve has come as far as the clutch can carry
    anything.
    """
    reach = run.inputs.lock_travel if run.clutch.name == "reuleaux" else run.inputs.depth
    since = np.maximum.accumulate(run.states[TRAVEL] <= reach)
    passed = np.floor(run.ahead / run.clutch.pitch)
    return run.time[1:][(np.diff(passed) > 0) & since[1:]]


def engagement_time(run: ContactRun) -> float | None:
    """Return the time from which the output runs at the speed of the input [s], or None if it does
    not.
    """
    speed = run.inputs.input_speed
    return _for_good(run, np.abs(run.speed - speed) <= BAND * speed)


def rest_time(run: ContactRun) -> float | None:
    """Return the time from which the output is at rest [s], or None if it is not."""
    return _for_good(run, np.abs(run.speed) <= BAND * run.inputs.input_speed)


STAYS = 0.5
"""Share of the largest load that is left of an impact at most: what is left is what the torque
needs.
"""


def classify_engagement(run: ContactRun) -> Outcome:
    """Return what the largest load of an engagement is."""
    needs_load = run.inputs.load > 0
    if engagement_time(run) is None or (needs_load and not run.load[-1] > 0):
        return "no engagement"
    if run.load[-1] < STAYS * run.load.max():
        return "impact"
    return "jam" if coaxial_overlap(run.clutch, run.inputs) > 0 else "held load"


def compare_loads(reuleaux: float, dog: float, outcomes: tuple[Outcome, Outcome]) -> float | None:
    """Return the ratio of two largest loads, Reuleaux over dog, None if they are of two kinds or of
    no engagement.
    """
    return reuleaux / dog if outcomes[0] == outcomes[1] != "no engagement" else None


def _for_good(run: ContactRun, holds: Mask) -> float | None:
    last = np.flatnonzero(~holds)
    if not len(last):
        return float(run.time[0])
    return float(run.time[last[-1] + 1]) if last[-1] + 1 < len(holds) else None


def sum_energies(parts: Sequence[EnergyBalance]) -> EnergyBalance:
    """Return the sums of energy balances, key by key."""
    return EnergyBalance(*(float(sum(values)) for values in zip(*map(astuple, parts), strict=True)))


VARIED: dict[str, tuple[str, ...]] = {
    "stiffness": ("stiffness",),
    "gap": ("backlash", "fit"),
    "speed": ("input_speed", "load_speed"),
    "inertia": ("inertia",),
    "lock": ("lock",),
}
"""Undisclosed inputs that the ratio is followed over, each with the fields that it stands for.

The gap is that of the jaws and of their fit; the teeth have none that could be varied so: with less
room in the sleeve, they could not be cut off.
"""
PHASES_DEG = (18.0, 36.0, 54.0)
"""Angles by which the input is turned on, to see what the moment of switching does to the loads."""
BRIEF_TOLERANCE = 1e-6
"""Relative tolerance of the integrator for sensitivity and phases."""


@dataclass(frozen=True)
class Comparison:
    """Both clutches' motions, and the result as the command reports it."""

    runs: dict[str, SwitchingRun]
    result: ContactEngagement


def compare_clutches(
    file: ClutchFile,
    shape: str = PAPERS,
    factors: Sequence[float] | None = None,
    progress: Listener | None = None,
    keep: Callable[[dict[str, Any]], None] | None = None,
) -> Comparison:
    """Return the motions and loads of both clutches under the inputs of a clutch file, the shaft
    bending in a shape.

    `keep` takes the table of the motions that are there, in the keys of the result, after each of
    them. Raises InputError for inconsistent values, ComputationError if a motion cannot be
    integrated, and Interrupted, both with that table as `partial`, if the user stops the motions.
    """
    contact_inputs, phase = build_contact_inputs(file, shape), file.si("contact.phase_deg")
    clutches = {
        "reuleaux": contact_dynamics.build_reuleaux(),
        "dog": contact_dynamics.build_dog(file.dog.jaws),
    }
    multipliers = FACTORS if factors is None else factors
    todo = len(clutches) + len(VARIED) * len(multipliers) + len(PHASES_DEG)
    steps = ProgressPhase("engage", "motion", todo, progress)
    runs: dict[str, SwitchingRun] = {}
    varied: list[ContactLoadSensitivity] = []
    phases: list[PhaseLoads] = []

    def build_table() -> dict[str, Any]:
        loads = {name: run.to_result().table() for name, run in runs.items()}
        rows = {
            "sensitivity": [row.table() for row in varied],
            "phases": [row.table() for row in phases],
        }
        return {
            "clutch": file.name,
            "mode": "contact",
            "motions": steps.done,
            "of_motions": todo,
            **loads,
            **rows,
        }

    def advance(note: str) -> None:
        steps.advance(note)
        if keep is not None:
            keep(build_table())

    try:
        for name, clutch in clutches.items():
            runs[name] = simulate_switching(clutch, contact_inputs, phase)
            advance(f"{name} clutch: engagement and cut-off")
        for (name, fields), factor in itertools.product(VARIED.items(), multipliers):
            loads = _loads(clutches, contact_inputs.times(factor, *fields), phase)
            varied.append(ContactLoadSensitivity(*loads, name, factor))
            advance(f"{name} times {factor:.3g}")
        for later in PHASES_DEG:
            at = file.contact.phase_deg + later
            phases.append(PhaseLoads(*_loads(clutches, contact_inputs, math.radians(at)), at))
            advance(f"input at {at:g} deg")
    except KeyboardInterrupt:
        raise Interrupted(build_table() if runs else None) from None
    except ComputationError as error:
        error.partial = build_table() if runs else None
        raise
    reuleaux, dog = (runs[name].to_result() for name in ("reuleaux", "dog"))
    result = ContactEngagement(
        clutch=file.name,
        mode="contact",
        reuleaux=reuleaux,
        dog=dog,
        N_max_ratio=compare_loads(reuleaux.N_max_N, dog.N_max_N, (reuleaux.outcome, dog.outcome)),
        energy=sum_energies([run.energy() for run in runs.values()]),
        sensitivity=varied,
        phases=phases,
        teeth=TeethInSleeve(
            coaxial_overlap_mm=1e3 * coaxial_overlap(clutches["reuleaux"], contact_inputs),
            root_least_mm=1e3 * min_root_radius(contact_inputs),
        ),
        assumptions=contact_dynamics.list_assumptions(),
    )
    return Comparison(runs, result)


def _loads(
    clutches: dict[str, contact_dynamics.ClutchDynamics],
    contact_inputs: ContactInputs,
    phase: float,
) -> tuple[float | None, float, Outcome, float, Outcome]:
    """Return the ratio of the largest loads, Reuleaux over dog, and both loads [N] with what they
    are.
    """
    reuleaux, dog = (
        simulate_engagement(clutches[name], contact_inputs, phase, BRIEF_TOLERANCE)
        for name in ("reuleaux", "dog")
    )
    outcomes = classify_engagement(reuleaux), classify_engagement(dog)
    loads = float(reuleaux.load.max()), float(dog.load.max())
    return compare_loads(*loads, outcomes), loads[0], outcomes[0], loads[1], outcomes[1]
