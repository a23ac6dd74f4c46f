"""The public interface: light, every name there, nothing handed in is changed."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Callable
from dataclasses import is_dataclass
from pathlib import Path

import numpy as np
import pytest

import derive
import derive.toolkit as toolkit
import planter
from planter import Device, InputError, Record, load_machine, plugins
from tests.support import own
from tests.support.structure import ROOT

HEAVY = {"numpy", "casadi", "matplotlib", "pandas", "pydantic", "scipy"}


def run_script(script: str) -> list[str]:
    """Return the words that a process prints."""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def test_planter_is_light_to_import() -> None:
    script = "import sys, planter; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    assert not HEAVY & set(run_script(script))


def test_commands_import_only_their_needs() -> None:
    """What all commands are put together of knows no numbers: help, completion and refusals come at
    once.
    """
    script = (
        "import sys; from planter.cli.app import build_application; build_application(); "
        "print(*sys.modules)"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "planter.mechanism.analysis_commands" in loaded
    assert not {"numpy", "casadi", "matplotlib", "pandas", "pydantic", "scipy"} & set(loaded)
    assert not {name for name in loaded if name.startswith("planter.") and ".results." in name}


def test_derive_is_light_to_import_and_offers_the_toolkit() -> None:
    script = "import sys, derive; print('sympy' in sys.modules, *derive.__all__)"
    light, *names = run_script(script)
    assert light == "False"
    assert names == list(toolkit.__all__) == sorted(toolkit.__all__)
    assert set(names) <= set(dir(derive))
    assert all(hasattr(derive, name) for name in names)


def test_every_name_is_there_and_no_room_has_it() -> None:
    assert planter.__all__ == sorted(planter.__all__)
    assert set(planter.__all__) <= set(dir(planter))
    assert not set(planter.__all__) & plugins.find_packages().keys()
    with pytest.raises(AttributeError, match="no attribute 'Devise'"):
        planter.Devise  # noqa: B018


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(load_machine("wang2017"))


def test_designs_carry_names_and_units(device: Device) -> None:
    x = device.x(R3_mm=31.0, m31=1.5)
    assert device.named(x) == {**device.named(device.design), "R3_mm": 31.0, "m31": 1.5}
    assert x[device.names.index("R3_mm")] == pytest.approx(0.031, rel=1e-15)
    assert (device.x() == device.design).all()
    assert device.x() is not device.design
    with pytest.raises(
        InputError, match="R3_m is not a design parameter of wang2017: did you mean R3_mm"
    ):
        device.x(R3_m=0.031)
    with pytest.raises(InputError, match="it must be one of theta_deg, "):
        device.x(unheard_of=1.0)


def state(device: Device) -> dict[str, object]:
    """Everything of a device that a call might change, kernels that are made at the first use
    apart.
    """
    saved = {
        key: value
        for key, value in vars(device).items()
        if isinstance(value, np.ndarray | bool | str | tuple)
    }
    arrays = {
        key: value.tobytes() if isinstance(value, np.ndarray) else value
        for key, value in saved.items()
    }
    return arrays | {"machine": device.machine.model_dump_json()}


def calls() -> dict[str, Callable[[Device], object]]:
    return {
        "simulate": lambda device: planter.simulate(device, 24, [100.0]),
        "sensitivity": lambda device: planter.sensitivity(device, 24),
        "validate": planter.validate,
        "optimise_device": lambda device: planter.optimise_device(device, "ipopt", "24", starts=1),
        "evaluate_many": lambda device: planter.evaluate_many(device, device.design[None], 24),
        "Turns": lambda device: planter.Turns(device, 24).gradient(device.x(R3_mm=31.0)),
        "html": lambda device: device._repr_html_(),
    }


@pytest.mark.parametrize("call", calls().values(), ids=calls().keys())
def test_passed_device_is_not_changed(call: Callable[[Device], object]) -> None:
    device = Device(load_machine("wang2017"))
    before = state(device)
    call(device)
    assert state(device) == before


def test_a_changed_device_is_noticed() -> None:
    device = Device(load_machine("wang2017"))
    before = state(device)
    device.constants[0] *= 1 + 1e-12
    assert state(device) != before


def test_results_are_shown_as_tables_and_safe_text(device: Device) -> None:
    simulation = planter.simulate(device, 24)
    text = simulation._repr_html_()
    assert text.startswith("<table>")
    assert "support_force.range_N" in text
    hostile = Device(device.machine.model_copy(update={"name": "<script>alert(1)</script>"}))
    assert "<script" not in hostile._repr_html_()


def test_rows_become_frames(device: Device) -> None:
    simulation = planter.simulate(device, 24, [0.0, 100.0])
    assert list(simulation.to_frame()["phi_deg"]) == list(simulation.angles_deg)
    assert list(simulation.result.to_frame()["phi_deg"]) == [0.0, 100.0]
    batch = planter.evaluate_many(device, device.design[None], 24)
    assert batch.to_frame()["objective"][0] == batch.objective[0]
    with pytest.raises(InputError, match="has no rows warnigs"):
        simulation.result.to_frame("warnigs")
    with pytest.raises(InputError, match="has no rows to make a table of"):
        simulation.result.support_force.to_frame()


def test_missing_pandas_is_refused_in_a_sentence(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match=r"pip install 'planter\[notebook\]'"):
        planter.simulate(device, 24).to_frame()


def test_records_are_frozen_and_their_keys_are_those_of_the_json(device: Device) -> None:
    result = planter.simulate(device, 24).result
    assert is_dataclass(result)
    assert isinstance(result, Record)
    assert result.table()["support_force"]["range_N"] == result.support_force.range_N
    with pytest.raises(AttributeError):
        result.samples = 1  # type: ignore[misc]


def test_python_of_the_pages_runs_as_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    shutil.copytree(own.generated("slider_crank"), tmp_path / "own")
    monkeypatch.chdir(tmp_path)
    pages = ((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("use.md", "own.md"))
    text = "\n".join(pages)
    blocks = [
        textwrap.dedent(block) for block in re.findall(r"(?:^(?: {4}.*)?\n)+", text, re.MULTILINE)
    ]
    python_blocks = [
        block for block in blocks if "from planter import" in block and ">>>" not in block
    ]
    assert [
        name in "".join(python_blocks) for name in ("device.x(", "evaluate_many(", "Kernel(")
    ] == [True] * 3
    space: dict[str, object] = {}
    for block in python_blocks:
        exec(compile(block, "page", "exec"), space)
    assert space["designs"].shape == (100, 3)
