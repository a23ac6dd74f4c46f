"""Engagement and cut-off of the Reuleaux clutch beside the dog clutch, all inputs but geometry shared.

The paper's own loads (428.5 N, 961.6 N) hang on inputs that it does not disclose: what stands here are figures for
stated inputs, and how the ratio of the two clutches moves with each of them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from planter.clutch.engage import beam, dynamics, start
from planter.clutch.engage.inputs import Inputs, inputs
from planter.clutch.engage.modal import FACTORS
from planter.clutch.engage.switching import Switching, engage, switch, total
from planter.clutch.file import Clutch as File
from planter.clutch.results.engagement import AtPhase, ContactEngagement, TeethInSleeve, VariedContact
from planter.progress import Listener, Phase

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

    runs: dict[str, Switching]
    result: ContactEngagement


def compare(
    file: File, shape: str = beam.PAPERS, factors: Sequence[float] | None = None, progress: Listener | None = None
) -> Comparison:
    """Both clutches under the inputs of a clutch file, the shaft bending in a shape.

    Raises InputError for values that do not fit, ComputationError where a motion cannot be had.
    """
    given, phase = inputs(file, shape), file.si("contact.phase_deg")
    clutches = {"reuleaux": dynamics.reuleaux(), "dog": dynamics.dog(file.dog.jaws)}
    wanted = FACTORS if factors is None else factors
    todo = len(clutches) + len(VARIED) * len(wanted) + len(PHASES_DEG)
    steps = Phase("engage", "motion", todo, progress)
    runs: dict[str, Switching] = {}
    for name, clutch in clutches.items():
        runs[name] = switch(clutch, given, phase)
        steps.next(f"{name} clutch: engagement and cut-off")
    varied: list[VariedContact] = []
    for (name, fields), factor in itertools.product(VARIED.items(), wanted):
        varied.append(VariedContact(name, factor, *_loads(clutches, given.times(factor, *fields), phase)))
        steps.next(f"{name} times {factor:.3g}")
    phases: list[AtPhase] = []
    for later in PHASES_DEG:
        at = file.contact.phase_deg + later
        phases.append(AtPhase(at, *_loads(clutches, given, math.radians(at))))
        steps.next(f"input at {at:g} deg")
    reuleaux, dog = (runs[name].shown() for name in ("reuleaux", "dog"))
    result = ContactEngagement(
        clutch=file.name,
        mode="contact",
        reuleaux=reuleaux,
        dog=dog,
        N_max_ratio=reuleaux.N_max_N / dog.N_max_N,
        energy=total([run.energy() for run in runs.values()]),
        sensitivity=varied,
        phases=phases,
        teeth=TeethInSleeve(
            coaxial_overlap_mm=1e3 * start.coaxial_overlap(clutches["reuleaux"], given),
            root_least_mm=1e3 * start.least_root(given),
        ),
        assumptions=dynamics.assumptions(),
    )
    return Comparison(runs, result)


def _loads(clutches: dict[str, dynamics.Clutch], given: Inputs, phase: float) -> tuple[float, float, float]:
    """Ratio of the largest loads, Reuleaux over dog, and both of them."""
    reuleaux, dog = (
        float(engage(clutches[name], given, phase, BRIEF_TOLERANCE).load.max()) for name in ("reuleaux", "dog")
    )
    return reuleaux / dog, reuleaux, dog
