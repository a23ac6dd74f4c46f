"""Own planting devices: designs that satisfy their limits, or the reason why there is none."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from planter.papers.planting.design_presentation import write_partial
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.optimisation import optimise
from planter.papers.planting.requirements import (
    InfeasibleRequirementsError,
    RequirementConstraints,
)
from planter.progress import Progress
from tests.support.planting_devices import CROPS, INFEASIBLE, build_planting_machine

MOST_CPU_S = 60.0


def mark_slow(names: list[str], quick: str) -> list[object]:
    return [name if name == quick else pytest.param(name, marks=pytest.mark.long) for name in names]


@pytest.mark.parametrize("name", mark_slow([n for n in CROPS if n not in INFEASIBLE], "endive"))
def test_own_device_has_a_design_that_satisfies_its_limits(name: str) -> None:
    device, begun = Device(build_planting_machine(name)), time.process_time()
    starts = 1 if name == "endive" else 2
    result = optimise(device, starts=starts).result
    assert result.objective == pytest.approx(result.refined.objective, rel=1e-9)
    assert result.objective < result.start_objective
    assert result.requirements is not None
    assert {row.verdict for row in result.requirements} == {"pass"}
    assert result.certificate.kkt_residual < 1e-6
    bounds, wider = result.certificate.active_bounds, result.wider
    assert (wider is None) == (not bounds)
    if wider is not None:
        assert wider.objective <= result.objective * (1 + 1e-9)
        assert set(wider.bounds) == {bound.name for bound in bounds}
    assert "local searches from" in result.searches
    assert time.process_time() - begun < MOST_CPU_S


@pytest.mark.parametrize("name", mark_slow(list(INFEASIBLE), "aubergine in a hurry"))
def test_own_device_without_a_design_is_told_why(name: str, tmp_path: Path) -> None:
    device, begun, steps = Device(build_planting_machine(name)), time.process_time(), []
    with pytest.raises(InfeasibleRequirementsError) as caught:
        optimise(device, starts=2, progress=steps.append)
    error, limit = caught.value, INFEASIBLE[name]
    assert error.message.startswith("2 starts, none satisfies all limits; the closest misses ")
    assert limit in {violated.name for violated in error.violations}
    assert limit in error.partial["conflict"]
    assert limit in {change["name"] for change in error.partial["relaxations"]}
    notes = [step.note for step in steps if isinstance(step, Progress)]
    assert any(limit in note for note in notes), "progress names what is violated most"
    write_partial(tmp_path, device, {**error.partial, "met": False})
    closest = Device(load(str(tmp_path / "closest.toml")))
    required = RequirementConstraints.from_device(closest)
    assert required is not None
    broken = {row.name for row in required.record(closest.design) if row.verdict != "pass"}
    assert broken == {violated.name for violated in error.violations}
    assert time.process_time() - begun < MOST_CPU_S


def test_crops_have_their_spacing_and_size() -> None:
    """Half a turn of travel is the distance between plants; wrong units would be warned of."""
    from planter.papers.planting.plausible import find_implausible_values

    for name, crop in CROPS.items():
        machine = build_planting_machine(name)
        travel = abs(machine.operation.forward_speed_m_s) * 30 / machine.operation.speed_rpm
        assert 1e3 * travel == pytest.approx(crop.spacing_mm), name
        assert not find_implausible_values(machine), name
