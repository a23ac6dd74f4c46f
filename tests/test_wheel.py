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
    own = Path(shutil.copy(ROOT / "tests" / "derive" / "own" / "slider_crank.py", tmp_path))
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
    assert len(written[0]) == 5


def test_the_wheel_optimises_in_an_empty_environment(wheel: Path, tmp_path: Path) -> None:
    place = tmp_path / "environment"
    venv.create(place, with_pip=True)
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    install = [
        str(place / "bin" / "python"),
        "-m",
        "pip",
        "install",
        "--quiet",
        "--constraint",
        str(ROOT / "constraints.txt"),
    ]
    subprocess.run([*install, str(wheel)], cwd=tmp_path, env=clean, check=True)
    command = [str(place / "bin" / "planter"), "optimise", "wang2017", "--json"]
    done = subprocess.run(command, cwd=tmp_path, env=clean, capture_output=True, text=True, check=True)
    result = json.loads(done.stdout)
    assert result["objective"] < result["start_objective"]
    assert result["certificate"]["kkt_residual"] < 1e-6
    has_sympy = subprocess.run([str(place / "bin" / "python"), "-c", "import sympy"], capture_output=True, check=False)
    assert has_sympy.returncode != 0, "the derivation's packages must not be needed at run time"
