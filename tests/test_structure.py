"""The structure: no import cycles, layers, general packages without machines, banned interfaces."""

import itertools
import subprocess
import sys
from pathlib import Path

import pytest

from planter import plugins
from tests.support import structure
from tests.support.structure import FOUNDATION, ROOT, ImportGraph, read_imports

MACHINES = sorted(plugins.find_folders("examples"))
LAYERS = {
    "planter": (
        (FOUNDATION,),
        ("files", "kernels"),
        ("numerics", "report"),
        ("audit", "engine", "gears", "studio"),
        ("measured", "rows"),
        ("mechanism",),
        ("exports", "papers"),
        ("cli",),
    ),
    "derive": (
        (FOUNDATION,),
        ("mechanics",),
        ("audit", "emit"),
        ("papers",),
    ),
}
"""Packages, the lowest layer first. All below the papers know no machine of a paper."""
MACHINE_PARTS = ("file", "model", "results", "commands", "printed", "examples")
"""What the package of every machine has, as a module, a package or a folder."""


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


@pytest.mark.parametrize("package", LAYERS)
def test_packages_import_only_from_lower_layers(package: str) -> None:
    imports = read_imports(package)
    assert imports.packages.keys() == set(itertools.chain(*LAYERS[package]))
    assert not imports.list_upward_imports(LAYERS[package])


def test_modules_do_not_import_the_public_interface() -> None:
    imports = read_imports("planter").imports
    assert not [module for module, imported in imports.items() if "planter" in imported]


def test_the_papers_machines_do_not_import_each_other() -> None:
    for module, imported in read_imports("planter").imports.items():
        room, _, package = module.partition(".papers.")
        home = f"{room}.papers.{package.partition('.')[0]}"
        if package:
            assert not [
                name
                for name in imported
                if ".papers." in name and not f"{name}.".startswith(f"{home}.")
            ]


@pytest.mark.parametrize("machine", MACHINES)
def test_machines_have_the_same_parts(machine: str) -> None:
    folder = ROOT / "planter" / "papers" / machine
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
        "jobs",
        "menu",
        "paths",
        "plugins",
        "progress",
        "safe_text",
        "task",
        "text_files",
        "version",
        "workers",
    }


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


BANNED = """\
import sympy
def f():
    from derive.model import Model
    from multiprocessing import get_context
    os.system("ls")
    s.Popen(["ls"])
    futures.ProcessPoolExecutor()
    command = [sys.executable]
"""


def test_banned_interfaces_are_detected() -> None:
    """Derivation in what runs, and processes that others than `planter.workers` start."""
    head = "import os\nimport sys\nimport subprocess as s\nfrom concurrent import futures\n"
    words = ["check", "--config", str(ROOT / "pyproject.toml"), "--select", "TID251"]
    words += ["--stdin-filename", "planter/engine/module.py", "--output-format", "concise", "-"]
    done = subprocess.run(
        [sys.executable, "-m", "ruff", *words],
        input=head + BANNED,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.count("TID251") == BANNED.count("\n") - 1


def test_compilers_are_not_started_as_python() -> None:
    """What runs foreign programs does not know where the interpreter is."""
    assert "executable" not in (ROOT / "planter/kernels/builds.py").read_text(encoding="utf-8")
