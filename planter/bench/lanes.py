"""Our own way: the public functions, as a user calls them."""

from __future__ import annotations

from planter.bench.case import Absent, Case, Contender
from planter.kernels import toolchain
from planter.planting.batches import evaluate_many


def contender(case: Case, work: str) -> Contender:
    turns = case.turns
    if turns.way != "lanes":
        raise Absent(f"this machine evaluates turns by {turns.way}")
    built = " ".join((*toolchain.loop_flags(toolchain.OPTIMISED), *toolchain.compiler().flags))
    if work == "cycle":
        return Contender(turns.value, f"Turns.value; {built}")
    if work == "cycle+gradient":
        return Contender(turns.gradient, f"Turns.gradient; {built}")
    if work == "hessian":
        case.device.compile()
        kernel = case.device.force.response.hessian_kernel
        kernel.compile()
        return Contender(turns.hessian, f"Turns.hessian, {kernel.way}; {built}")
    return Contender(lambda designs: evaluate_many(case.device, designs, case.turns.samples).objective,
                     f"evaluate_many, all cores; {built}")  # fmt: skip
