"""What a planting device's optimisation makes small: objective (31) of Wang et al. (2017), over designs in its box."""

from __future__ import annotations

from planter.engine.measures import Kind, Measure
from planter.engine.problem import CurveProblem
from planter.optimise.constraints import Constraints
from planter.optimise.range_and_spread import Sampling
from planter.optimise.spread import Weights
from planter.planting.file import Machine
from planter.planting.model import Device

FORCE = "F_support"


def weights(machine: Machine) -> Weights:
    """Of range and spread of the support force, as the machine file has them."""
    settings = machine.objective
    return Weights(settings.weight_range, settings.weight_variance, settings.kind)


def build_measures(machine: Machine) -> tuple[Measure, Measure]:
    """Return range and spread of the support force as measures, weighed as the machine file has them."""
    settings = machine.objective
    spread: Kind = "variance" if settings.kind == "paper" else "std"
    return (
        Measure("range", FORCE, weight=settings.weight_range),
        Measure(spread, FORCE, weight=settings.weight_variance),
    )


def problem(
    device: Device, sampling: Sampling = "refined", constraints: Constraints | None = None
) -> CurveProblem:  # fmt: skip
    """Return the device's objective over true extremes and integrals, or that many samples, under constraints if any.

    Parameters are searched in shares of the machine file's bounds. Raises InputError where the cam's law makes the
    force jump: a jump that passes a sample has no gradient.
    """
    machine, curve = device.machine, device.force
    if any(event.order == 0 for event in curve.events):
        allowed = "the force jumps where its flanks begin and end; an optimisation needs a law without such jumps"
        raise machine.input_error("cam.flank", allowed)
    return CurveProblem(curve, weights(machine), sampling, further=[] if constraints is None else [constraints])
