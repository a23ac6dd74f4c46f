"""Motion of a clutch in contact at engagement and cut-off, and the comparison with a dog clutch."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

from planter.errors import ComputationError, Interrupted
from planter.kernels import Array, Kernel, formulas
from planter.numerics.arrays import unit_vector
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.modal_engagement import FACTORS, PAPERS, build_engagement
from planter.papers.clutch.model import (
    SIDES,
    VERTICES,
    CrankLinkage,
    collect_values,
    drive_link,
    load_model,
)
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

Inputs = dict[str, float]
"""Inputs of both clutches by `NAMES`, in SI units and radians; they may vary without rebuilding the
model.
"""
PATHS = {
    "stiffness": "contact.stiffness_N_m15",
    "dissipation": "contact.dissipation_s_m",
    "friction": "sleeve.friction",
    "slip_speed": "contact.slip_speed_mm_s",
    "body": "engagement.body_kg",
    "sleeve": "contact.sleeve_kg",
    "inertia": "contact.output_inertia_kg_m2",
    "load": "engagement.load_Nm",
    "input_speed": "engagement.input_speed_rpm",
    "preload": "sleeve.spring_preload_N",
    "spring_rate": "contact.spring_rate_N_m",
    "slide": "contact.slide_N",
    "lock": "contact.lock_N",
    "lock_travel": "contact.lock_travel_mm",
    "lock_stiffness": "contact.lock_stiffness_N_m",
    "travel": "sleeve.travel_mm",
    "taper": "sleeve.axial_angle_deg",
    "tip": "tooth.tip_mm",
    "root": "tooth.root_mm",
    "fillet": "shaft.fillet_mm",
    "radius": "engagement.contact_radius_mm",
    "edge": "dog.edge_mm",
    "depth": "dog.depth_mm",
    "fit": "dog.fit_mm",
}
"""Inputs that stand in the file, with their paths."""
COMPUTED: tuple[str, ...] = (
    "load_speed",
    "shaft_mass",
    "shaft_stiffness",
    "shaft_damping",
    "k",
    "gamma",
)
COMPUTED += ("l_AB", "l_BC", "l_AC", "link_speed", "link_start", "link_end")
COMPUTED += ("width", "hole", "apothem", "backlash", "push_x", "push_y")
"""Inputs that follow from the file; `push_x` and `push_y` are a force on the body that no clutch
has, for limits in which there is a closed form.
"""
NAMES = (*PATHS, *COMPUTED)
"""Names of the inputs as the derivation has them, in the order of their vector."""


def pack(inputs: Inputs, names: Iterable[str] = NAMES) -> list[float]:
    """Return inputs in the order of names."""
    return [inputs[name] for name in names]


def scale_inputs(inputs: Inputs, factor: float, *names: str) -> Inputs:
    """Return a copy with some inputs multiplied by a factor."""
    return inputs | {name: factor * inputs[name] for name in names}


def switching_time(inputs: Inputs) -> float:
    """Return the duration of the link's motion from start to end [s]."""
    return abs(inputs["link_end"] - inputs["link_start"]) / inputs["link_speed"]


LONGEST_S = 3.0
"""Longest time that jaws may take to meet, and the sleeve to make its travel [s]."""
LOAD_SPEED = 0.01
"""Share of the input speed at which the load torque has 1/sqrt(2) of its value: below, it fades to
none at rest.
"""


def _check(clutch: ClutchFile) -> None:
    tooth, dog, sleeve = clutch.tooth, clutch.dog, clutch.sleeve
    turns, way = 60 / dog.jaws / LONGEST_S, sleeve.travel_mm / LONGEST_S
    period = f"within {LONGEST_S:g} s"
    rows = {
        "tooth.root_mm": (
            tooth.root_mm > tooth.tip_mm,
            f"greater than tooth.tip_mm = {tooth.tip_mm:g}",
        ),
        "dog.depth_mm": (
            dog.depth_mm < sleeve.travel_mm,
            f"less than sleeve.travel_mm = {sleeve.travel_mm:g}, so that jaws come apart",
        ),
        "engagement.input_speed_rpm": (
            clutch.engagement.input_speed_rpm >= turns,
            f"at least {turns:g}, so that jaws meet {period}",
        ),
        "sleeve.switching_speed_mm_s": (
            sleeve.switching_speed_mm_s >= way,
            f"at least {way:g}, so that the sleeve is there {period}",
        ),
    }
    for path, (is_met, allowed) in rows.items():
        if not is_met:
            raise clutch.input_error(path, f"it must be {allowed}")


def build_contact_inputs(clutch: ClutchFile, shape: str = PAPERS) -> Inputs:
    """Return the inputs of an engagement from a clutch file; the link falls from its limit to the
    horizontal.

    The link moves at the speed that gives the sleeve the mean speed of the file. Raises InputError
    for a linkage that does not close over the travel, teeth or jaws that cannot be, or a motion
    that takes too long.
    """
    si = clutch.si
    _check(clutch)
    inputs = {name: si(path) for name, path in PATHS.items()}
    values, travel = collect_values(clutch), inputs["travel"]
    linkage = CrankLinkage.from_lengths(clutch.linkage)
    linkage.check(travel, f"{clutch.source}: linkage.rod_mm")
    drive = drive_link(values, linkage.rotation(travel))
    mode = build_engagement(si, shape)
    bending = {"shaft_mass": mode["M_1"], "shaft_stiffness": mode["K_1"]}
    share = si("contact.shaft_damping")
    width = load_model().at("polygon", a=values["a"])["R"]
    return {
        **inputs,
        **bending,
        **formulas.load(MOTION).at("damping", damping_share=share, **bending),
        "load_speed": inputs["input_speed"] * LOAD_SPEED,
        "k": values["k"],
        "gamma": values["gamma"],
        "l_AB": linkage.crank,
        "l_BC": linkage.rod,
        "l_AC": linkage.distance,
        "link_speed": drive["lift"] * si("sleeve.switching_speed_mm_s") / travel,
        "link_start": drive["alpha_max"],
        "link_end": 0.0,
        "width": width,
        "hole": width / 2 + si("contact.sleeve_gap_mm"),
        "apothem": si("shaft.flat_to_flat_mm") / 2,
        "backlash": si("dog.backlash_deg") * inputs["radius"],
        "push_x": 0.0,
        "push_y": 0.0,
    }


FREE = 6
"""Degrees of freedom: body x, y; sleeve's travel; output rotation; shaft end x, y."""
POWERS = ("input", "linkage", "load", "damping", "friction", "slides", "shaft")
"""Works that are integrated beside the motion: two go in, the others are lost."""
ANGLE, TIME, BENT, WORKS = 2 * FREE, 2 * FREE + 1, 2 * FREE + 2, 2 * FREE + 4
SIZE = WORKS + len(POWERS)
"""A state: coordinates, their rates, input angle, time, the coupling's bristles (2), works."""
TRAVEL, OUTPUT = 2, 3
SMALL = {"least_depth": 1e-30, "core": 1e-9, "creep": 1e-6}
"""Lengths [m] and a speed [m/s] that keep slopes finite: of no depth, of no eccentricity, of no
sliding.
"""


def list_assumptions() -> list[str]:
    """Return the assumptions of the contact model of both clutches."""
    return [
        text
        for model in (MOTION, REULEAUX, DOG)
        for text in formulas.load(model).sidecar["assumptions"]
    ]


@dataclass(frozen=True)
class ClutchDynamics:
    """A clutch in contact: its right-hand side as symbols, and what can be seen of a state.

    `carriers` counts the contacts that carry the load, teeth or jaws; after a turn of `pitch` [rad]
    they look alike.
    """

    name: str
    carriers: int
    pitch: float
    dae: dict[str, ca.SX]
    seen: Kernel

    def columns(self, states: Array, inputs: Inputs) -> dict[str, Array]:
        """Return the observed quantities of states (SIZE, n): rows by name."""
        return self.seen(x=states, p=pack(inputs))


@cache
def build_reuleaux() -> ClutchDynamics:
    """Return the dynamics of the Reuleaux clutch."""
    teeth = Contact(REULEAUX, "tooth", VERTICES), Contact(REULEAUX, "side", SIDES)
    return _clutch("reuleaux", teeth, math.lcm(VERTICES, SIDES))


@cache
def build_dog(count: int) -> ClutchDynamics:
    """Return the dynamics of a dog clutch with `count` jaws on each half."""
    return _clutch("dog", (Contact(DOG, "jaw", count), Contact(DOG, "fit")), count, jaws=count)


def _clutch(name: str, kinds: Sequence[Contact], alike: int, **fixed: float) -> ClutchDynamics:
    """Return the clutch with some contacts; it repeats `alike` times per revolution; `fixed` are
    constants.
    """
    model = formulas.load(MOTION)
    x, p = ca.SX.sym("x", SIZE), ca.SX.sym("p", len(NAMES))
    values = {key: ca.SX(value) for key, value in (SMALL | fixed).items()}
    values |= dict(zip(NAMES, ca.vertsplit(p), strict=True)) | _state(x)
    values |= {"angle_dot": values["input_speed"]} | model.composed(
        "course", {**values, "t": x[TIME]}
    )
    gaps, normal, sums = combine_contacts((*kinds, *SHARED), values)
    rates = model.composed("motion", values | sums)
    places = model.entries("places")
    ode = ca.vertcat(
        x[FREE : 2 * FREE],
        *(rates[f"{place}_ddot"] for place in places[:FREE]),
        values["angle_dot"],
        1,
        *(rates[f"{bent}_dot"] for bent in model.entries("bristles")),
        *(rates[f"power_{power}"] for power in POWERS),
    )
    carriers = kinds[0].count
    observed = {
        "load": ca.sum1(normal[:carriers]),
        "normal": normal,
        "gaps": gaps,
        "generalised": ca.vertcat(*(sums[f"on_{place}"] for place in places)),
        "energy": rates["energy"],
        "link": values["link_angle"],
        "pushed": values["pushed"],
    }
    seen = ca.Function(
        f"{name}_seen", [x, p], ca.cse(list(observed.values())), ["x", "p"], list(observed)
    )
    dae = {"x": x, "p": p, "ode": ca.cse(ode)}
    return ClutchDynamics(name, carriers, 2 * math.pi / alike, dae, Kernel(seen, lanes=("x",)))


def _state(x: ca.SX) -> dict[str, ca.SX]:
    """Places, rates and bristles of a state by the names of the derivation."""
    model = formulas.load(MOTION)
    free = model.entries("places")[:FREE]
    names = [*free, *(f"{place}_dot" for place in free), "angle", "t", *model.entries("bristles")]
    return dict(zip(names, ca.vertsplit(x[:WORKS]), strict=True))


MOTION, REULEAUX, DOG = "clutch_motion", "clutch_contact_reuleaux", "clutch_contact_dog"
"""Generated models: of what both clutches share, and of the contacts of each."""


@dataclass(frozen=True)
class Contact:
    """A kind of contact: its model, the function of one, and how many there are."""

    model: str
    name: str
    count: int = 1


SHARED = (Contact(MOTION, "bearing"), Contact(MOTION, "linkage"))


def combine_contacts(
    contacts: Sequence[Contact], values: Mapping[str, ca.SX]
) -> tuple[ca.SX, ca.SX, dict[str, ca.SX]]:
    """Return signed distances [m] and normal forces [N] of all contacts, and the sums of their
    other results by name.

    `values` are positions, rates, contact law and sizes of the clutch by name.
    """
    contributions = [
        formulas.load(contact.model).composed(contact.name, {**values, "index": ca.SX(index)})
        for contact in contacts
        for index in range(contact.count)
    ]
    gaps = ca.vertcat(*(contribution.pop("gap") for contribution in contributions))
    normal = ca.vertcat(*(contribution.pop("normal") for contribution in contributions))
    sums = {name: sum(part[name] for part in contributions) for name in contributions[0]}
    return gaps, normal, sums


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
    inputs: Inputs
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
    inputs: Inputs,
    start: Array,
    duration: float,
    step: float = STEP,
    tolerance: float = TOLERANCE,
) -> ContactRun:
    """Return the motion from a state (SIZE,) over a duration [s].

    Raises ComputationError if the integrator fails.
    """
    count = round(duration / step)
    motion = _integrator(clutch, count, duration, tolerance)
    ran = motion(x0=start, p=pack(inputs))["x"]
    states = np.column_stack([start, ran])
    return ContactRun(clutch, inputs, states, clutch.columns(states, inputs), tolerance)


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


def find_clear_state(clutch: ClutchDynamics, inputs: Inputs, phase: float, time: float) -> Array:
    """Return a state (SIZE,) at rest with the input at `phase` [rad], the body as far as possible
    from every surface.

    Raises ComputationError if teeth, shaft and sleeve leave the body no clearance.
    """
    state = np.zeros(SIZE)
    state[TRAVEL], state[ANGLE], state[TIME] = inputs["travel"], phase, time

    def depth(place: Array) -> float:
        state[:2] = place * 1e-3
        return -1e3 * float(clutch.columns(state, inputs)["gaps"][:-FIXED].min())

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


def coaxial_overlap(clutch: ClutchDynamics, inputs: Inputs) -> float:
    """Return the smallest overlap [m] of teeth and shaft over all rotations of the centred body, 0
    without overlap.
    """
    states = np.zeros((SIZE, ROTATIONS))
    states[ANGLE] = np.linspace(0, clutch.pitch, ROTATIONS)
    gaps = clutch.columns(states, inputs)["gaps"][: clutch.carriers]
    return max(0.0, -float(gaps.min(axis=0).max()))


def min_root_radius(inputs: Inputs) -> float:
    """Return the smallest root radius [m] at which teeth pass the corners: a tip on a corner lifts
    the body.
    """
    model = formulas.load(REULEAUX)
    return model.at("clear", tooth_shape=pack(inputs, model.entries("tooth_shape")))["least_root"]


ROTATIONS = 1201
"""Rotations tried over the pitch of the teeth."""
FIXED = 2
"""Contacts that the body's place does not bear on, the last of a clutch's: bearing and linkage."""
SEARCH = {"xatol": 1e-7, "fatol": 1e-7}


def _starts() -> Array:
    """Eccentricities [mm] from where the search begins."""
    angles = np.arange(6) * np.pi / 3
    return np.vstack([np.zeros(2), 0.4 * unit_vector(angles).T])


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
    clutch: ClutchDynamics, inputs: Inputs, phase: float, tolerance: float = TOLERANCE
) -> ContactRun:
    """Return the engagement from the input at `phase` [rad], output at rest, until teeth or jaws
    rest again.

    Raises ComputationError if the body has no clearance, surfaces overlap too far, or the
    integrator fails.
    """
    begin = find_clear_state(clutch, inputs, phase, -SETTLE_S)
    duration = (
        SETTLE_S + switching_time(inputs) + SPARE * clutch.pitch / inputs["input_speed"] + CALM_S
    )
    run = integrate_motion(clutch, inputs, begin, duration, tolerance=tolerance)
    depth, deepest = (
        -float(run.seen["gaps"][: clutch.carriers].min()),
        min(inputs["fillet"], inputs["edge"]),
    )
    if depth > deepest:
        stiffness = inputs["stiffness"]
        raise ComputationError(
            f"{clutch.name} clutch: surfaces go {depth * 1e3:.3g} mm deep into each other, which "
            f"must be less than the {deepest * 1e3:.3g} mm of their rounding: "
            f"contact.stiffness_N_m15 = {stiffness:g} is too small"
        )
    return run


def simulate_switching(clutch: ClutchDynamics, inputs: Inputs, phase: float) -> SwitchingRun:
    """Return engagement and cut-off. Raises ComputationError as `simulate_engagement` does."""
    first = simulate_engagement(clutch, inputs, phase)
    begin = restart_state(first.states[:, -1])
    reverse = inputs | {"link_start": inputs["link_end"], "link_end": inputs["link_start"]}
    return SwitchingRun(
        first, integrate_motion(clutch, reverse, begin, switching_time(inputs) + CALM_S)
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
    reach = run.inputs["lock_travel"] if run.clutch.name == "reuleaux" else run.inputs["depth"]
    since = np.maximum.accumulate(run.states[TRAVEL] <= reach)
    passed = np.floor(run.ahead / run.clutch.pitch)
    return run.time[1:][(np.diff(passed) > 0) & since[1:]]


def engagement_time(run: ContactRun) -> float | None:
    """Return the time from which the output runs at the speed of the input [s], or None if it does
    not.
    """
    speed = run.inputs["input_speed"]
    return _for_good(run, np.abs(run.speed - speed) <= BAND * speed)


def rest_time(run: ContactRun) -> float | None:
    """Return the time from which the output is at rest [s], or None if it is not."""
    return _for_good(run, np.abs(run.speed) <= BAND * run.inputs["input_speed"])


STAYS = 0.5
"""Share of the largest load that is left of an impact at most: what is left is what the torque
needs.
"""


def classify_engagement(run: ContactRun) -> Outcome:
    """Return what the largest load of an engagement is."""
    needs_load = run.inputs["load"] > 0
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


def compare_clutches(
    file: ClutchFile,
    shape: str = PAPERS,
    factors: Sequence[float] | None = None,
    progress: Listener | None = None,
    keep: Callable[[dict[str, Any]], None] | None = None,
) -> tuple[ContactEngagement, dict[str, SwitchingRun]]:
    """Return the loads of both clutches under the inputs of a clutch file, the shaft bending in a
    shape, and their motions by name.

    `keep` takes the table of the motions that are there, in the keys of the result, after each of
    them. Raises InputError for inconsistent values, ComputationError if a motion cannot be
    integrated, and Interrupted, both with that table as `partial`, if the user stops the motions.
    """
    contact_inputs, phase = build_contact_inputs(file, shape), file.si("contact.phase_deg")
    clutches = {
        "reuleaux": build_reuleaux(),
        "dog": build_dog(file.dog.jaws),
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
        for (name, names), factor in itertools.product(VARIED.items(), multipliers):
            loads = _loads(clutches, scale_inputs(contact_inputs, factor, *names), phase)
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
        assumptions=list_assumptions(),
    )
    return result, runs


def _loads(
    clutches: dict[str, ClutchDynamics],
    contact_inputs: Inputs,
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
