"""The wheel stands on its own: built, installed into an empty environment, it does the main job there."""

import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)], cwd=ROOT, check=True)
    return next(folder.glob("planter-*.whl"))


def test_the_wheel_ships_generated_code_and_machines_and_the_derivation(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {"planter/generated/planting_exact.py", "planter/generated/planting_exact.json"} <= names
    assert {"planter/planting/examples/wang2017.toml", "planter/planting/export/machine.c", "planter/py.typed"} <= names
    assert {"derive/__main__.py", "derive/systems/planting/derivation.py", "derive/papers/wang2017.py"} <= names
    assert not [name for name in names if name.startswith(("generated/", "tests/"))]


def test_the_wheel_derives_a_file_of_a_users_own(wheel: Path, tmp_path: Path) -> None:
    """Unpacked, far from the checkout; what it writes is what the checkout writes."""
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    own = Path(shutil.copy(ROOT / "docs" / "examples" / "slider_crank.py", tmp_path))
    command = [sys.executable, "-m", "derive", str(own), "--out"]
    for site, out in ((tmp_path / "site", "there"), (ROOT, "here")):
        clean = os.environ | {"PYTHONPATH": str(site)}
        subprocess.run([*command, str(tmp_path / out)], cwd=tmp_path, env=clean, check=True, stdout=subprocess.DEVNULL)
    asked = [sys.executable, "-c", "import derive; print(derive.__file__)"]
    clean = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    found = subprocess.run(asked, cwd=tmp_path, env=clean, check=True, capture_output=True, text=True).stdout
    assert Path(found.strip()).is_relative_to(tmp_path / "site")
    written = [{p.relative_to(tmp_path / out): p.read_bytes() for p in (tmp_path / out).rglob("*.*")}
               for out in ("there", "here")]  # fmt: skip
    assert written[0] == written[1]
    assert len(written[0]) == 6


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment that holds the wheel and what it needs, and nothing of the derivation's."""
    place = tmp_path_factory.mktemp("environment")
    venv.create(place, with_pip=True)
    install(place, str(wheel))
    return place / "bin"


def install(place: Path, *what: str) -> None:
    command = [str(place / "bin" / "python"), "-m", "pip", "install", "--quiet"]
    subprocess.run([*command, "--constraint", str(ROOT / "constraints.txt"), *what], cwd=place, env=CLEAN, check=True)


CLEAN = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}


def run(folder: Path, *command: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*map(str, command)], cwd=folder, env=CLEAN, capture_output=True, text=True, check=False)


def test_the_wheel_optimises_in_an_empty_environment(environment: Path, tmp_path: Path) -> None:
    result = json.loads(run(tmp_path, environment / "planter", "optimise", "wang2017", "--json").stdout)
    assert result["objective"] < result["start_objective"]
    assert result["certificate"]["kkt_residual"] < 1e-6


def test_a_file_of_ones_own_is_derived_and_evaluated_from_the_wheel(
    wheel: Path, environment: Path, tmp_path: Path
) -> None:
    own = shutil.copy(ROOT / "docs" / "examples" / "slider_crank.py", tmp_path)
    without = run(tmp_path, environment / "planter", "derive", own, "--json")
    assert (without.returncode, without.stdout) == (2, ""), "SymPy must not be there yet"
    assert "pip install 'planter[derive]'" in without.stderr
    install(environment.parent, f"{wheel}[derive]")
    found = json.loads(run(tmp_path, environment / "planter", "derive", own, "--json").stdout)
    assert {Path(name).stem for name in found["files"]} == {"slider_crank", "__init__"}
    assert len(found["files"]) == 6
    still = run(tmp_path, environment / "planter", "turn", "slider_crank", "--json", "--set", "e_mm=0")
    assert json.loads(still.stdout)["quantities"]["s_mm"]["max"] == pytest.approx(50 + 200, rel=1e-12)
