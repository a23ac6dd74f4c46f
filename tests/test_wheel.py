"""The wheel stands on its own: built, installed into an empty environment, it does the main job
there.

In `make release` and in the long tests an installer fetches what the wheel asks for; in the suite
that is linked.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.support import own, packages

ROOT = Path(__file__).parents[1]
SCRIPTS = "Scripts" if os.name == "nt" else "bin"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `make release` has built, in the folder that PLANTER_DIST names; else one that is built
    now.
    """
    if "PLANTER_DIST" in os.environ:
        return next((ROOT / os.environ["PLANTER_DIST"]).glob("planter-*.whl"))
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        check=True,
    )
    return next(folder.glob("planter-*.whl"))


def test_wheel_contains_generated_code_and_derivation(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {"planter/generated/planting_exact.py", "planter/generated/planting_exact.json"} <= names
    assert {
        "planter/papers/planting/examples/wang2017.toml",
        "planter/exports/machine.c",
        "planter/py.typed",
    } <= names
    assert {
        "derive/__main__.py",
        "derive/papers/planting/derivation.py",
        "derive/papers/wang2017.py",
    } <= names
    assert {"planter/docs/measures.md", "planter/docs/examples/slider_crank.py"} <= names
    assert not [name for name in names if name.startswith(("generated/", "tests/", "docs/"))]
    assert not [name for name in names if name.startswith("planter/docs/") and "/book/" in name]


def test_wheel_derives_user_file(wheel: Path, tmp_path: Path) -> None:
    """Unpacked, far from the checkout; what it writes is what the checkout writes."""
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    example = Path(shutil.copy(ROOT / "docs" / "examples" / "slider_crank.py", tmp_path))
    command = [sys.executable, "-m", "derive", str(example), "--out"]
    for site, out in ((tmp_path / "site", "there"), (ROOT, "here")):
        clean = os.environ | {"PYTHONPATH": str(site)}
        subprocess.run(
            [*command, str(tmp_path / out)],
            cwd=tmp_path,
            env=clean,
            check=True,
            stdout=subprocess.DEVNULL,
        )
    query = [sys.executable, "-c", "import derive; print(derive.__file__)"]
    clean = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    process = subprocess.run(
        query, cwd=tmp_path, env=clean, check=True, capture_output=True, text=True
    ).stdout
    assert Path(process.strip()).is_relative_to(tmp_path / "site")
    written = [
        {p.relative_to(tmp_path / out): p.read_bytes() for p in (tmp_path / out).rglob("*.*")}
        for out in ("there", "here")
    ]
    assert written[0] == written[1]
    assert len(written[0]) == 8  # each of both folders has the list of its files


@pytest.fixture(scope="module")
def environment(wheel: Path, fetched: bool, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment that holds the wheel and what it needs, and nothing of the derivation's."""
    place = tmp_path_factory.mktemp("environment")
    venv.create(place)
    install(place, wheel, fetched)
    return place / SCRIPTS


@pytest.fixture(scope="module")
def fetched(request: pytest.FixtureRequest) -> bool:
    """Whether an installer fetches what the wheel asks for."""
    return (
        "PLANTER_DIST" in os.environ
        or request.config.getoption("markexpr") == "long"
        or os.name == "nt"
    )


def install(place: Path, wheel: Path, fetched: bool, extra: str = "") -> None:
    """Install a wheel into an environment, or let one that has it have what an extra asks for
    too.
    """
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(place),
        "install",
        "--quiet",
        "--force-reinstall",
    ]
    if fetched:
        more = [
            "--constraint",
            str(ROOT / "constraints.txt"),
            f"{wheel}[{extra}]" if extra else str(wheel),
        ]
    else:
        packages.link(
            packages.of_wheel(wheel), extra, next(place.glob("lib/python*/site-packages"))
        )
        if extra:
            return
        more = ["--no-deps", str(wheel)]
    subprocess.run([*pip, *more], cwd=place, env=CLEAN, check=True)


def long(name: str) -> Any:
    """A case of the long tests."""
    return pytest.param(name, marks=pytest.mark.long)


CLEAN = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}


def run(folder: Path, *command: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*map(str, command)], cwd=folder, env=CLEAN, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    "options", [("--method", "ipopt", "--starts", "1"), pytest.param((), marks=pytest.mark.long)]
)
def test_the_wheel_optimises_in_an_empty_environment(
    options: tuple[str, ...], environment: Path, tmp_path: Path
) -> None:
    result = json.loads(
        run(tmp_path, environment / "planter", "optimise", "wang2017", *options, "--json").stdout
    )
    assert result["objective"] < result["start_objective"]
    assert result["certificate"]["kkt_residual"] < 1e-6


def test_templates_and_pages_are_in_the_wheel(environment: Path, tmp_path: Path) -> None:
    """Without SymPy, which the words of statements do not need."""
    written = read(run(tmp_path, environment / "planter", "new", "slider-crank", "--json"))
    statement = (ROOT / "docs" / "examples" / "slider_crank.py").read_bytes()
    assert (tmp_path / written["files"][0]).read_bytes() == statement
    index = read(run(tmp_path, environment / "planter", "help", "--json"))
    for name in ("m.pin", "measures"):
        assert name in index["words"] | index["pages"]
        text = read(run(tmp_path, environment / "planter", "help", name, "--json"))["text"]
        assert len(text.splitlines()) > 3


@pytest.fixture(scope="module")
def examples(
    wheel: Path, environment: Path, fetched: bool, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder with the examples, in the environment that SymPy was added to then."""
    place = tmp_path_factory.mktemp("examples")
    for path in EXAMPLES.glob("*.*"):
        shutil.copy(path, place)
    without = run(place, environment / "planter", "derive", "slider_crank.py", "--json")
    assert (without.returncode, without.stdout) == (2, ""), "SymPy must not be there yet"
    assert "pip install 'planter[derive]'" in without.stderr
    install(environment.parent, wheel, fetched, "derive")
    return place


@pytest.fixture
def derived(name: str, environment: Path, examples: Path, tmp_path: Path) -> Path:
    """A folder with what is derived of one example."""
    read(
        run(
            tmp_path,
            environment / "planter",
            "derive",
            examples / f"{name}.py",
            "--out",
            "generated",
            "--json",
        )
    )
    return tmp_path


def read(done: subprocess.CompletedProcess[str]) -> Any:
    """The object that a command printed."""
    assert not done.returncode, done.stderr
    return json.loads(done.stdout)


EXAMPLES = ROOT / "docs" / "examples"
TURNED = {
    "slider_crank": "range F_Ox",
    "transplanting_arm": "max M_in",
    "cam_follower": "rms M_in",
    "planetary_train": "range F_Ox",
}
"""Examples that an angle drives, and what an optimisation makes least."""
MOVED = {"manipulator": "1", "andrews": "0.01", "whipple": "0.5"}
"""Examples that move by themselves, and for how long [s]."""
MECHANISMS = (*TURNED, *MOVED)
OTHERS = {"slider_crank_paper", "elliptic_gears"}
"""A paper about one of them, and formulas without a mechanism."""


def test_every_example_is_run_here() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {*MECHANISMS, *OTHERS, *own.LIBRARY}


def test_doors_of_the_first_page_open(environment: Path, examples: Path, tmp_path: Path) -> None:
    """Word for word, one after the other in an empty folder; the studio is served until it ends."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    calls = [line.split("#")[0] for line in page.splitlines() if line.startswith("    planter ")]
    assert [call.split()[1] for call in calls][:2] == ["new", "derive"]
    for call in calls:
        name, *words = shlex.split(call)
        if "studio" not in words:
            done = run(tmp_path, environment / name, *words)
            assert done.returncode == 0, (call, done.stderr)
    best = read(run(tmp_path, environment / "planter", "simulate", "best/optimum.toml", "--json"))
    assert best["quantities"]["M_in_Nm"]["max"] < 0.2
    assert (tmp_path / "trial" / "report.html").is_file()
    for name in re.findall(r"`planter (--help|doctor)`", page):
        assert run(tmp_path, environment / "planter", name).stdout


def test_user_file_runs_from_wheel(environment: Path, examples: Path) -> None:
    content = read(
        run(
            examples,
            environment / "planter",
            "derive",
            "slider_crank.py",
            "--out",
            "alone",
            "--json",
        )
    )
    assert {Path(name).stem for name in content["files"]} == {"slider_crank", "__init__"}
    assert len(content["files"]) == 6
    still = read(
        run(
            examples,
            environment / "planter",
            "simulate",
            "alone/slider_crank.toml",
            "--json",
            "--set",
            "e_mm=0",
        )
    )
    assert still["quantities"]["s_mm"]["max"] == pytest.approx(50 + 200, rel=1e-12)


@pytest.mark.parametrize(
    "name", ["cam_follower", *(long(name) for name in TURNED if name != "cam_follower")]
)
def test_an_example_turns_and_is_optimised_from_the_wheel(
    name: str, environment: Path, derived: Path
) -> None:
    turn = read(
        run(derived, environment / "planter", "simulate", name, "--samples", "36", "--json")
    )
    assert max(law["violation"] for law in turn["laws"]) < 1e-9
    options = ("--least", TURNED[name], "--starts", "1", "--out", f"best {name}", "--json")
    best = read(run(derived, environment / "planter", "optimise", name, *options))
    assert best["objective"] < best["start_objective"]
    again = read(
        run(derived, environment / "planter", "simulate", f"best {name}/optimum.toml", "--json")
    )
    assert again["machine"] == turn["machine"]


@pytest.mark.parametrize("name", [long(name) for name in MOVED])
def test_an_example_moves_by_itself_from_the_wheel(
    name: str, environment: Path, derived: Path
) -> None:
    options = ("--until", MOVED[name], "--points", "5", "--json")
    result = read(run(derived, environment / "planter", "simulate", name, *options))
    assert result["until_s"] == float(MOVED[name])
    assert result["redundant_constraints"] == 0


@pytest.mark.long
def test_example_paper_and_gears_run_from_wheel(environment: Path, examples: Path) -> None:
    trial = (
        "slider_crank_paper.py",
        "--numbers",
        "slider_crank_numbers.toml",
        "--out",
        "trial",
        "--json",
    )
    result = read(run(examples, environment / "planter", "audit", *trial))
    verdicts = [entry["verdict"] for entry in result["equations"]]
    assert sorted(verdicts) == [
        "confirmed",
        "confirmed",
        "confirmed",
        "incomplete",
        "misprint",
        "misprint",
    ]
    gears = read(
        run(
            examples,
            environment / "planter",
            "derive",
            "elliptic_gears.py",
            "--out",
            "gears",
            "--json",
        )
    )
    assert {"elliptic_gears.py", "AUDIT.md"} <= {Path(name).name for name in gears["files"]}
