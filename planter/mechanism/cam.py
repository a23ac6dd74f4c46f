"""A disc cam of a mechanism of one's own as a part: contour for a roller, from where its centre is along the turn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.errors import ComputationError, InputError
from planter.files import paths, units
from planter.files.csv_rows import number
from planter.kernels import Array, formulas
from planter.mechanism.model import Model, require_repeating
from planter.numerics.arrays import TURN
from planter.workshop import solids
from planter.workshop.cam import Columns, Profile, Push, build_cam_part, check_roller, find_lift_off
from planter.workshop.cam_report import CamOutput, CamPageContent
from planter.workshop.drawing import Bore

FORMULAS = "disc_cam"
FOLLOWERS = "followers"
OPEN = 1e-9
"""Largest distance [m] between the ends of a contour that is closed."""
PIECES = 12
"""Pieces of a turn. Where a law is not smooth within one, arcs and splines follow it all the same."""
_STEP = 2e-3
"""Step of the angle [rad] over which derivatives are told: of fourth order, right to 1e-9 of a smooth law's."""
_AROUND = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
_SLOPE = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12 * _STEP)
_BEND = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12 * _STEP**2)

Place = Callable[[dict[str, Array], int], Array]
"""A length (n,) [m] from the results of n angles."""


def profile(model: Model, roller: float, x: str, y: str) -> Profile:
    """The cam that turns by the mechanism's angle about the origin, for a roller whose centre is at x, y of the frame.

    Each is a sum of terms such as `y_0 + s`: lengths of the turn, values of the file, numbers in mm. `roller` [m].
    Raises InputError for a term that is none of these, GeometryError, from `Profile.check`, for too large a roller,
    ComputationError for a length that does not repeat after a turn: it closes no contour.
    """
    check_roller(roller)
    places, disc = [_sum(model, "--x", x), _sum(model, "--y", y)], formulas.load(FORMULAS)
    terms = {term.strip() for text in (x, y) for term in text.split("+")}
    require_repeating(model.machine, terms & {q.name for q in model.machine.results if q.unit == "m"})
    for name, (start, end) in model.evaluate(FOLLOWERS, np.array([0.0, TURN])).items():
        if name in terms and abs(end - start) > OPEN:
            raise ComputationError(f"{model.machine.name}: {name} differs after a turn: it closes no contour")

    def course(angles: Array) -> Columns:
        near = (angles[:, None] + _STEP * _AROUND).ravel() % (2 * np.pi)
        found = model(near) | model.evaluate(FOLLOWERS, near)
        values = [place(found, len(near)).reshape(-1, len(_AROUND)) for place in places]
        centre = [*(v[:, 2] for v in values), *(v @ _SLOPE for v in values), *(v @ _BEND for v in values)]
        return disc("disc", phi=angles, centre=np.array(centre), reach=-roller)

    breaks = tuple(np.linspace(0.0, 2 * np.pi, PIECES + 1).tolist())
    return Profile(model.machine.name, roller, course, breaks, True, ("pitch_x", "pitch_y"))


def made(
    model: Model, roller: float, centre: tuple[str, str], force: str | None, tolerance: float, width: float, bore: float
) -> CamOutput:
    """The disc of a `width` with a bore [m], for a roller whose centre is at the sums `centre`, x and y.

    Raises InputError and GeometryError as `profile` and `push` do, and for a bore that is too large.
    """
    found, hole = profile(model, roller, *centre), Bore(bore) if bore else None
    pushing = push(model, force) if force is not None else None
    lifted = find_lift_off(pushing, model.speed) if pushing is not None else None
    machine = model.machine
    told = CamPageContent(machine.document, machine.meanings, formulas.load(FORMULAS).sidecar, pushing, model.speed)
    holes = [hole.edge] if hole else []
    disc = build_cam_part(found, "disc", tolerance, lifted, model.speed, width, hole)
    return CamOutput(disc, told, lambda: solids.format_prism(f"cam of {machine.name}", found.pieces, holes, width))


def centre_of_follower(model: Model, force: str | None) -> tuple[tuple[str, str], str]:
    """Return the sums for the centre of the roller, x and y, that a follower of the statement has, and its force.

    Raises InputError where the statement has none, or several and `force` names none of them.
    """
    source = model.machine.source
    names = [quantity.name.removesuffix("_centre_x") for quantity in _list_centres(model.machine)[::2]]
    if not names:
        raise InputError(f"{source}: its statement has no follower of a cam; --y says where a roller's is")
    if force is None and len(names) > 1:
        raise InputError(f"{source}: --force is needed: its followers are {', '.join(names)}")
    name = names[0] if force is None else force
    if name not in names:
        raise _unknown("--force", name, names)
    return (f"{name}_centre_x", f"{name}_centre_y"), name


def _list_centres(machine: Machine) -> tuple[Quantity, ...]:
    return machine.stages[FOLLOWERS].quantities if FOLLOWERS in machine.stages else ()


def _list_lengths(machine: Machine) -> list[Quantity]:
    return [quantity for quantity in (*machine.results, *_list_centres(machine)) if quantity.unit == "m"]


def push(model: Model, force: str) -> Push:
    """The contact force of a name by angle and speed. Raises InputError for what is no force of the turn."""
    machine = model.machine
    forces = [quantity.name for quantity in machine.results if quantity.unit == "N"]
    if force not in forces:
        raise _unknown("--force", force, forces)

    def at(angles: Array, speed: float) -> Array:
        data = machine.data.copy()
        data[machine.speed] = speed
        return Model(machine, data)(angles % (2 * np.pi))[force]

    return at


def _sum(model: Model, option: str, text: str) -> Place:
    terms = [_term(model, option, term.strip()) for term in text.split("+")]
    return lambda found, count: np.sum([term(found, count) for term in terms], axis=0)


def _term(model: Model, option: str, term: str) -> Place:
    machine, lengths = model.machine, [quantity.name for quantity in _list_lengths(model.machine)]
    values = {v.name: number for v, number in zip(machine.values, machine.data.tolist(), strict=True) if v.unit == "m"}
    told = number(term)
    if term in lengths:
        return lambda found, count: found[term]
    if term in values or (told is not None and np.isfinite(told)):
        constant = values[term] if told is None else told * units.factor("_mm")
        return lambda found, count: np.full(count, constant)
    raise _unknown(option, term, [*lengths, *values])


def _unknown(option: str, given: str, known: list[str]) -> InputError:
    close = paths.close(given, known)
    hint = f"did you mean {close[0]}? " if close else ""
    return InputError(f"{option} = {given} is not allowed: {hint}there are {', '.join(known)}")
