"""What follows from the broken laws of a chain of equations as a whole, for a force over a turn and for its optimum.

The generated printed model is the chain with every equation as printed, the exact model the chain with every one
repaired. A law that fixes the support force from masses and motion alone leaves it no choice: whichever set of
equations is repaired to restore it, the force is then that of the exact model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from planter.audit.registry import consequence
from planter.planting import cycle
from planter.planting.functions import Model
from planter.planting.objective import read_weights
from planter.planting.printed.force import Both, both, felt, work
from planter.planting.undisclosed.inputs import data

Entry = dict[str, Any]
_SLOW = 1e-3
"""Share of the speed at which a machine counts as standing still: inertia is a millionth."""
_UNFELT = 1e-9
"""Change of the support force [N] below which it does not feel an input."""
HEADLINES = {"max_N": "largest", "min_N": "least", "range_N": "range", "variance_N2": "variance", "mean_N": "mean"}


@consequence("support force of a planting device")
def consequences(
    row: Mapping[str, Any], disclosed: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[Entry]:
    """Consequences of the violated laws of one paper; none where no law is violated."""
    broken = {e["law"]: e for e in trial["laws"] if e["paper"] == row["paper"] and e["caused_by"]}
    if not broken:
        return []
    machine, own = both(row["machine"]), disclosed[row["theory"]]
    decisive = broken.get(row["fixes_the_force"])
    causes = list(decisive["caused_by"]) if decisive else []
    entries = [{**entry, "rests_on": causes} for entry in (*_forces(machine, own), *_optima(machine))]
    entries += [_law(machine, law, row["laws"][name], law is decisive) for name, law in broken.items()
                if name in row["laws"]]  # fmt: skip
    entries += [_objective(machine, own), _tooth_angles(machine, row), _parameters(machine), _fit(row)]
    return [{"paper": row["paper"], **entry, "assumed_inputs": machine.assumptions} for entry in entries]


def _entry(
    about: str, quantity: str, unit: str, as_printed: float | None, as_derived: float | None,
    printed: float | None = None, statement: str = "",
) -> Entry:  # fmt: skip
    return {"about": about, "quantity": quantity, "unit": unit, "printed": printed, "as_printed": as_printed,
            "as_derived": as_derived, "rests_on": [], "statement": statement}  # fmt: skip


def _forces(machine: Both, own: Mapping[str, float]) -> Iterator[Entry]:
    """The headline numbers of the force, and the objective, in both models beside the paper's own."""
    by_print, derived = machine.headlines("printed"), machine.headlines("exact")
    for key, name in HEADLINES.items():
        unit = "N2" if key.endswith("N2") else "N"
        yield _entry("support force over a turn", name, unit, by_print[key], derived[key], own.get(key))
    objective = read_weights(machine.machine).value(own["range_N"], own["variance_N2"])
    yield _entry("support force over a turn", "objective", "", by_print["objective"], derived["objective"], objective)


def _optima(machine: Both) -> Iterator[Entry]:
    """The objective of three designs, each scored in both models, and what the printed optimum is worth."""
    designs = {
        "the paper's design": machine.devices["exact"].design,
        "the optimum of the equations as printed": machine.optima["printed"].design,
        "the optimum of the exact model": machine.optima["exact"].design,
    }
    scores = [(machine.score("printed", x), machine.score("exact", x)) for x in designs.values()]
    for name, score in zip(designs, scores, strict=True):
        yield _entry("objective of a design", name, "", *score)
    own, *best = scores
    printed, exact = ([100 * (found[i] / own[i] - 1) for i in range(2)] for found in best)
    said = (
        f"What the printed equations call their optimum is {_better(printed[1])} than the paper's design in the exact "
        f"model; the optimum of the exact model is {_better(exact[1])}."
    )
    yield _entry("objective of a design", "change by optimising with the equations as printed", "%", printed[0],
                 printed[1], statement=said)  # fmt: skip


def _better(change: float) -> str:
    return f"{abs(change):.3g} % {'worse' if change > 0 else 'better'}"


def _law(machine: Both, law: Mapping[str, Any], measure: str, decisive: bool) -> Entry:
    """A violated law by what it says of the force, in both models."""
    name, unit, found = MEASURES[measure]
    repaired = ", ".join(f"({number})" for number in law["caused_by"])
    said = f"Masses and motion fix this force: with {repaired} repaired, its numbers are those of the exact model."
    if law["reading"]:
        said += (
            f" The printed model reads every symbol literally and breaks this law by {law['violation_literal']:.4g} "
            f"{unit}; under the kindest joint reading ({law['reading']}) it is broken by {law['violation']:.4g} {unit}."
        )
    entry = _entry("law", f"{law['law']}: {name}", unit, found(machine, "printed"), found(machine, "exact"))
    return entry | {"rests_on": list(law["caused_by"]), "statement": said if decisive else ""}


def _apart(total: str) -> Callable[[Both, Model], float]:
    def found(machine: Both, model: Model) -> float:
        return float(abs(machine.turns[model].totals[total] - machine.turns["exact"].totals[total]).max())

    return found


def _least(contact: str) -> Callable[[Both, Model], float]:
    return lambda machine, model: float(machine.turns[model].sides[0][contact].min())


def _at_rest(machine: Both, model: Model) -> float:
    rpm = machine.machine.numbers()["operation.speed_rpm"] * _SLOW
    force = machine.support_with(model, {"operation.speed_rpm": rpm})
    return float(abs(force - cycle.compute_weight(machine.devices[model])).max())


MEASURES: dict[str, tuple[str, str, Callable[[Both, Model], float]]] = {
    "vertical": ("largest distance from the exact model", "N", _apart("support_N")),
    "horizontal": ("largest distance from the exact model", "N", _apart("support_x_N")),
    "mean": ("mean", "N", lambda machine, model: machine.headlines(model)["mean_N"]),
    "work": ("work of the motor over a turn", "J", lambda machine, model: work(machine.turns[model])),
    "at rest": ("largest distance from the weight at rest", "N", _at_rest),
    "teeth P": ("least normal force", "N", _least("F_NP_N")),
    "teeth Q": ("least normal force", "N", _least("F_NQ_N")),
}


def _objective(machine: Both, own: Mapping[str, float]) -> Entry:
    """How the objective weighs the paper's own numbers: the sum of a force and its square depends on the unit."""
    objective = read_weights(machine.machine)
    spread = objective.spread(own["variance_N2"])[0]
    share, in_kilonewton = (100 * spread / (spread + objective.weight_range * own["range_N"] * scale)
                            for scale in (1.0, 1e3))  # fmt: skip
    return _entry(
        "objective", "share of the variance in the objective of the paper's theory", "%", share, None,
        statement=f"The objective adds a force and its square: the variance makes {share:.3g} % of it in newtons, "
        f"{in_kilonewton:.2g} % in kilonewtons.",
    )  # fmt: skip


def _tooth_angles(machine: Both, row: Mapping[str, Any]) -> Entry:
    """Whether the support force feels the angles of the tooth forces at all."""
    changes = {model: felt(row["machine"], model, row["tooth_inputs"], 0.1) for model in machine.devices}
    verb = "does not feel" if max(changes.values()) < _UNFELT else "feels"
    return _entry(
        "what is felt", "largest change of the support force with tooth angles 10 % larger", "N",
        changes["printed"], changes["exact"],
        statement=f"The support force {verb} the angles of the tooth forces, and so the equations that only turn them.",
    )  # fmt: skip


def _parameters(machine: Both) -> Entry:
    """How many combinations of the design parameters the force feels at the optimum of either model."""
    unfelt = machine.optima["exact"].insensitive
    printed, exact = (float(machine.optima[model].effective_parameters) for model in ("printed", "exact"))
    said = (
        f"Of {len(machine.devices['exact'].names)} design parameters the exact force leaves {len(unfelt)} undetermined"
        f"{_listed(unfelt)}."
    )
    return _entry("what is felt", "combinations of design parameters that the force feels", "", printed, exact,
                  statement=said)  # fmt: skip


def _fit(row: Mapping[str, Any]) -> Entry:
    """What the disclosed numbers can settle of the undisclosed inputs, and where that is found."""
    fitted, targets = _calibration(row["target"])
    return _entry(
        "undisclosed inputs", "inputs that a fit to the paper's theory has to find", "", float(fitted), None,
        statement=f"{fitted} undisclosed inputs face {targets} printed numbers of the theory; how well these can be "
        f"met, how little that settles and what the exact model gives then is found by `planter calibrate "
        f"{row['machine']} --model printed --target {row['target']}`.",
    )  # fmt: skip


def _listed(directions: Sequence[Sequence[Mapping[str, float]]]) -> str:
    names = [" with ".join(name for part in direction for name in part) for direction in directions]
    return f" ({'; '.join(names)})" if names else ""


def _calibration(target: str) -> tuple[int, int]:
    content = data()
    return len(content["bounds"]), len(content["target"][target])
