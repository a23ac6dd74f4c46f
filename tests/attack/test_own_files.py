"""No command overwrites or deletes a file that planter did not write: it names the file, and
nothing is written.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath

import pytest
import typer

from derive.generated_folder import OwnError, add_files, list_strays
from planter.cli.app import build_application
from planter.report import files
from planter.report.folder import NAME, renew_files
from planter.safe_text import file_name
from tests.support.cli import run
from tests.support.structure import ROOT

COMMANDS = {
    "animate wang2017 --out own.gif": "own.gif",
    "audit --out .": "summary.json",
    "about bench --quick --out .": "bench.json",
    "calibrate wang2017 --out .": "summary.json",
    "cam wang2017 --roller-mm 6 --out .": "contour.dxf",
    "design clutch design shi2021 --shaft-mm 20 --out .": "way.csv",
    "design clutch engage shi2021 --out .": "report.html",
    "design clutch field --out .": "summary.json",
    "design clutch geometry shi2021 --out .": "figures/travel.svg",
    "design clutch optimise shi2021 --out .": "summary.json",
    "design clutch plan L4 --out .": "plan.csv",
    "design clutch rotor --out .": "summary.json",
    "optimise wang2017 --all-pairs --out .": "devices.csv",
    "diff compact wang2017 --out .": "summary.json",
    "simulate compact --motor --stall-Nm 30 --idle-rpm 60 --flywheel-kgm2 1 --out .": "turn.csv",
    "about explain wang2017 --out .": "symbols.csv",
    "export c wang2017 --out .": "wang2017_main.c",
    "linearise free --out .": "summary.json",
    "export fmu wang2017 --out own.fmu": "own.fmu",
    "export motion wang2017 --out .": "motion.csv",
    "gears wang2017 --out .": "report.html",
    "simulate own --until 1 --out .": "values.csv",
    "optimise wang2017 --out .": "cycle.csv",
    "optimise own --least F_Ox --out .": "optimum.toml",
    "design pickup yu2023 --out .": "path.csv",
    "sensitivity wang2017 --out .": "report.html",
    "simulate wang2017 --out .": "figures/support_force.png",
    "studio wang2017 --static own.html": "own.html",
    "sweep plan.toml --out .": "rows.csv",
    "design synthesise sun2019 --out .": "summary.json",
    "tolerance wang2017 --out .": "tolerances.toml",
    "design train sun2019-curve --out .": "pitch_curves.csv",
}
"""Every command that writes, and a file of the user's that is in its way."""


def contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.mark.parametrize(("command", "name"), COMMANDS.items())
def test_files_of_users_stay(
    command: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for existing in (name, "notes.txt"):
        (tmp_path / existing).parent.mkdir(exist_ok=True)
        (tmp_path / existing).write_text("own")
    code, out, err = run(*command.split())
    assert (code, out) == (2, "")
    assert name in err
    assert "--overwrite" in err
    assert contents(tmp_path) == {name: b"own", "notes.txt": b"own"}


def walk(command: typer.core.TyperGroup, *words: str) -> Iterator[tuple[str, set[str]]]:
    for name, inner in getattr(command, "commands", {}).items():
        if hasattr(inner, "commands"):
            yield from walk(inner, *words, name)
        else:
            yield (
                " ".join((*words, name)),
                {option for parameter in inner.params for option in parameter.opts},
            )


def test_every_writing_command_is_covered() -> None:
    options = dict(walk(typer.main.get_command(build_application())))
    writing = {
        name for name, known_options in options.items() if known_options & {"--out", "--static"}
    }
    assert writing == {
        name for name, known_options in options.items() if "--overwrite" in known_options
    }
    checked = {name for name in writing for command in COMMANDS if command.startswith(f"{name} ")}
    derived = {"derive", "export casadi", "export jax", "export rust"}  # whose file must be derived
    assert checked == writing - derived


def test_a_result_is_replaced_unless_it_was_edited(tmp_path: Path) -> None:
    command = ("sensitivity", "wang2017", "--samples", "36", "--out", str(tmp_path))
    assert [run(*command)[0] for _ in range(2)] == [0, 0]
    (tmp_path / "report.html").write_text("edited")
    assert run(*command)[0] == 2
    assert (tmp_path / "report.html").read_text() == "edited"
    assert run(*command, "--overwrite")[0] == 0
    assert (tmp_path / "report.html").read_text() != "edited"


def test_the_name_of_a_machine_leads_out_of_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    _, text, _ = run("example compact")
    lines = ['name = "../ABS"' if line.startswith("name =") else line for line in text.splitlines()]
    Path("own.toml").write_text("\n".join(lines))
    code, _, err = run("animate own.toml --seconds 0.1")
    assert code == 0, err
    assert [path.name for path in tmp_path.iterdir()] == ["here"]
    assert len(list(Path().glob("*.gif"))) == 1


NAMES = (
    "/somewhere/ABS",
    "..",
    ".hidden",
    "nul.txt",
    "COM1",
    "a" * 300,
    "\ud800\x00\n",
    "",
    "C:\\x",
    "-rf",
    "ß" * 150,
    "e\u0301",
)


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_any_name_becomes_a_file_name(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"{file_name(name)}.gif"
    path.touch()
    assert path.parent == tmp_path
    assert not path.name.startswith((".", "-"))
    assert not PureWindowsPath(path.name).is_reserved()
    assert file_name(file_name(name)) == file_name(name)


@pytest.mark.long
def test_deriving_overwrites_no_source_and_no_edited_table(tmp_path: Path) -> None:
    source = tmp_path / "slider_crank.py"
    shutil.copy(ROOT / "docs" / "examples" / source.name, source)
    before = contents(tmp_path)
    code, _, err = run(f"derive {source} --out {tmp_path}")
    assert (code, source.name in err) == (2, True)
    assert contents(tmp_path) == before
    assert run(f"derive {source}")[0] == 0
    table = tmp_path / "generated" / "slider_crank.toml"
    table.write_text(table.read_text() + "# edited\n")
    (tmp_path / "generated" / "notes.txt").write_text("own")
    before = contents(tmp_path)
    code, _, err = run(f"derive {source}")
    assert (code, table.name in err) == (2, True)
    assert {k: v for k, v in contents(tmp_path).items() if "__pycache__" not in k} == before
    assert run(f"derive {source} --overwrite")[0] == 0
    assert "# edited" not in table.read_text()
    assert (tmp_path / "generated" / "notes.txt").read_text() == "own"
    assert (tmp_path / "generated" / NAME).is_file()


def test_derived_files_replace_only_derived_ones(tmp_path: Path) -> None:
    texts = {"own.py": "1", "own.toml": "1", "array/own.py": "1"}
    add_files(tmp_path, texts)
    changed = {**texts, "own.py": "2", "array/own.py": "2"}
    (tmp_path / "own.toml").write_text("edited")
    with pytest.raises(OwnError, match=r"own\.toml.*--overwrite"):
        add_files(tmp_path, {**changed, "own.toml": "2"})
    assert (tmp_path / "array" / "own.py").read_text() == "1"
    (tmp_path / "own.toml").write_text("1")
    add_files(tmp_path, changed)
    assert {name: (tmp_path / name).read_text() for name in texts} == changed
    (tmp_path / "notes.py").write_text("own")
    with pytest.raises(OwnError, match=r"notes\.py"):
        add_files(tmp_path, {"notes.py": "1"})
    add_files(tmp_path, {"notes.py": "1"}, overwrite=True)
    assert (tmp_path / "notes.py").read_text() == "1"
    assert not list(list_strays(tmp_path, {**changed, "notes.py": "1"}))


def test_manifests_of_derivation_and_results_are_equal(tmp_path: Path) -> None:
    """What one of them wrote is known to the other, and neither removes it."""
    add_files(tmp_path, {"own.py": "1"})
    files.write_text(tmp_path / "own.py", "2")
    add_files(tmp_path, {"own.py": "3"})
    with renew_files(tmp_path):
        files.write_text(tmp_path / "summary.json", "1")
    with renew_files(tmp_path):
        pass
    assert {path.name for path in tmp_path.iterdir()} == {"own.py", NAME}
