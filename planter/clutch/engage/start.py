"""Where a motion begins: the body put where it touches nothing, sleeve drawn back, output at rest."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from planter.clutch.engage.contacts import REULEAUX
from planter.clutch.engage.dynamics import ANGLE, SIZE, TIME, TRAVEL, WORKS, Array, Clutch
from planter.clutch.engage.inputs import Inputs
from planter.errors import ComputationError
from planter.kernels import formulas


def apart(clutch: Clutch, inputs: Inputs, phase: float, time: float) -> Array:
    """A state (SIZE,) at rest with the input at `phase` [rad], the body as far from every surface as it goes.

    Raises ComputationError where teeth, shaft and sleeve leave the body no place.
    """
    state = np.zeros(SIZE)
    state[TRAVEL], state[ANGLE], state[TIME] = inputs.travel, phase, time
    vector = inputs.vector()

    def depth(place: Array) -> float:
        state[:2] = place * 1e-3
        return -1e3 * float(clutch.columns(state, vector)["gaps"][:-FIXED].min())

    tried = [minimize(depth, start, method="Nelder-Mead", options=SEARCH) for start in _starts()]
    best = min(tried, key=lambda found: float(found.fun))
    if best.fun > 0:
        raise ComputationError(
            f"the {clutch.name} clutch cannot be cut off at an input angle of {np.degrees(phase):.6g} deg: wherever "
            f"the body lies, something overlaps by {best.fun:.3g} mm"
        )
    state[:2] = best.x * 1e-3
    return state


def coaxial_overlap(clutch: Clutch, inputs: Inputs) -> float:
    """Least depth [m] to which teeth go into the shaft with the body in the middle, of all rotations; 0 where none."""
    states = np.zeros((SIZE, ROTATIONS))
    states[ANGLE] = np.linspace(0, clutch.pitch, ROTATIONS)
    gaps = clutch.columns(states, inputs.vector())["gaps"][: clutch.carriers]
    return max(0.0, -float(gaps.min(axis=0).max()))


def least_root(inputs: Inputs) -> float:
    """Least radius of a root circle [m] that lets teeth pass the corners: a tip on one lifts the body off the other."""
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


def again(run_end: Array) -> Array:
    """The end of one motion as the start of the next: clock and works begin anew."""
    state = run_end.copy()
    state[TIME], state[WORKS:] = 0.0, 0.0
    return state
