"""The support force in both models of a built-in planting device, and what follows from the laws
its paper breaks.

The generated printed model is the chain with every equation as printed, the exact model the chain
with every one repaired. A law that fixes the support force from masses and motion alone leaves it
no choice: whichever set of equations is repaired to restore it, the force is then that of the exact
model. Every result carries the inputs that the paper does not publish.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from planter.audit.registry import Inputs, consequence, formula
from planter.files.units import unit_factor
from planter.kernels import Array
from planter.papers.planting import optimisation
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from planter.papers.planting.objective import evaluate_true_extremes
from planter.papers.planting.optimisation import DeviceOptimum
from planter.papers.planting.unpublished_inputs import load_calibration_data

_IDLE = (
    "design",
    "bounds",
    "genetic_algorithm",
    "operation.forward_speed_m_s",
    "nozzle.tip_distance_mm",
)
"""What of a machine does not bear on the force of its own design, or is no input of it."""


@dataclass(frozen=True)
class BothModels:
    """A machine in both of its models."""

    machine: PlantingMachine

    @cached_property
    def devices(self) -> dict[Model, Device]:
        return {model: Device(self.machine, model) for model in MODELS}

    @cached_property
    def angles(self) -> Array:
        """Carrier angles of the machine's own samples [rad], (n,)."""
        return self.devices["exact"].engine.list_angles()

    @cached_property
    def turns(self) -> dict[Model, dict[str, Array]]:
        """Columns of a turn of the machine's own design in each model."""
        return {model: d.columns(d.design, self.angles) for model, d in self.devices.items()}

    @cached_property
    def optima(self) -> dict[Model, DeviceOptimum]:
        """The optimum of each model, by IPOPT from the machine's own design."""
        return {
            model: optimisation.search_optimum(device, "ipopt", starts=1)
            for model, device in self.devices.items()
        }

    def headlines(self, model: Model) -> dict[str, float]:
        """True extremes, range, mean, variance and objective of the machine's own design."""
        device = self.devices[model]
        return vars(evaluate_true_extremes(device, device.design))

    def score(self, model: Model, x: Array) -> float:
        """Objective of a design x (p,) in a model."""
        return evaluate_true_extremes(self.devices[model], x).objective

    def support_with(self, model: Model, values: Mapping[str, float]) -> Array:
        """Support force [N] of the machine's own design with other values of some of its inputs, in
        paths units.
        """
        device = Device(self.machine, model)
        paths = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
        for path, value in values.items():
            device.constants[paths.index(path)] = value * unit_factor(path)
        return device.support(device.prologue(device.design), self.angles)

    @property
    def assumptions(self) -> list[str]:
        """Numbers of the machine that its paper does not give, and that bear on the force."""
        numbers = self.machine.numbers()
        return [
            f"{path} = {numbers[path]:g}"
            for path, origin in self.machine.number_origins().items()
            if not path.startswith(_IDLE) and not origin.startswith("paper")
        ]


@cache
def both(name: str) -> BothModels:
    """A built-in machine in both of its models."""
    return BothModels(load(name))


def felt(name: str, model: Model, paths: Sequence[str], share: float) -> float:
    """Largest change of the support force [N] when some inputs of a machine grow by a share, all at
    once.
    """
    machine = both(name)
    numbers = machine.machine.numbers()
    changed = machine.support_with(model, {path: numbers[path] * (1 + share) for path in paths})
    return float(abs(changed - machine.turns[model]["support_N"]).max())


@formula("support force")
def support_force(inputs: Inputs) -> float:
    """True extreme or variance of the support force in the printed model of a built-in machine."""
    return _assuming(inputs).headlines("printed")[inputs["part"]]


@formula("optimum")
def optimum(inputs: Inputs) -> float:
    """A design parameter at the optimum of the printed model, in the unit that it is design in."""
    machine = _assuming(inputs)
    device = machine.devices["printed"]
    design = device.named(machine.optima["printed"].design)
    return design[inputs["parameter"]]


def _assuming(inputs: Inputs) -> BothModels:
    machine = both(inputs["machine"])
    for text in machine.assumptions:
        inputs.assume(text)
    return machine


def work(turn: Mapping[str, Array]) -> float:
    """Work of the motor over a turn [J], from equally spaced samples."""
    return float(turn["M_L_Nm"].mean() * 2 * np.pi)


Entry = dict[str, Any]
_SLOW = 1e-3
"""Share of the speed at which a machine counts as standing still: inertia is a millionth."""
_UNFELT = 1e-9
"""Change of the support force [N] below which it does not feel an input."""
HEADLINES = {
    "max_N": "largest",
    "min_N": "least",
    "range_N": "range",
    "variance_N2": "variance",
    "mean_N": "mean",
}


@consequence("support force of a planting device")
def consequences(
    row: Mapping[str, Any],
    disclosed: Mapping[str, Any],
    trial: Mapping[str, Sequence[Mapping[str, Any]]],
) -> list[Entry]:
    """Consequences of the violated laws of one paper; none where no law is violated."""
    broken = {e["law"]: e for e in trial["laws"] if e["paper"] == row["paper"] and e["caused_by"]}
    if not broken:
        return []
    machine, figures = both(row["machine"]), disclosed[row["theory"]]
    decisive = broken.get(row["fixes_the_force"])
    causes = list(decisive["caused_by"]) if decisive else []
    entries = [
        {**entry, "rests_on": causes} for entry in (*_forces(machine, figures), *_optima(machine))
    ]
    entries += [
        _law(machine, law, row["laws"][name], law is decisive)
        for name, law in broken.items()
        if name in row["laws"]
    ]
    entries += [
        _objective(machine, figures),
        _tooth_angles(machine, row),
        _parameters(machine),
        _fit(row),
    ]
    return [
        {"paper": row["paper"], **entry, "assumed_inputs": machine.assumptions} for entry in entries
    ]


def _entry(
    about: str,
    quantity: str,
    unit: str,
    as_printed: float | None,
    as_derived: float | None,
    printed: float | None = None,
    statement: str = "",
) -> Entry:
    return {
        "about": about,
        "quantity": quantity,
        "unit": unit,
        "printed": printed,
        "as_printed": as_printed,
        "as_derived": as_derived,
        "rests_on": [],
        "statement": statement,
    }


def _forces(machine: BothModels, figures: Mapping[str, float]) -> Iterator[Entry]:
    """The headline numbers of the force, and the objective, in both models and in the paper."""
    by_print, derived = machine.headlines("printed"), machine.headlines("exact")
    for key, name in HEADLINES.items():
        unit = "N2" if key.endswith("N2") else "N"
        yield _entry(
            "support force over a turn", name, unit, by_print[key], derived[key], figures.get(key)
        )
    objective = machine.machine.objective.value(figures["range_N"], figures["variance_N2"])
    yield _entry(
        "support force over a turn",
        "objective",
        "",
        by_print["objective"],
        derived["objective"],
        objective,
    )


def _optima(machine: BothModels) -> Iterator[Entry]:
    """The objective of three designs, each scored in both models, and what the printed optimum is
    worth.
    """
    designs = {
        "the paper's design": machine.devices["exact"].design,
        "the optimum of the equations as printed": machine.optima["printed"].design,
        "the optimum of the exact model": machine.optima["exact"].design,
    }
    scores = [(machine.score("printed", x), machine.score("exact", x)) for x in designs.values()]
    for name, score in zip(designs, scores, strict=True):
        yield _entry("objective of a design", name, "", *score)
    paper, *best = scores
    printed, exact = ([100 * (score[i] / paper[i] - 1) for i in range(2)] for score in best)
    statement = (
        f"What the printed equations call their optimum is {_better(printed[1])} than the paper's "
        f"design in the exact "
        f"model; the optimum of the exact model is {_better(exact[1])}."
    )
    yield _entry(
        "objective of a design",
        "change by optimising with the equations as printed",
        "%",
        printed[0],
        printed[1],
        statement=statement,
    )


def _better(change: float) -> str:
    return f"{abs(change):.3g} % {'worse' if change > 0 else 'better'}"


def _law(machine: BothModels, law: Mapping[str, Any], measure: str, decisive: bool) -> Entry:
    """A violated law by what it says of the force, in both models."""
    name, unit, measure_law = MEASURES[measure]
    repaired = ", ".join(f"({number})" for number in law["caused_by"])
    statement = (
        f"Masses and motion fix this force: with {repaired} repaired, its numbers are "
        f"those of the exact model."
    )
    if law["reading"]:
        statement += (
            f" The printed model reads every symbol literally and breaks this law by "
            f"{law['violation_literal']:.4g} "
            f"{unit}; under the kindest joint reading ({law['reading']}) it is broken by "
            f"{law['violation']:.4g} {unit}."
        )
    entry = _entry(
        "law",
        f"{law['law']}: {name}",
        unit,
        measure_law(machine, "printed"),
        measure_law(machine, "exact"),
    )
    return entry | {"rests_on": list(law["caused_by"]), "statement": statement if decisive else ""}


def _measure_distance(total: str) -> Callable[[BothModels, Model], float]:
    def measure(machine: BothModels, model: Model) -> float:
        return float(abs(machine.turns[model][total] - machine.turns["exact"][total]).max())

    return measure


def _measure_minimum(contact: str) -> Callable[[BothModels, Model], float]:
    return lambda machine, model: float(machine.turns[model][contact].min())


def _at_rest(machine: BothModels, model: Model) -> float:
    rpm = machine.machine.numbers()["operation.speed_rpm"] * _SLOW
    force = machine.support_with(model, {"operation.speed_rpm": rpm})
    return float(abs(force - machine.devices[model].weight).max())


MEASURES: dict[str, tuple[str, str, Callable[[BothModels, Model], float]]] = {
    "vertical": ("largest distance from the exact model", "N", _measure_distance("support_N")),
    "horizontal": ("largest distance from the exact model", "N", _measure_distance("support_x_N")),
    "mean": ("mean", "N", lambda machine, model: machine.headlines(model)["mean_N"]),
    "work": (
        "work of the motor over a turn",
        "J",
        lambda machine, model: work(machine.turns[model]),
    ),
    "at rest": ("largest distance from the weight at rest", "N", _at_rest),
    "teeth P": ("least normal force", "N", _measure_minimum("F_NP_N")),
    "teeth Q": ("least normal force", "N", _measure_minimum("F_NQ_N")),
}


def _objective(machine: BothModels, figures: Mapping[str, float]) -> Entry:
    """Return the share of the variance in the objective, which depends on the unit, for the paper's
    numbers.
    """
    objective = machine.machine.objective
    spread = objective.weighted(figures["variance_N2"])
    share, in_kilonewton = (
        100 * spread / (spread + objective.weight_range * figures["range_N"] * scale)
        for scale in (1.0, 1e3)
    )
    return _entry(
        "objective",
        "share of the variance in the objective of the paper's theory",
        "%",
        share,
        None,
        statement=f"The objective adds a force and its square: the variance makes {share:.3g} % "
        f"of it in newtons, "
        f"{in_kilonewton:.2g} % in kilonewtons.",
    )


def _tooth_angles(machine: BothModels, row: Mapping[str, Any]) -> Entry:
    """Whether the support force depends on the angles of the tooth forces."""
    changes = {
        model: felt(row["machine"], model, row["tooth_inputs"], 0.1) for model in machine.devices
    }
    verb = "does not feel" if max(changes.values()) < _UNFELT else "feels"
    return _entry(
        "what is felt",
        "largest change of the support force with tooth angles 10 % larger",
        "N",
        changes["printed"],
        changes["exact"],
        statement=f"The support force {verb} the angles of the tooth forces, and so the equations "
        f"that only turn them.",
    )


def _parameters(machine: BothModels) -> Entry:
    """Return the number of parameter combinations on which the force depends at the optimum of
    either model.
    """
    unfelt = machine.optima["exact"].insensitive
    printed, exact = (
        float(machine.optima[model].effective_parameters) for model in ("printed", "exact")
    )
    statement = (
        f"Of {len(machine.devices['exact'].names)} design parameters the exact force leaves "
        f"{len(unfelt)} undetermined"
        f"{_listed(unfelt)}."
    )
    return _entry(
        "what is felt",
        "combinations of design parameters that the force feels",
        "",
        printed,
        exact,
        statement=statement,
    )


def _fit(row: Mapping[str, Any]) -> Entry:
    """Return what the disclosed numbers determine of the undisclosed inputs, and the command that
    computes it.
    """
    fitted, targets = _calibration(row["target"])
    return _entry(
        "undisclosed inputs",
        "inputs that a fit to the paper's theory has to find",
        "",
        float(fitted),
        None,
        statement=f"{fitted} undisclosed inputs face {targets} printed numbers of the theory; how "
        f"well these can be "
        f"met, how little that settles and what the exact model gives then is found by `planter "
        f"calibrate "
        f"{row['machine']} --model printed --target {row['target']}`.",
    )


def _listed(directions: Sequence[Sequence[Mapping[str, float]]]) -> str:
    names = [" with ".join(name for part in direction for name in part) for direction in directions]
    return f" ({'; '.join(names)})" if names else ""


def _calibration(target: str) -> tuple[int, int]:
    content = load_calibration_data()
    return len(content["bounds"]), len(content["target"][target])
