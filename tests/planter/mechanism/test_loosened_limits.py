"""A limit that is looser never makes a search fail that succeeded with the tighter one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planter.engine.goal import bound_measure, evaluate_measure, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import Limit, parse_limit
from planter.engine.search import SearchSpec
from planter.mechanism.optimisation import optimise_machine
from tests.support import own

LIMITS = tuple(
    map(parse_limit, ("max abs M_in <= 1 N m", "s at 180 >= 1 mm", "max s_dot <= 1 m/s"))
)
SHARES = (0.0, 0.01, 0.1, 1.0)
"""Shares of themselves by which limits are loosened."""


def tighten(machine: Machine, random: np.random.Generator) -> list[Limit]:
    """Return limits that a random design within the bounds reaches exactly."""
    shares = random.random(len(machine.design))
    x = machine.lower + shares * (machine.upper - machine.lower)
    reached = machine.with_data(machine.build_data(x))
    measures = [resolve_measure(machine, bound_measure(limit)) for limit in LIMITS]
    return [
        replace(limit, number=float(evaluate_measure(reached, measure)))
        for limit, measure in zip(LIMITS, measures, strict=True)
    ]


def search(machine: Machine, limits: list[Limit], seed: int) -> float:
    holds = [
        f"{limit.measure} {'<=' if limit.sign > 0 else '>='} {float(limit.number)!r} {limit.unit}"
        for limit in limits
    ]
    spec = SearchSpec(method="ipopt", starts=1, seed=seed)
    return optimise_machine(machine, "rms M_in", holds, spec).result.objective


@pytest.mark.parametrize(
    "seed", [seed if seed < 3 else pytest.param(seed, marks=pytest.mark.long) for seed in range(20)]
)
def test_looser_limits_do_not_fail(seed: int) -> None:
    machine, random = own.machine("slider_crank"), np.random.default_rng(seed)
    tight = tighten(machine, random)
    loose = [
        replace(limit, number=limit.number + limit.sign * share * abs(limit.number))
        for limit, share in zip(tight, random.choice(SHARES, len(tight)).tolist(), strict=True)
    ]
    assert search(machine, loose, seed) <= search(machine, tight, seed) * (1 + 1e-6)
