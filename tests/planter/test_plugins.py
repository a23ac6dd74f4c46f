"""Installed packages which add a machine through an entry point."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMANDS = '''
import typer
from planter.report.console import Console
from planter.report.options import JsonOption

app = typer.Typer()


@app.command()
def seeder(name: str, as_json: JsonOption = False) -> None:
    """Spacing of a seeder."""
    console = Console(as_json)
    with console.outcome():
        from planter.files import examples
        from planter.text_files import parse_toml

        table = parse_toml(examples.read_source(name, "seeder"), name)
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
    """Return a folder as `pip install` leaves it: a package of the expected shape and its entry
    point.
    """
    package = tmp_path / "seeder_package"
    for part in ("examples", "printed", "generated"):
        (package / part).mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "commands.py").write_text(COMMANDS)
    (package / "examples" / "drill.toml").write_text("speed_m_s = 0.5\nrate_Hz = 4\n")
    (package / "printed" / "__init__.py").write_text("")
    (package / "printed" / "spacing.py").write_text(FORMULA)
    (package / "printed" / "nobody2026.toml").write_text(NUMBERS.format(printed="300"))
    (package / "generated" / "__init__.py").write_text("")
    (package / "generated" / "seeder_exact.json").write_text(GENERATED)
    (package / "generated" / "seeder_exact.py").write_text("speed = 3\n")
    metadata = tmp_path / "seeder_package-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: seeder-package\nVersion: 1.0\n"
    )
    (metadata / "entry_points.txt").write_text("[planter.machines]\nseeder = seeder_package\n")
    return tmp_path


def run_python(*arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([*([str(folder)] if folder else []), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": path},
    )


def test_installed_package_adds_command_and_examples(installed: Path) -> None:
    done = run_python("-m", "planter", "seeder", "drill", "--json", folder=installed)
    assert json.loads(done.stdout) == {"spacing_mm": 125}, done.stderr
    assert "drill" in run_python("-m", "planter", "example", folder=installed).stdout.split()


@pytest.mark.parametrize(
    ("printed", "verdict"),
    [("300", "reproduced"), ("310", "consistent"), ("400", "not reproduced")],
)
def test_installed_package_adds_paper_to_audit(installed: Path, printed: str, verdict: str) -> None:
    (installed / "seeder_package" / "printed" / "nobody2026.toml").write_text(
        NUMBERS.format(printed=printed)
    )
    done = run_python("-m", "planter", "audit", "nobody2026", "--json", folder=installed)
    (number,) = json.loads(done.stdout)["numbers"]
    assert (number["recomputed"], number["verdict"]) == (300, verdict)


def test_installed_package_adds_generated_code(installed: Path) -> None:
    script = (
        "from planter.kernels import generated as g; print(g.module('seeder_exact').speed, "
        "g.names('seeder'))"
    )
    assert run_python("-c", script, folder=installed).stdout.strip() == "3 ['seeder_exact']"


def test_missing_package_adds_no_command() -> None:
    assert run_python("-m", "planter", "seeder", "drill").returncode == 2
    assert "drill" not in run_python("-m", "planter", "example").stdout.split()


def test_broken_package_is_skipped_with_warning(installed: Path) -> None:
    (installed / "seeder_package" / "commands.py").write_text("import nowhere_at_all\n")
    done = run_python("-m", "planter", "example", folder=installed)
    assert (done.returncode, "wang2017" in done.stdout.split()) == (0, True)
    assert (
        done.stderr
        == "seeder_package is skipped: ModuleNotFoundError: No module named 'nowhere_at_all'\n"
    )
