"""What `python -m derive WHAT` makes of files of a user's own: what they may offer, and what is
said of bad ones.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from derive import generation
from derive.__main__ import main
from derive.mechanics.gearing.families import FAMILIES
from derive.quantity import _RESERVED
from planter.kernels import generated
from tests.support import centrifuge

LEVER = """
from derive import ClosedForm, Let, Quantity, System, Vector
from lengths import arm

force = Quantity("force", "N", "force at the end", "drawing")
moment = Quantity("moment", "N m", "moment about the hinge", "derived")


def lever():
    step = Let(moment, arm * force, "derived: lever")
    form = ClosedForm("turning", (arm, force), (step,), Vector("given", (moment,)))
    return System("lever", "Lever", "derived", ("rigid",), closed_forms=(form,))


SYSTEMS = (lever,)
"""
LENGTHS = """
from derive import Quantity

arm = Quantity("arm", "m", "length of the lever", "drawing")
"""
FAMILY = """
import sympy as sp

from derive import Condition, PitchCurve, Quantity, register
from derive.mechanics.gearing.pitch_curve import swing, u


@register
class Exponential(PitchCurve):
    name = "exponential"
    title = "deformed exponential curve"
    R = Quantity("R", "m", "geometric mean radius", "test", shown="R_mm")
    b = Quantity("b", "1", "logarithm of the largest radius over R", "test", shown="b")
    parameters = (R, b)

    def radius(self):
        return self.R * sp.exp(self.b * sp.cos(u))

    def conditions(self):
        return [Condition("R", self.R, "greater than 0"), Condition("b", self.b, "greater than 0")]

    def relative(self):
        return sp.Integer(1), sp.log((1 + swing) / (1 - swing)) / 4
"""
TARGET = """
from derive import Dialect, Printer, Target
from derive.emit.expression import PLAIN

MATH = Dialect({f: f"math.{f}" for f in PLAIN} | {"pi": "math.pi"}, ratio="{0} / {1}", length="len({0})")


def model(system, functions):
    lines = ["import math"]
    for function in functions:
        results = ", ".join(map(Printer(MATH), function.returned))
        lines += [f"def {function.name}({function.names()}):", function.body(MATH), f"    return ({results},)"]
    return "\\n".join(lines) + "\\n"


def curve(family, functions):
    return f"# {family.title}\\n"


TARGET = Target("plain", "plain/{name}.py", frozenset({"math"}), model, curve)
"""


@pytest.fixture(autouse=True)
def registries() -> Iterator[None]:
    """Families and reserved names as before."""
    families, reserved = dict(FAMILIES), dict(_RESERVED)
    yield
    for registry, before in ((FAMILIES, families), (_RESERVED, reserved)):
        registry.clear()
        registry.update(before)
    for name in (
        "lengths",
        "derive_own_lever",
        "derive_own_lengths",
        "derive_own_curve",
        "derive_own_plain",
    ):
        sys.modules.pop(name, None)


def written(folder: Path, **files: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return folder


def names(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("[!.]*") if path.is_file()}


def test_file_may_import_a_neighbour(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = written(tmp_path / "own", lever=LEVER, lengths=LENGTHS)
    path = list(sys.path)
    assert main([str(folder / "lever.py")]) == 0
    assert sys.path == path
    assert names(folder / "generated") == {
        "__init__.py",
        "array/__init__.py",
        "array/lever.py",
        "lever.py",
        "lever.json",
    }
    assert "5 files" in capsys.readouterr().out
    assert generated.module("array/lever", folder / "generated").turning(np, 0.5, 30.0) == (15.0,)
    assert float(generated.module("lever", folder / "generated").turning()(0.5, 30.0)) == 15.0


def test_folder_with_system_family_and_target(tmp_path: Path) -> None:
    """Each is one file, and no list elsewhere knows it."""
    folder = written(tmp_path / "own", lever=LEVER, lengths=LENGTHS, curve=FAMILY, plain=TARGET)
    assert main([str(folder), "--out", str(tmp_path / "out")]) == 0
    file_names = names(tmp_path / "out")
    assert {
        f"{place}{name}.py"
        for place in ("", "array/", "plain/")
        for name in ("lever", "curve_exponential")
    } < file_names
    assert {"lever.json", "curve_exponential.json", "plain/__init__.py"} < file_names
    assert not (folder / "generated").exists()
    assert generated.module("plain/lever", tmp_path / "out").turning(0.5, 30.0) == (15.0,)
    assert (
        json.loads((tmp_path / "out" / "curve_exponential.json").read_text())["parameters"][1][
            "name"
        ]
        == "b"
    )


def test_other_files_of_the_folder_are_untouched(tmp_path: Path) -> None:
    folder = written(tmp_path / "own", lever=LEVER, lengths=LENGTHS)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    assert main([str(folder / "lever.py"), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_reserved_name_of_user_target_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lever = LEVER.replace('"force", "N"', '"math", "N"')
    folder = written(tmp_path / "own", lever=lever, lengths=LENGTHS, plain=TARGET)
    assert main([str(folder / "lever.py")]) == 0
    assert main([str(folder)]) == 2
    assert (
        "math: generated plain code needs that name; write math_, or another"
        in capsys.readouterr().err
    )


BAD = {
    "a refused name": (
        LEVER.replace('"moment", "N m"', '"lambda", "N m"'),
        "lever.py, line 6: ValueError: quantity lambda: the name is a word of Python; write "
        "lambda_, or another",
    ),
    "a name that a target needs": (
        LEVER.replace('"moment", "N m"', '"vertcat", "N m"'),
        "lever.py, line 6: ValueError: quantity vertcat: generated casadi code needs that name",
    ),
    "a step without its input": (
        LEVER.replace("(arm, force)", "(arm,)"),
        "lever.py, line 11: ValueError: turning: moment needs force, which nothing gives",
    ),
    "no Python": ("def lever(:\n", "lever.py, line 1: SyntaxError: invalid syntax"),
    "a missing module": (
        "import not_there\n",
        "lever.py, line 1: ModuleNotFoundError: No module named 'not_there'",
    ),
    "no model": (
        "SYSTEMS = ('lever',)\n",
        "SYSTEMS and SYSTEM offer models, and 'lever' is not a System",
    ),
    "nothing": ("x = 1\n", "nothing to derive in it; a file offers SYSTEMS"),
    "what nobody can write": (
        LEVER.replace(
            "arm * force",
            "arm * force * __import__('sympy').gamma(2 * force / force + arm / arm + force)",
        ),
        "UnsupportedNode: gamma cannot be written",
    ),
    "two of one name": (
        LEVER.replace("(lever,)", "(lever, lever)"),
        "two models or families are called lever",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_file_error_names_the_line(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, sentence = BAD[case]
    folder = written(tmp_path / "own", lever=text, lengths=LENGTHS)
    assert main([str(folder / "lever.py")]) == 2
    first, *rest = capsys.readouterr().err.splitlines()
    assert str(folder / "lever.py") in first
    assert sentence in first
    assert all(str(folder) in line for line in rest if line.startswith("  File"))
    assert not (folder / "generated").exists()


def test_helper_error_names_helper_and_caller(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = written(tmp_path / "own", lever=LEVER, lengths="1 / 0\n")
    assert main([str(folder / "lever.py")]) == 2
    first, *rest = capsys.readouterr().err.splitlines()
    assert first == f"{folder / 'lengths.py'}, line 1: ZeroDivisionError: division by zero"
    assert [line.split('"')[1] for line in rest if line.startswith("  File")] == [
        str(folder / name) for name in ("lever.py", "lengths.py")
    ]


def test_missing_file_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["no_such_file.py"]) == 2
    assert "no_such_file.py: there is no such file or folder" in capsys.readouterr().err


def process(*arguments: str, path: Path) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(path)}
    command = [sys.executable, "-m", "derive", *arguments]
    return subprocess.run(
        command, env=environment, cwd=path, capture_output=True, text=True, check=False
    )


def test_help_warns_of_execution_and_needs_no_sympy(tmp_path: Path) -> None:
    (tmp_path / "sympy.py").write_text(
        "raise ModuleNotFoundError('No module named sympy', name='sympy')\n"
    )
    done = process("--help", path=tmp_path)
    assert done.returncode == 0
    assert "is run as Python" in " ".join(done.stdout.split())
    done = process("lever.py", path=tmp_path)
    assert done.returncode == 2
    assert (
        done.stderr
        == "deriving needs sympy, which is not installed: pip install 'planter[derive]'\n"
    )


def test_installed_package_adds_a_system(tmp_path: Path) -> None:
    package = written(
        tmp_path / "lever_package",
        lever=LEVER.replace("from lengths", "from lever_package.lengths"),
        lengths=LENGTHS,
        plain=TARGET,
    )
    installed = tmp_path / "lever_package-1.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: lever_package\nVersion: 1\n")
    (installed / "entry_points.txt").write_text(
        "[derive.papers]\nlever = lever_package.lever\n[derive.targets]\nplain = "
        "lever_package.plain\n"
    )
    done = process("lever", path=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "plain/lever.py" in names(package / "generated")
    done = process("levre", path=tmp_path)
    assert done.returncode == 2
    assert "no installed package offers it (they offer lever)" in done.stderr


def test_the_built_in_run_asks_no_installed_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same refusal shows that naming something else does ask."""

    def refused(*groups: str) -> None:
        raise AssertionError(f"asked for {groups}")

    monkeypatch.setattr(generation, "find_entry_points", refused)
    monkeypatch.setattr(generation, "derive_models", lambda rooms: [])
    monkeypatch.setattr(generation, "FAMILIES", {})
    assert generation.derive_code() == {
        "__init__.py": '"""Generated by `python -m derive`; do not edit."""\n'
    }
    with pytest.raises(AssertionError, match=r"asked for \('derive.targets',\)"):
        generation.derive_user_code("lever")


@pytest.mark.parametrize(("factor", "verdict"), [("1", "confirmed"), ("2", "misprint")])
def test_user_paper_is_audited(factor: str, verdict: str, tmp_path: Path) -> None:
    paper_file = tmp_path / f"{centrifuge.NAME}.py"
    paper_file.write_text(centrifuge.TEXT.replace("WEIGHT", factor))
    assert main([str(paper_file)]) == 0
    written = tmp_path / "generated"
    assert {path.name for path in written.glob("[!.]*")} == {
        "audit.json",
        "audit_mathml.json",
        "verdicts.json",
        "AUDIT.md",
    }
    first, second = json.loads((written / "audit.json").read_text())["equations"]
    assert (first["verdict"], second["verdict"]) == (verdict, "confirmed")
