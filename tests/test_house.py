"""How the house is built: general rooms know no machine, nothing goes round in a circle, nothing points upwards."""

import ast
from pathlib import Path

import pytest

from planter import plugins
from tests.support import picture
from tests.support.house import FOUNDATION, ROOT, House, standing
from tests.support.starts import find_starts

MACHINES = sorted(plugins.find_folders("examples"))
GENERAL = (
    (FOUNDATION,), ("parallel", "records"), ("files",), ("kernels", "terminal"), ("numerics", "report"),
    ("gear_geometry", "optimise", "audit", "view", "workshop", "interchange"), ("engine",),
    ("exports", "gears", "measured", "sweeps"), ("tolerance",), ("explain", "mechanism"),
)  # fmt: skip
"""Rooms that know no machine, the lowest layer first; machines stand above them, what shows them all on top."""
DERIVATION = ((FOUNDATION,), ("audit", "mechanics"), ("gearing",), ("emit", "systems"), ("papers",))
SHAPE = ("file", "model", "results", "commands", "printed", "examples")
"""What every machine's room holds, as a module, a package or a folder."""


def layers(house: House, general: tuple[tuple[str, ...], ...]) -> list[list[str]]:
    """All rooms of a house by layers: the general ones, the machines, and what is above."""
    known = {room for layer in general for room in layer} | set(MACHINES)
    return [*map(list, general), MACHINES, sorted(house.rooms.keys() - known)]


def of_texts(folder: Path, texts: dict[str, str]) -> House:
    """A house of modules given as texts."""
    for name, text in texts.items():
        path = folder / "house" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return House.of(folder / "house")


@pytest.mark.parametrize("package", ["planter", "derive"])
def test_no_module_imports_itself_round_about(package: str) -> None:
    assert not standing(package).circle()


def test_no_room_imports_one_on_its_own_layer_or_above() -> None:
    planter = standing("planter")
    assert not planter.upward(layers(planter, GENERAL))
    assert not standing("derive").upward(DERIVATION)


def test_nothing_inside_comes_in_by_the_front_door() -> None:
    imports = standing("planter").imports
    assert not [module for module, imported in imports.items() if "planter" in imported]


def test_every_general_room_is_there() -> None:
    assert {room for layer in GENERAL for room in layer} <= standing("planter").rooms.keys()
    assert MACHINES == ["clutch", "mapping", "pickup", "planting"]


@pytest.mark.parametrize("machine", MACHINES)
def test_machines_have_the_same_shape(machine: str) -> None:
    room = ROOT / "planter" / machine
    assert not [part for part in SHAPE if not ((room / part).is_dir() or (room / f"{part}.py").is_file())]


def test_the_root_holds_the_interface_and_next_to_nothing_else() -> None:
    assert {path.stem for path in (ROOT / "planter").glob("*.py")} == {
        "__init__", "__main__", "errors", "safe_text", "plugins", "progress", "version", "workers",
    }  # fmt: skip


def test_planter_never_imports_the_derivation() -> None:
    for path in (ROOT / "planter").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert not {name.partition(".")[0] for name in names} & {"derive", "sympy"}, path


def test_the_picture_is_that_of_the_house() -> None:
    assert picture.PICTURE.read_text(encoding="utf-8") == picture.picture(), "python -m tests.support.picture"


UPWARD = {
    "at the top of a module": "from house.machine import model\n",
    "within a function": "def f():\n    from house.machine.model import size\n",
    "for the type checker": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import house.machine.model\n",
    "relative": "from ..machine import model\n",
    "by the room's own __init__": "from house.machine import size\n",
}


@pytest.mark.parametrize("text", UPWARD.values(), ids=UPWARD.keys())
def test_a_general_room_that_knows_a_machine_is_found(text: str, tmp_path: Path) -> None:
    place = "general/__init__" if "size\n" in text and "def" not in text else "general/tool"
    house = of_texts(tmp_path, {
        "__init__": "", "general/__init__": "", "machine/__init__": "size = 1\n", "machine/model": "size = 1\n",
        place: text,
    })  # fmt: skip
    assert house.upward([["general"], ["machine"]]) == [("general", "machine")]
    assert not house.upward([["machine"], ["general"]])


def test_a_circle_through_a_function_is_found(tmp_path: Path) -> None:
    one, two = "from house.b import y\nx = 1\n", "y = 1\ndef f():\n    from house.a import x\n"
    assert set(of_texts(tmp_path, {"__init__": "", "a": one, "b": two}).circle()) == {"house.a", "house.b"}


STARTERS = ("workers.py", "kernels/builds.py")
"""Of `planter`: what starts Python, isolated, and what runs foreign programs, such as compilers."""
STARTS = {
    "a function": "import subprocess\nsubprocess.run(['ls'])\n",
    "another name": "import subprocess as s\ndef f():\n    s.Popen(['ls'])\n",
    "imported": "from subprocess import check_output\n",
    "without an import": "import os\nos.spawnv(0, 'ls', [])\n",
    "a shell": "import os\nos.system('ls')\n",
    "a pool": "from concurrent.futures import ProcessPoolExecutor\n",
    "a pool by its module": "import concurrent.futures\nconcurrent.futures.ProcessPoolExecutor()\n",
    "spawn": "def f():\n    from multiprocessing import get_context\n",
    "an event loop": "import asyncio\nasync def f():\n    await asyncio.create_subprocess_exec('ls')\n",
    "the interpreter": "import sys\ncommand = [sys.executable]\n",
}


def test_processes_start_in_one_place() -> None:
    """Python is started isolated by `planter.workers`, foreign programs by `planter.kernels.builds`, and no others."""
    for path in (ROOT / "planter").rglob("*.py"):
        if path.relative_to(ROOT / "planter").as_posix() not in STARTERS:
            assert not list(find_starts(path.read_text(encoding="utf-8"))), path


def test_compilers_are_not_started_as_python() -> None:
    """What runs foreign programs does not know where the interpreter is."""
    source = (ROOT / "planter/kernels/builds.py").read_text(encoding="utf-8")
    assert {name for _, name in find_starts(source)} == {"subprocess.Popen"}


@pytest.mark.parametrize("text", STARTS.values(), ids=STARTS.keys())
def test_any_other_start_of_a_process_is_recognised(text: str) -> None:
    assert list(find_starts(text))


def test_a_type_of_process_is_no_start() -> None:
    assert not list(find_starts("import subprocess\ndef f(one: subprocess.Popen[str]) -> None:\n    one.kill()\n"))
