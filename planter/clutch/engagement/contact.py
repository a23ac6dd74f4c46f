"""Comparison of the Reuleaux clutch with a dog clutch: engagement and cut-off with the same inputs but geometry.

The paper's loads (428.5 N, 961.6 N) depend on inputs that it does not disclose. The results here are for stated
inputs, with the sensitivity of the ratio of the two clutches to each of them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from planter.clutch.engagement import dynamics, modal, motion
from planter.clutch.engagement.inputs import ContactInputs, build_contact_inputs
from planter.clutch.engagement.modal import FACTORS
from planter.clutch.engagement.motion import SwitchingRun, simulate_engagement, simulate_switching, sum_energies
from planter.clutch.file import ClutchFile as File
from planter.clutch.results.engagement import ContactEngagement, ContactLoadSensitivity, PhaseLoads, TeethInSleeve
from planter.progress import Listener, ProgressPhase

VARIED: dict[str, tuple[str, ...]] = {
    "stiffness": ("stiffness",),
    "gap": ("backlash", "fit"),
    "speed": ("input_speed", "load_speed"),
    "inertia": ("inertia",),
    "lock": ("lock",),
}
"""Undisclosed inputs that the ratio is followed over, each with the fields that it stands for.

The gap is that of the jaws and of their fit; the teeth have none that could be varied so: with less room in the
sleeve, they could not be cut off.
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
    file: File, shape: str = modal.PAPERS, factors: Sequence[float] | None = None, progress: Listener | None = None
) -> Comparison:
    """Return the motions and loads of both clutches under the inputs of a clutch file, the shaft bending in a shape.

    Raises InputError for inconsistent values, ComputationError if a motion cannot be integrated.
    """
    contact_inputs, phase = build_contact_inputs(file, shape), file.si("contact.phase_deg")
    clutches = {"reuleaux": dynamics.build_reuleaux(), "dog": dynamics.build_dog(file.dog.jaws)}
    multipliers = FACTORS if factors is None else factors
    todo = len(clutches) + len(VARIED) * len(multipliers) + len(PHASES_DEG)
    steps = ProgressPhase("engage", "motion", todo, progress)
    runs: dict[str, SwitchingRun] = {}
    for name, clutch in clutches.items():
        runs[name] = simulate_switching(clutch, contact_inputs, phase)
        steps.advance(f"{name} clutch: engagement and cut-off")
    varied: list[ContactLoadSensitivity] = []
    for (name, fields), factor in itertools.product(VARIED.items(), multipliers):
        varied.append(
            ContactLoadSensitivity(name, factor, *_loads(clutches, contact_inputs.times(factor, *fields), phase))
        )
        steps.advance(f"{name} times {factor:.3g}")
    phases: list[PhaseLoads] = []
    for later in PHASES_DEG:
        at = file.contact.phase_deg + later
        phases.append(PhaseLoads(at, *_loads(clutches, contact_inputs, math.radians(at))))
        steps.advance(f"input at {at:g} deg")
    reuleaux, dog = (runs[name].to_result() for name in ("reuleaux", "dog"))
    result = ContactEngagement(
        clutch=file.name,
        mode="contact",
        reuleaux=reuleaux,
        dog=dog,
        N_max_ratio=reuleaux.N_max_N / dog.N_max_N,
        energy=sum_energies([run.energy() for run in runs.values()]),
        sensitivity=varied,
        phases=phases,
        teeth=TeethInSleeve(
            coaxial_overlap_mm=1e3 * motion.coaxial_overlap(clutches["reuleaux"], contact_inputs),
            root_least_mm=1e3 * motion.min_root_radius(contact_inputs),
        ),
        assumptions=dynamics.list_assumptions(),
    )
    return Comparison(runs, result)


def _loads(
    clutches: dict[str, dynamics.ClutchDynamics], contact_inputs: ContactInputs, phase: float
) -> tuple[float, float, float]:
    """Return the ratio of the largest loads, Reuleaux over dog, and both loads [N]."""
    reuleaux, dog = (
        float(simulate_engagement(clutches[name], contact_inputs, phase, BRIEF_TOLERANCE).load.max())
        for name in ("reuleaux", "dog")
    )
    return reuleaux / dog, reuleaux, dog
