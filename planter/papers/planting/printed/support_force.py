"""The support force as the printed equations of a built-in planting device give it."""

from __future__ import annotations

from functools import cache

from planter.audit.registry import Inputs, formula
from planter.papers.planting.calibration import load_study
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.objective import evaluate_true_extremes

_IDLE = (
    "design",
    "bounds",
    "genetic_algorithm",
    "operation.forward_speed_m_s",
    "nozzle.tip_distance_mm",
)
"""What of a machine does not bear on the force of its own design, or is no input of it."""


@formula("support force")
def compute_support_force(inputs: Inputs) -> float:
    """Return a true extreme or the variance of the support force [N, N2]."""
    _assume_inputs(inputs)
    return _evaluate_force(inputs["machine"])[inputs["part"]]


@formula("optimum")
def find_optimum(inputs: Inputs) -> float:
    """Return a design parameter at the optimum that a study found, in the unit of its name."""
    _assume_inputs(inputs)
    return float(load_study()["optimum"][inputs["parameter"]])


@cache
def _evaluate_force(name: str) -> dict[str, float]:
    device = Device(load(name), "printed")
    return vars(evaluate_true_extremes(device, device.design))


def _assume_inputs(inputs: Inputs) -> None:
    """Note the numbers of the machine that its paper does not give, and that bear on the force."""
    machine = load(inputs["machine"])
    numbers = machine.numbers()
    for path, origin in machine.number_origins().items():
        if not path.startswith(_IDLE) and not origin.startswith("paper"):
            inputs.assume(f"{path} = {numbers[path]:g}")


@formula("shape by two variances")
def compare_shapes(inputs: Inputs) -> float:
    """Return the ratio of two variances over the square of that of the ranges: 1 for curves of one
    shape.
    """
    variances = inputs["variances_N2"]
    ranges = inputs["ranges_N"]
    return float((variances[0] / variances[1]) / (ranges[0] / ranges[1]) ** 2)


@formula("names without an entry")
def count_absent_names(inputs: Inputs) -> float:
    """Return how many of the names have no entry."""
    return float(len(set(inputs["names"]) - set(inputs["entries"])))


@formula("difference of two spans")
def compare_spans(inputs: Inputs) -> float:
    """Return the difference of two angles over which something lasts [deg], each from its start to
    its end.
    """
    first, second = ((end - start) % 360 for start, end in inputs["spans_deg"])
    return float(first - second)
