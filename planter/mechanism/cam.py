"""A disc cam of a user-defined mechanism as a part: contour for a roller, from the path of the roller's centre."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.errors import ComputationError, InputError
from planter.files import paths, units
from planter.files.csv_rows import parse_number
from planter.files.spelling import find_spelled
from planter.kernels import Array, formulas
from planter.mechanism.model import Model, require_repeating
from planter.numerics.arrays import TURN
from planter.workshop import solids
from planter.workshop.cam import Columns, Profile, Push, build_cam_part, check_roller, find_lift_off
from planter.workshop.cam_report import CamOutput, CamPageContent
from planter.workshop.drawing import Bore

FORMULAS = "disc_cam"
FOLLOWERS = "followers"
CLOSED = 1e-9
"""Largest distance [m] between the ends of a closed contour."""
PIECES = 12
"""Pieces of a cycle. Arcs and splines also follow a law that is not smooth within a piece."""
_STEP = 2e-3
"""Step of the angle [rad] of finite differences: of fourth order, accurate to 1e-9 for a smooth law."""
_OFFSETS = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
_SLOPE = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12 * _STEP)
_CURVATURE = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12 * _STEP**2)

LengthFunction = Callable[[dict[str, Array], int], Array]
"""(results of n angles by name, n) -> lengths (n,) [m]."""


def build_profile(model: Model, roller: float, x: str, y: str) -> Profile:
    """Return the cam that turns by the mechanism's angle about the origin, for a roller whose centre is at x, y.

    Each is a sum of terms such as `y_0 + s`: lengths of the cycle, values of the file, numbers in mm. `roller` [m].
    Raises InputError for any other term, GeometryError, from `Profile.check`, for too large a roller,
    ComputationError for a length that does not repeat after a cycle: it closes no contour.
    """
    check_roller(roller)
    centre, disc = [_parse_sum(model, "--x", x), _parse_sum(model, "--y", y)], formulas.load(FORMULAS)
    terms = {term.strip() for text in (x, y) for term in text.split("+")}
    require_repeating(model.machine, terms & {q.name for q in model.machine.results if q.unit == "m"})
    for name, (start, end) in model.evaluate(FOLLOWERS, np.array([0.0, TURN])).items():
        if name in terms and abs(end - start) > CLOSED:
            raise ComputationError(f"{model.machine.name}: {name} differs after a turn: it closes no contour")

    def evaluate(angles: Array) -> Columns:
        stencil = (angles[:, None] + _STEP * _OFFSETS).ravel() % (2 * np.pi)
        lengths = model(stencil) | model.evaluate(FOLLOWERS, stencil)
        values = [length(lengths, len(stencil)).reshape(-1, len(_OFFSETS)) for length in centre]
        path = [*(v[:, 2] for v in values), *(v @ _SLOPE for v in values), *(v @ _CURVATURE for v in values)]
        return disc("disc", phi=angles, centre=np.array(path), reach=-roller)

    breaks = tuple(np.linspace(0.0, 2 * np.pi, PIECES + 1).tolist())
    return Profile(model.machine.name, roller, evaluate, breaks, True, ("pitch_x", "pitch_y"))


def build_disc_cam(
    model: Model, roller: float, centre: tuple[str, str], force: str | None, tolerance: float, width: float, bore: float
) -> CamOutput:
    """Return the disc of a `width` with a bore [m], for a roller whose centre is at the sums `centre`, x and y.

    Raises InputError and GeometryError as `build_profile` and `find_contact_force` do, and for too large a bore.
    """
    profile, hole = build_profile(model, roller, *centre), Bore(bore) if bore else None
    contact_force = find_contact_force(model, force) if force is not None else None
    lift_off = find_lift_off(contact_force, model.speed) if contact_force is not None else None
    machine, sidecar = model.machine, formulas.load(FORMULAS).sidecar
    content = CamPageContent(machine.document, machine.meanings, sidecar, contact_force, model.speed)
    holes = [hole.edge] if hole else []
    disc = build_cam_part(profile, "disc", tolerance, lift_off, model.speed, width, hole)
    return CamOutput(disc, content, lambda: solids.format_prism(f"cam of {machine.name}", profile.pieces, holes, width))


def find_follower_centre(model: Model, force: str | None) -> tuple[tuple[str, str], str]:
    """Return the sums for the centre of the roller, x and y, of a follower of the statement, and its contact force.

    Raises InputError if the statement has no follower, or several and `force` names none of them.
    """
    source = model.machine.source
    names = [quantity.name.removesuffix("_centre_x") for quantity in _list_centres(model.machine)[::2]]
    if not names:
        raise InputError(f"{source}: its statement has no follower of a cam: add --y for the centre of the roller")
    if force is None and len(names) > 1:
        raise InputError(f"{source}: add --force to choose one of its followers: {', '.join(names)}")
    name = names[0] if force is None else force
    if name not in names:
        raise _refuse_name("--force", name, names)
    return (f"{name}_centre_x", f"{name}_centre_y"), name


def _list_centres(machine: Machine) -> tuple[Quantity, ...]:
    return machine.stages[FOLLOWERS].quantities if FOLLOWERS in machine.stages else ()


def find_contact_force(model: Model, name: str) -> Push:
    """Return a contact force of the cycle as a function of angle and speed. Raises InputError for an unknown name."""
    machine = model.machine
    forces = [quantity.name for quantity in machine.results if quantity.unit == "N"]
    if name not in forces:
        raise _refuse_name("--force", name, forces)

    def evaluate(angles: Array, speed: float) -> Array:
        data = machine.data.copy()
        data[machine.speed] = speed
        return Model(machine, data)(angles % (2 * np.pi))[name]

    return evaluate


def _parse_sum(model: Model, option: str, text: str) -> LengthFunction:
    terms = [_parse_term(model.machine, option, term.strip()) for term in text.split("+")]
    return lambda results, count: np.sum([term(results, count) for term in terms], axis=0)


def _parse_term(machine: Machine, option: str, term: str) -> LengthFunction:
    lengths = [q.name for q in (*machine.results, *_list_centres(machine)) if q.unit == "m"]
    values = {v.name: value for v, value in zip(machine.values, machine.data.tolist(), strict=True) if v.unit == "m"}
    parsed = parse_number(term)
    matches = find_spelled(term, {name: (name, f"{name}_mm") for name in lengths})
    if len(matches) == 1:
        return lambda results, count: results[matches[0]]
    if term in values or (parsed is not None and np.isfinite(parsed)):
        constant = values[term] if parsed is None else parsed * units.unit_factor("_mm")
        return lambda results, count: np.full(count, constant)
    raise _refuse_name(option, term, [*lengths, *values])


def _refuse_name(option: str, name: str, names: list[str]) -> InputError:
    close = paths.find_similar(name, names)
    hint = f"did you mean {close[0]}? " if close else ""
    return InputError.for_value(option, name, f"{hint}there are {', '.join(names)}")
