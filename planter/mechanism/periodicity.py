"""Whether a mechanism ends a turn in the state in which it began it: only then are means and works those of any turn.

Every quantity is compared with itself a whole turn later, at every sample, so that a coincidence at one angle does not
count. Angles are compared modulo 2 pi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.files import units
from planter.kernels import Array
from planter.mechanism.model import LAW, PIVOTS, STATES, Model
from planter.mechanism.results import Warned
from planter.numerics.angles import TURN

SHARE, FLOOR = 1e-7, 1e-12
"""A quantity repeats if it changes by less than this share of the largest value in its unit, or this much in SI."""
MOST_TURNS = 60
"""Turns after which a repetition is looked for."""
COMPARED = 24
"""Samples at which a repetition after several turns is looked for."""
MOST_NAMED = 4
"""Quantities that a warning names; all stand in `not_repeating`."""


@dataclass(frozen=True)
class Periodicity:
    """How a mechanism's results at a turn's samples differ from those a turn later.

    `end` holds the results at the end of the turn by name, in SI; `changes` the largest difference [shown unit] by the
    key of each quantity that does not repeat; `turns` is after how many turns all of them do, None if after none of
    the first MOST_TURNS. Where the next turn cannot be computed `obstacle` says why, and differences are None.
    """

    end: dict[str, float]
    changes: dict[str, float | None]
    turns: int | None
    obstacle: str = ""

    def warnings(self) -> list[Warned]:
        """One sentence if the turn does not end as it began."""
        if not self.changes:
            return []
        again = (
            f"it repeats after {self.turns} turns" if self.turns else f"it does not repeat within {MOST_TURNS} turns"
        )
        message = (
            f"the turn does not end in the state in which it began: {self.obstacle or self._listed}; means, root mean "
            "squares and works of what does not repeat are not given, and its extremes are those of this turn alone"
            + ("" if self.obstacle else f"; {again}")
        )
        return [Warned(name="does_not_repeat", angle_deg=360.0, message=message)]

    @property
    def _listed(self) -> str:
        """The first quantities that do not repeat, with what they change by."""
        changes = [(key, change) for key, change in self.changes.items() if change is not None]
        listed = ", ".join(f"{describe_change(key, change)}" for key, change in changes[:MOST_NAMED])
        more = len(changes) - MOST_NAMED
        return f"{listed} and {more} more" if more > 0 else listed


def describe_change(key: str, change: float) -> str:
    """What a quantity changes by in a turn, in words."""
    return f"{key.removesuffix(units.suffix(key))} differs by {change:.4g} {units.unit(key)}".rstrip()


def periodicity(model: Model, angles: Array, results: dict[str, Array], search: bool = True) -> Periodicity:
    """Compare results (n,) by name at angles (n,) [rad] from zero on, in equal steps, with those of the next turn.

    Without `search` it is not looked for after how many turns all repeats.
    """
    entries = [e for e in model.outputs if not e["name"].startswith((LAW, PIVOTS, STATES))]
    names = {e["name"]: e["unit"] for e in entries}
    keys = {e["name"]: units.key(e["name"], e["unit"]) for e in entries}
    try:
        later = model(angles + TURN)
    except ComputationError as error:
        return Periodicity({}, dict.fromkeys(keys.values()), None, f"the next one cannot be computed ({error.message})")
    limits = _limits(names, results)
    largest = {name: float(_differences(unit, later[name], results[name]).max()) for name, unit in names.items()}
    changed = [name for name, change in largest.items() if change > limits[name]]
    changes: dict[str, float | None] = {keys[name]: largest[name] / units.factor(keys[name]) for name in changed}
    end = {name: float(later[name][0]) for name in names}
    turns = 1 if not changed else _repetition(model, angles, results, names, limits) if search else None
    return Periodicity(end, changes, turns)


def require_repeating(model: Model, names: Sequence[str], samples: int) -> None:
    """Raise ComputationError if a quantity does not repeat after a turn, which then gives no mean or closed curve."""
    angles = TURN * np.arange(samples) / samples
    entries = {e["name"]: e["unit"] for e in model.outputs}
    found = periodicity(model, angles, model(angles), search=False)
    for key in (units.key(name, entries[name]) for name in names):
        if key in found.changes:
            change = found.changes[key]
            reason = found.obstacle if change is None else describe_change(key, change)
            raise ComputationError(
                f"{model.file.name}: a turn does not end in the state in which it began ({reason}), so that it gives "
                "neither a mean nor a closed curve"
            )


def _limits(names: dict[str, str], results: dict[str, Array]) -> dict[str, float]:
    """How much each quantity may change: rounding of the largest value in its unit."""
    sizes: dict[str, float] = {}
    for name, unit in names.items():
        sizes[unit] = max(sizes.get(unit, 0.0), float(np.abs(results[name]).max()))
    return {name: max(SHARE * (1.0 if unit == "rad" else sizes[unit]), FLOOR) for name, unit in names.items()}


def _differences(unit: str, later: Array, before: Array) -> Array:
    """Sizes (n,) of what changed, of angles beyond whole turns."""
    change = later - before
    found: Array = np.abs(change - TURN * np.round(change / TURN) if unit == "rad" else change)
    return found


def _repetition(
    model: Model, angles: Array, results: dict[str, Array], names: dict[str, str], limits: dict[str, float]
) -> int | None:
    """The least number of turns after which all quantities are what they were."""
    chosen = np.unique(np.linspace(0, len(angles) - 1, min(COMPARED, len(angles))).astype(np.int64))
    before = {name: results[name][chosen] for name in names}
    for turns in range(2, MOST_TURNS + 1):
        try:
            later = model(angles[chosen] + TURN * turns)
        except ComputationError:
            continue
        if all(_differences(u, later[n], before[n]).max() <= limits[n] for n, u in names.items()):
            return turns
    return None
