"""Angles, or times, that follow from the design: of an extremum, of a passage of a number, of an
event, of settling.

Such an angle a(x) is a zero of a function G(phi, x). Implicit differentiation gives its derivatives
a' = -G_x / G_phi, and a'' = -H / G_phi, where H is the second derivative of G along (a', 1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy

from planter.engine.machine import Machine
from planter.engine.measures import Crossing, EventTime, Extremum, Measure, SettlingBand
from planter.engine.response import SCANNED, DesignPoint, MachineResponse, open_response
from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import extrema, roots

CORNER = 1e-6
"""Share of the slopes a step away that a slope keeps at an extremum only if it jumps there: it is a
corner.
"""
TANGENT = 1e-6
"""Slopes over the whole cycle below this share of the largest value touch zero: the place has no
derivative.
"""
JUMP = 1e-6
"""Values above this share of the largest one where the sign changes are those of a jump."""
ROUNDING = 1e-12
"""Share of the largest value that has no sign of its own."""
REACHED = 1e-9
"""Share of the largest value that is zero at the end of a piece, whose last sample is before it."""


@dataclass(frozen=True)
class NodePlace:
    """An `angle` (1,) at which weights (m,) times the rows of a response vanish, less what they are
    at the angle `reference` (1,) if there is one; without a response it is fixed.
    """

    angle: Array
    response: MachineResponse | None = None
    weights: Array | None = None
    reference: Array | None = None

    def differentiate(self, point: DesignPoint) -> tuple[float, Array]:
        """Return the derivatives of the function, G_phi and G_x (p,)."""
        assert self.response is not None
        slopes = self._slope(point, self.angle)
        if self.reference is not None:
            slopes[1:] -= self._slope(point, self.reference)[1:]
        return float(slopes[0]), slopes[1:]

    def _slope(self, point: DesignPoint, angle: Array) -> Array:
        assert self.response is not None
        assert self.weights is not None
        slopes: Array = self.weights @ self.response.slopes(point, angle)[1][:, 0]
        return slopes

    def curvature(self, point: DesignPoint, factor: float, motion: Array) -> Array:
        """Return a factor times H (p, p), where the angle has the derivatives `motion` (1, p)."""
        assert self.response is not None
        assert self.weights is not None
        weights = factor * self.weights[:, None]
        bend = self.response.curvature_along(point, self.angle, weights, motion)
        if self.reference is None:
            return bend
        return bend - self.response.curvature(point, self.reference, weights)[1:, 1:]


class PlaceFinder(Protocol):
    """Search for the place of a measure at a design."""

    def find(self, point: DesignPoint) -> NodePlace:
        """Return the place at a design. Raises ComputationError if there is none, or none that has
        a derivative.
        """

    def restart(self) -> None:
        """Forget all designs so far."""


def open_place(machine: Machine, measure: Measure) -> PlaceFinder:
    """Return what finds the place of a measure at a single angle or time."""
    where = measure.where
    if isinstance(where, Extremum):
        return _ExtremumFinder(machine, where)
    if isinstance(where, Crossing):
        return _CrossingFinder(machine, where, measure.span)
    if isinstance(where, EventTime):
        return _EventFinder(machine, where, measure.span)
    if isinstance(where, SettlingBand):
        return _SettlingFinder(machine, where, measure.span)
    return _FixedFinder(machine, measure)


class _FixedFinder:
    def __init__(self, machine: Machine, measure: Measure) -> None:
        assert measure.angle is not None
        angle, motion = measure.angle, machine.motion
        phi = np.radians(angle % 360) if motion is None else machine.turn * angle / motion.span
        self._place = NodePlace(np.array([phi]))

    def find(self, point: DesignPoint) -> NodePlace:
        return self._place

    def restart(self) -> None:
        pass


class _ExtremumFinder:
    def __init__(self, machine: Machine, where: Extremum) -> None:
        self._machine, self._where = machine, where
        self._response = MachineResponse(machine, [where.name], rates=[where.name])

    def restart(self) -> None:
        self._response.restart()

    def find(self, point: DesignPoint) -> NodePlace:
        machine, where, response = self._machine, self._where, self._response
        grid = machine.list_angles(max(machine.samples, SCANNED))
        values = response.values(point, grid)[0]
        index = extrema.index_first_extremum(grid, values, where.sign)
        bracket = grid[index] + np.array([-grid[1], grid[1]])
        ends = response.values(point, bracket)[1]

        def rate(phi: Array) -> tuple[Array, Array]:
            rates, slopes = response.slopes(point, phi)
            return rates[1], slopes[1, :, 0]

        is_corner = ends[0] * ends[1] > 0
        if not is_corner:
            angle = roots.find_bracketed_roots(rate, bracket[:1], bracket[1:], (ends[:1], ends[1:]))
            is_corner = abs(float(rate(angle)[0][0])) > CORNER * np.abs(ends).max()
        if is_corner:
            degrees = np.degrees(grid[index])
            raise ComputationError(f"{machine.name}: {where} at a corner, near {degrees:.6g} deg")
        return NodePlace(angle, response, np.array([0.0, 1.0]))


class _Span:
    """The angles from the first to the last one that a measure of times [s], or of a cycle, has."""

    def __init__(self, machine: Machine, span: tuple[float, float] | None) -> None:
        self.machine = machine
        self.pace = 1.0 if machine.motion is None else machine.motion.span / machine.turn
        self.span = (0.0, machine.turn * self.pace) if span is None else span
        self.first, self.last = (time / self.pace for time in self.span)

    def name_angle(self, angle: float) -> str:
        """Return an angle or a time in words."""
        if self.machine.motion is None:
            return f"{np.degrees(angle):.6g} deg"
        return f"{self.pace * angle:.6g} s"

    def __str__(self) -> str:
        if self.machine.motion is None:
            return "of the cycle"
        first, last = self.span
        return f"from {first:g} s to {last:g} s"


class _CrossingFinder:
    def __init__(self, machine: Machine, where: Crossing, span: tuple[float, float] | None) -> None:
        self._where, self._span = where, _Span(machine, span)
        self._response = open_response(machine, [where.name])
        self._level = where.number * self._response.quantities[0].factor

    def restart(self) -> None:
        self._response.restart()

    def find(self, point: DesignPoint) -> NodePlace:
        where, span, name = self._where, self._span, self._span.machine.name

        def excess(angles: Array) -> Array:
            return np.asarray(self._response.values(point, angles)[0] - self._level)

        pieces = self._response.list_pieces(point, span.first, span.last)
        passage = _find_passage(excess, pieces, where.last)
        if passage.angle is None:
            factor = self._response.quantities[0].factor
            low, high = (where.number + end / factor for end in passage.ends)
            raise ComputationError(
                f"{name}: {where}: {where.name} does not pass {where.number:g} {span}, where it is "
                f"from {low:.6g} to {high:.6g}"
            )
        place = NodePlace(np.array([passage.angle]), self._response, np.ones(1))
        _refuse_tangent(place, point, passage.size, f"{name}: {where}", span)
        return place


class _EventFinder:
    def __init__(
        self, machine: Machine, where: EventTime, span: tuple[float, float] | None
    ) -> None:
        self._where, self._span = where, _Span(machine, span)
        self._response = open_response(machine, [], with_events=True)

    def restart(self) -> None:
        self._response.restart()

    def find(self, point: DesignPoint) -> NodePlace:
        where, span = self._where, self._span
        for name, angle in self._response.list_passages(point):
            if name == where.event and span.first <= angle <= span.last:
                return _open_event(self._response, name, angle)
        raise ComputationError(f"{span.machine.name}: {where}: it does not happen {span}")


def _open_event(response: MachineResponse, name: str, angle: float) -> NodePlace:
    """Return the place of an event by its name."""
    names = [kind["name"] for kind in response.machine.event_kinds]
    weights = np.zeros(len(response.quantities))
    weights[names.index(name) - len(names)] = 1.0
    return NodePlace(np.array([angle]), response, weights)


class _SettlingFinder:
    def __init__(
        self, machine: Machine, where: SettlingBand, span: tuple[float, float] | None
    ) -> None:
        self._where, self._span = where, _Span(machine, span)
        self._response = open_response(machine, [where.name])
        self._events = open_response(machine, [], with_events=True)
        self._band = where.number * self._response.quantities[0].factor

    def restart(self) -> None:
        self._response.restart()
        self._events.restart()

    def find(self, point: DesignPoint) -> NodePlace:
        span, end = self._span, np.array([self._span.last])
        final = self._response.values(point, end)[0, 0]

        def excess(angles: Array) -> Array:
            return np.abs(self._response.values(point, angles)[0] - final) - self._band

        pieces = self._response.list_pieces(point, span.first, span.last)
        passage = _find_passage(excess, pieces, is_last=True, with_jumps=True)
        if passage.angle is None:
            return NodePlace(np.array([span.first]))
        if passage.is_jump:
            events = self._response.list_passages(point)
            jump = passage.angle
            name, angle = min(events, key=lambda event: abs(event[1] - jump))
            return _open_event(self._events, name, angle)
        place = NodePlace(np.array([passage.angle]), self._response, np.ones(1), end)
        _refuse_tangent(place, point, passage.size, f"{span.machine.name}: {self._where}", span)
        return place


def _refuse_tangent(
    place: NodePlace, point: DesignPoint, size: float, label: str, span: _Span
) -> None:
    """Raise ComputationError where a function touches zero: its slope over a cycle is a small share
    of its size.
    """
    rise = place.differentiate(point)[0]
    if abs(rise) * span.machine.turn <= TANGENT * size:
        angle = span.name_angle(float(place.angle[0]))
        raise ComputationError(
            f"{label}: it is only touched at {angle}, where the place has no derivative"
        )


@dataclass(frozen=True)
class _Passage:
    """The angle at which a function passes zero, None if it never does, and its least and greatest
    value. `is_jump` where it jumps past zero, between two pieces.
    """

    angle: float | None
    ends: tuple[float, float]
    is_jump: bool = False

    @property
    def size(self) -> float:
        """The largest size of the function."""
        return max(map(abs, self.ends))


def _find_passage(
    function: Callable[[Array], Array],
    pieces: Sequence[Array],
    is_last: bool = False,
    with_jumps: bool = False,
) -> _Passage:
    """Return the first or the last passage of zero of a function, by samples of pieces on which it
    is smooth. A jump past zero is one only `with_jumps`.

    A zero at the end of a piece counts: what happens there may turn the function back.
    """
    samples = [function(piece) for piece in pieces]
    ends = float(min(map(np.min, samples))), float(max(map(np.max, samples)))
    size, side = max(map(abs, ends)) or 1.0, -1.0 if is_last else 1.0

    def share(place: float) -> float:
        return float(function(np.array([side * place]))[0]) / size

    sign, count = 0.0, len(pieces)
    for index in range(count)[:: int(side)]:
        shares, places = samples[index] / size, pieces[index]
        is_reached = index + 1 < count and abs(shares[-1]) <= REACHED
        if is_reached and is_last:
            return _Passage(float(places[-1]), ends)
        if is_last:
            places, shares = -places[::-1], shares[::-1]
        if with_jumps and sign * shares[0] < 0:
            return _Passage(side * places[0], ends, is_jump=True)
        for start, end, _ in sorted(
            roots.bracket_sign_changes(share, places, shares, 0.0, ROUNDING)
        ):
            root = scipy.optimize.brentq(share, start, end, xtol=1e-15, rtol=1e-15)
            if abs(share(root)) <= JUMP:
                return _Passage(side * root, ends)
        if is_reached:
            return _Passage(float(pieces[index][-1]), ends)
        sign = float(np.sign(shares[-1]))
    return _Passage(None, ends)
