"""A kind of machine from a package outside the project: installed, it is there, and no list of ours names it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMANDS = '''
import typer
from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def seeder(name: str, as_json: JsonOption = False) -> None:
    """Spacing of a seeder."""
    console = Console(as_json)
    with console.outcome():
        from planter.files import examples
        from planter.files.text import parse_toml

        table = parse_toml(examples.text(name, "seeder"), name)
        spacing = {"spacing_mm": 1e3 * table["speed_m_s"] / table["rate_Hz"]}
        console.result(spacing, lambda: console.table("Seeder", ["quantity", "value"], spacing.items()))
'''
FORMULA = """
from planter.audit.registry import Inputs, formula


@formula("spacing of a seeder")
def spacing(inputs: Inputs) -> float:
    return float(1e3 * inputs["speed_m_s"] / inputs["rate_Hz"])
"""
NUMBERS = """
title = "A paper of nobody"
place = 9

[disclosed]
speed_m_s = 0.6

[assumed]

[[number]]
quantity = "spacing"
unit = "mm"
by = "spacing of a seeder"
with = {{ rate_Hz = 2 }}
printed = "{printed}"
"""
GENERATED = '{"parameters": []}'


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A folder as `pip install` leaves it: a package of the rooms' shape and its entry point."""
    room = tmp_path / "seeder_room"
    for part in ("examples", "printed", "generated"):
        (room / part).mkdir(parents=True)
    (room / "__init__.py").write_text("")
    (room / "commands.py").write_text(COMMANDS)
    (room / "examples" / "drill.toml").write_text("speed_m_s = 0.5\nrate_Hz = 4\n")
    (room / "printed" / "__init__.py").write_text("")
    (room / "printed" / "spacing.py").write_text(FORMULA)
    (room / "printed" / "nobody2026.toml").write_text(NUMBERS.format(printed="300"))
    (room / "generated" / "__init__.py").write_text("")
    (room / "generated" / "seeder_exact.json").write_text(GENERATED)
    (room / "generated" / "seeder_exact.py").write_text("speed = 3\n")
    metadata = tmp_path / "seeder_room-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: seeder-room\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[planter.machines]\nseeder = seeder_room\n")
    return tmp_path


def python(*arguments: str, beside: Path | None = None) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([*([str(beside)] if beside else []), os.environ.get("PYTHONPATH", "")])
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": path})  # fmt: skip


def test_its_command_and_its_examples_are_there(installed: Path) -> None:
    done = python("-m", "planter", "seeder", "drill", "--json", beside=installed)
    assert json.loads(done.stdout) == {"spacing_mm": 125}, done.stderr
    assert "drill" in python("-m", "planter", "example", beside=installed).stdout.split()


@pytest.mark.parametrize(
    ("printed", "verdict"), [("300", "reproduced"), ("310", "consistent"), ("400", "not reproduced")]
)
def test_its_paper_is_on_trial(installed: Path, printed: str, verdict: str) -> None:
    (installed / "seeder_room" / "printed" / "nobody2026.toml").write_text(NUMBERS.format(printed=printed))
    done = python("-m", "planter", "audit", "nobody2026", "--json", beside=installed)
    (number,) = json.loads(done.stdout)["numbers"]
    assert (number["recomputed"], number["verdict"]) == (300, verdict)


def test_its_generated_code_is_found(installed: Path) -> None:
    script = "from planter.kernels import generated as g; print(g.module('seeder_exact').speed, g.names('seeder'))"
    assert python("-c", script, beside=installed).stdout.strip() == "3 ['seeder_exact']"


def test_without_it_nothing_of_it_is_there() -> None:
    assert python("-m", "planter", "seeder", "drill").returncode == 2
    assert "drill" not in python("-m", "planter", "example").stdout.split()


def test_one_that_cannot_be_loaded_costs_a_line_and_nothing_else(installed: Path) -> None:
    (installed / "seeder_room" / "commands.py").write_text("import nowhere_at_all\n")
    done = python("-m", "planter", "example", beside=installed)
    assert (done.returncode, "wang2017" in done.stdout.split()) == (0, True)
    assert done.stderr == "seeder_room is left out: ModuleNotFoundError: No module named 'nowhere_at_all'\n"
