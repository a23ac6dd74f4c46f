"""The structure: no import cycles, layers, general packages without machines, one place that starts
processes.
"""

import ast
from pathlib import Path

import pytest

from planter import plugins
from tests.support import structure
from tests.support.starts import find_starts
from tests.support.structure import FOUNDATION, ROOT, ImportGraph, read_imports

MACHINES = sorted(plugins.find_folders("examples"))
GENERAL = (
    (FOUNDATION,),
    ("parallel", "records"),
    ("files",),
    ("kernels", "terminal"),
    ("numerics", "report"),
    ("gear_geometry", "optimise", "audit", "view", "workshop", "interchange"),
    ("engine",),
    ("gears", "measured", "sweeps"),
    ("tolerance",),
    ("explain", "mechanism"),
    ("dynamics",),
    ("exports",),
)
"""Packages that do not depend on a machine, the lowest layer first; above them are the machines and
what uses them.
"""
DERIVATION = (
    (FOUNDATION,),
    ("audit", "mechanics"),
    ("gearing",),
    ("emit", "systems"),
    ("papers", "texts"),
)
MACHINE_PARTS = ("file", "model", "results", "commands", "printed", "examples")
"""What the package of every machine has, as a module, a package or a folder."""


def list_layers(graph: ImportGraph) -> list[list[str]]:
    """Return all packages by layers: the general ones, the machines, and what is above."""
    listed = {package for layer in GENERAL for package in layer} | set(MACHINES)
    return [*map(list, GENERAL), MACHINES, sorted(graph.packages.keys() - listed)]


def build_graph(folder: Path, texts: dict[str, str]) -> ImportGraph:
    """Return the imports of modules given as texts."""
    for name, text in texts.items():
        path = folder / "root" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return ImportGraph.read(folder / "root")


@pytest.mark.parametrize("package", ["planter", "derive"])
def test_modules_have_no_import_cycles(package: str) -> None:
    assert not read_imports(package).find_cycle()


def test_packages_import_only_from_lower_layers() -> None:
    planter = read_imports("planter")
    assert not planter.list_upward_imports(list_layers(planter))
    assert not read_imports("derive").list_upward_imports(DERIVATION)


def test_modules_do_not_import_the_public_interface() -> None:
    imports = read_imports("planter").imports
    assert not [module for module, imported in imports.items() if "planter" in imported]


def test_layers_list_existing_packages() -> None:
    assert {package for layer in GENERAL for package in layer} <= read_imports(
        "planter"
    ).packages.keys()
    assert MACHINES == ["clutch", "mapping", "pickup", "planting"]


@pytest.mark.parametrize("machine", MACHINES)
def test_machines_have_the_same_parts(machine: str) -> None:
    folder = ROOT / "planter" / machine
    assert not [
        part
        for part in MACHINE_PARTS
        if not ((folder / part).is_dir() or (folder / f"{part}.py").is_file())
    ]


def test_root_has_only_the_interface_and_the_foundation() -> None:
    assert {path.stem for path in (ROOT / "planter").glob("*.py")} == {
        "__init__",
        "__main__",
        "errors",
        "safe_text",
        "plugins",
        "progress",
        "version",
        "workers",
    }


def test_planter_never_imports_the_derivation() -> None:
    for path in (ROOT / "planter").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert not {name.partition(".")[0] for name in names} & {"derive", "sympy"}, path


def test_picture_is_current() -> None:
    text = structure.PICTURE.read_text(encoding="utf-8")
    assert text == structure.draw_picture(), "python -m tests.support.structure"


UPWARD = {
    "at the top of a module": "from root.machine import model\n",
    "within a function": "def f():\n    from root.machine.model import size\n",
    "for the type checker": (
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import root.machine.model\n"
    ),
    "relative": "from ..machine import model\n",
    "of the package's __init__": "from root.machine import size\n",
}


@pytest.mark.parametrize("text", UPWARD.values(), ids=UPWARD.keys())
def test_upward_import_is_detected(text: str, tmp_path: Path) -> None:
    module = "general/__init__" if "size\n" in text and "def" not in text else "general/tool"
    graph = build_graph(
        tmp_path,
        {
            "__init__": "",
            "general/__init__": "",
            "machine/__init__": "size = 1\n",
            "machine/model": "size = 1\n",
            module: text,
        },
    )
    assert graph.list_upward_imports([["general"], ["machine"]]) == [("general", "machine")]
    assert not graph.list_upward_imports([["machine"], ["general"]])


def test_import_cycle_within_function_is_detected(tmp_path: Path) -> None:
    first, second = "from root.b import y\nx = 1\n", "y = 1\ndef f():\n    from root.a import x\n"
    assert set(build_graph(tmp_path, {"__init__": "", "a": first, "b": second}).find_cycle()) == {
        "root.a",
        "root.b",
    }


STARTERS = ("workers.py", "kernels/builds.py", "optimise/proof/check_proof.py")
"""Of `planter`: what starts Python, isolated, what runs foreign programs, and a script that is run
without planter.
"""
STARTS = {
    "a function": "import subprocess\nsubprocess.run(['ls'])\n",
    "another name": "import subprocess as s\ndef f():\n    s.Popen(['ls'])\n",
    "imported": "from subprocess import check_output\n",
    "without an import": "import os\nos.spawnv(0, 'ls', [])\n",
    "a shell": "import os\nos.system('ls')\n",
    "a pool": "from concurrent.futures import ProcessPoolExecutor\n",
    "a pool by its module": "import concurrent.futures\nconcurrent.futures.ProcessPoolExecutor()\n",
    "spawn": "def f():\n    from multiprocessing import get_context\n",
    "an event loop": (
        "import asyncio\nasync def f():\n    await asyncio.create_subprocess_exec('ls')\n"
    ),
    "the interpreter": "import sys\ncommand = [sys.executable]\n",
}


def test_processes_start_in_a_single_place() -> None:
    """Python is started isolated by `planter.workers`, foreign programs by
    `planter.kernels.builds`, and no others.
    """
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
    assert not list(
        find_starts(
            "import subprocess\ndef f(one: subprocess.Popen[str]) -> None:\n    one.kill()\n"
        )
    )
