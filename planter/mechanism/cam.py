"""A disc cam of a user-defined mechanism as a part: contour for a roller, from the path of the
roller's centre.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from planter import paths
from planter.engine.curves import QuantityCurves
from planter.engine.machine import Machine, Quantity
from planter.engine.response import MachineResponse
from planter.engine.solvers.response import list_breakpoints
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.files.csv_rows import parse_number
from planter.files.spelling import find_spelled
from planter.gears.workshop import solids
from planter.gears.workshop.cam import (
    Columns,
    Profile,
    Push,
    build_cam_part,
    check_roller,
    find_lift_off,
)
from planter.gears.workshop.cam_report import CamOutput
from planter.gears.workshop.drawing import Bore
from planter.kernels import Array, formulas
from planter.mechanism.model import Model, require_repeating
from planter.numerics.arrays import TURN

FORMULAS = "disc_cam"
FOLLOWERS = "followers"
CLOSED = 1e-9
"""Largest distance [m] between the ends of a closed contour."""
PIECES = 12
"""Pieces of a cycle, besides those that begin where a law changes."""
SHORTEST_PIECE = 1e-6
"""Breakpoints that are closer are one [rad]."""
SAMPLES = 720
"""Angles at which a cycle is searched for motion."""
REST = 1e-7
"""Share of its greatest speed below which a centre rests: rounding hides the direction of slower
motion, and until it rests the centre moves so little that the direction stays.
"""
BISECTIONS = 40
"""Halvings of the interval in which motion ends: from a dwell's length to the rounding of
angles.
"""


class RollerPath:
    """The path of a roller's centre over a cycle, with exact rates by the angle.

    Graphs are in the machine's symbols: the coordinates of the `centre` (2) [m] as if the cam
    turned by the angle, and `way` (4), its motion as its guide sees it, of any size, along the
    guide's axes, with the axis x of the guide. Without `way` the guide is at rest, and the motion
    is the slope of the centre. Raises ComputationError if the centre never moves.
    """

    def __init__(self, machine: Machine, centre: list[ca.SX], way: list[ca.SX]) -> None:
        self._machine = machine
        graphs = [*centre, *way]
        rows = [
            (Quantity(f"roller_{i}", "m", "centre of the roller", ""), graph)
            for i, graph in enumerate(graphs)
        ]
        self._response, self._has_way = MachineResponse(self._machine, (), more=rows), bool(way)
        self._point = self._response.at_data(self._machine.data)
        samples = TURN * (np.arange(SAMPLES) + 0.5) / SAMPLES
        speeds = np.hypot(*self._motion(samples))
        self._rest = REST * speeds.max()
        self._moving = samples[speeds > self._rest]
        if not len(self._moving):
            raise ComputationError(
                f"{self._machine.name}: the centre of the roller is at rest for a whole turn"
            )

    @property
    def breaks(self) -> tuple[float, ...]:
        """Angles of a turn between which the path is smooth [rad], its ends among them."""
        places = list_breakpoints(QuantityCurves(self._machine, ()), self._point)
        events = [place.angle for place in places]
        inner = [*sorted(events), *np.linspace(0.0, TURN, PIECES + 1)[1:-1]]
        breaks = [0.0, TURN]
        for angle in inner:
            if min(abs(angle - other) for other in breaks) > SHORTEST_PIECE:
                breaks.append(float(angle))
        return tuple(sorted(breaks))

    def evaluate(self, angles: Array) -> Array:
        """Return the centre and its first two derivatives (6, n) at angles (n,) [rad], x before
        y.
        """
        folded = angles % TURN
        values = self._response.values(self._point, folded)
        first, second = self._response.rates(self._point, folded)
        return np.vstack([values[:2], first[:2], second[:2]])

    def direction(self, angles: Array) -> Array:
        """Return the motion (2, n) of the centre at angles (n,) [rad]; at rest, how it moved before
        it came to rest.

        A guide sees the centre rest while both may turn; so the motion is turned with the guide.
        """
        motion = self._motion(angles)
        resting = np.flatnonzero(np.hypot(*motion) <= self._rest)
        if len(resting):
            high = angles[resting] % TURN
            last = np.searchsorted(self._moving, high) - 1
            low = self._moving[last] - np.where(last < 0, TURN, 0.0)
            for _ in range(BISECTIONS):
                middle = (low + high) / 2
                is_moving = np.hypot(*self._motion(middle)) > self._rest
                low, high = np.where(is_moving, middle, low), np.where(is_moving, high, middle)
            motion[:, resting] = self._motion(low)
        if not self._has_way:
            return motion
        guide_x, guide_y = self._response.values(self._point, angles % TURN)[4:]
        return np.array(
            [guide_x * motion[0] - guide_y * motion[1], guide_y * motion[0] + guide_x * motion[1]]
        )

    def _motion(self, angles: Array) -> Array:
        folded = angles % TURN
        if self._has_way:
            return self._response.values(self._point, folded)[2:4]
        return self._response.derivatives(self._point, folded)[1]


def build_profile(model: Model, roller: float, x: str, y: str) -> Profile:
    """Return the cam that turns by the mechanism's angle about the origin, for a roller whose
    centre is at x, y.

    Each is a sum of terms such as `y_0 + s`: lengths of the cycle, values of the file, numbers in
    mm. `roller` [m]. Raises InputError for any other term, GeometryError, from `Profile.check`, for
    too large a roller, ComputationError for a length that does not repeat after a cycle: it closes
    no contour.
    """
    check_roller(roller)
    machine, disc = model.machine.with_moved({}), formulas.load(FORMULAS)
    centre = [_parse_sum(machine, "--x", x), _parse_sum(machine, "--y", y)]
    terms = {term.strip() for text in (x, y) for term in text.split("+")}
    require_repeating(
        model.machine, terms & {q.name for q in model.machine.results if q.unit == "m"}
    )
    for name, (start, end) in model.evaluate(FOLLOWERS, np.array([0.0, TURN])).items():
        if name in terms and abs(end - start) > CLOSED:
            raise ComputationError(
                f"{model.machine.name}: {name} differs after a turn: it closes no contour"
            )
    path = RollerPath(machine, centre, _find_way(machine, x.strip(), y.strip()))

    def evaluate(angles: Array) -> Columns:
        return disc(
            "disc",
            phi=angles,
            centre=path.evaluate(angles),
            way=path.direction(angles),
            reach=-roller,
        )

    return Profile(model.machine.name, roller, evaluate, path.breaks, True, ("pitch_x", "pitch_y"))


def _find_way(machine: Machine, x: str, y: str) -> list[ca.SX]:
    """Return the motion of a stated follower's centre against its guide if x and y are that centre,
    else nothing.

    Raises InputError if the machine lacks it.
    """
    graphs = _list_graphs(machine)
    name = x.removesuffix("_centre_x")
    names = [f"{name}_{part}_{axis}" for part in ("way", "guide") for axis in "xy"]
    if x not in graphs or y != f"{name}_centre_y":
        return []
    if not all(name in graphs for name in names):
        # only the slope of the centre is known, which is another motion where the cam turns against
        # the angle
        raise InputError(
            f"{machine.source}: an earlier version generated its functions; run `planter derive` "
            f"again"
        )
    return [graphs[name] for name in names]


def _list_graphs(machine: Machine) -> dict[str, ca.SX]:
    """Return the graphs of the followers' centres and motions in the machine's symbols."""
    stage = machine.stages.get(FOLLOWERS)
    if stage is None:
        return {}
    rows = ca.vertsplit(stage.function(*machine.symbols))
    return {quantity.name: row for quantity, row in zip(stage.quantities, rows, strict=True)}


def build_disc_cam(
    model: Model,
    roller: float,
    centre: tuple[str, str],
    force: str | None,
    tolerance: float,
    width: float,
    bore: float,
) -> CamOutput:
    """Return the disc of a `width` with a bore [m], for a roller whose centre is at the sums
    `centre`, x and y.

    Raises InputError and GeometryError as `build_profile` and `find_contact_force` do, and for too
    large a bore.
    """
    profile, hole = build_profile(model, roller, *centre), Bore(bore) if bore else None
    contact_force = find_contact_force(model, force) if force is not None else None
    lift_off = find_lift_off(contact_force, model.speed) if contact_force is not None else None
    machine, holes = model.machine, [hole.edge] if hole else []
    return CamOutput(
        build_cam_part(profile, "disc", tolerance, lift_off, width, hole),
        machine.document,
        machine.meanings,
        formulas.load(FORMULAS).sidecar,
        contact_force,
        model.speed,
        lambda: solids.format_prism(f"cam of {machine.name}", profile.pieces, holes, width),
    )


def find_follower_centre(model: Model, force: str | None) -> tuple[tuple[str, str], str]:
    """Return the sums for the centre of the roller, x and y, of a follower of the statement, and
    its contact force.

    Raises InputError if the statement has no follower, or several and `force` names none of them.
    """
    source = model.machine.source
    names = [
        quantity.name.removesuffix("_centre_x") for quantity in _list_centres(model.machine)[::2]
    ]
    if not names:
        raise InputError(
            f"{source}: its statement has no follower of a cam: add --y for the centre of the "
            f"roller"
        )
    if force is None and len(names) > 1:
        raise InputError(
            f"{source}: add --force to choose one of its followers: {', '.join(names)}"
        )
    name = names[0] if force is None else force
    if name not in names:
        raise _refuse_name("--force", name, names)
    return (f"{name}_centre_x", f"{name}_centre_y"), name


def _list_centres(machine: Machine) -> list[Quantity]:
    stage = machine.stages.get(FOLLOWERS)
    return [q for q in stage.quantities if q.unit == "m"] if stage else []


def find_contact_force(model: Model, name: str) -> Push:
    """Return a contact force of the cycle as a function of angle and speed.

    Raises InputError for an unknown name.
    """
    machine = model.machine
    forces = [quantity.name for quantity in machine.results if quantity.unit == "N"]
    if name not in forces:
        raise _refuse_name("--force", name, forces)

    def evaluate(angles: Array, speed: float) -> Array:
        data = machine.data.copy()
        data[machine.speed] = speed
        return Model(machine, data)(angles % (2 * np.pi))[name]

    return evaluate


def _parse_sum(machine: Machine, option: str, text: str) -> ca.SX:
    """Return the graph of a sum of terms in the machine's symbols [m]."""
    return sum((_parse_term(machine, option, term.strip()) for term in text.split("+")), ca.SX(0.0))


def _parse_term(machine: Machine, option: str, term: str) -> ca.SX:
    lengths = [q.name for q in (*machine.results, *_list_centres(machine)) if q.unit == "m"]
    values = {
        v.name: value
        for v, value in zip(machine.values, machine.data.tolist(), strict=True)
        if v.unit == "m"
    }
    parsed = parse_number(term)
    matches = find_spelled(term, {name: (name, f"{name}_mm") for name in lengths})
    if len(matches) == 1:
        graph = _list_graphs(machine).get(matches[0])
        return machine.graph(matches[0]) if graph is None else graph
    if term in values:
        return ca.SX(values[term])
    if parsed is not None and np.isfinite(parsed):
        return ca.SX(parsed * units.unit_factor("_mm"))
    raise _refuse_name(option, term, [*lengths, *values])


def _refuse_name(option: str, name: str, names: list[str]) -> InputError:
    close = paths.find_similar(name, names)
    hint = f"did you mean {close[0]}? " if close else ""
    return InputError.for_value(option, name, f"{hint}there are {', '.join(names)}")
