"""A folder that is used again holds what the last command wrote, and whatever else is the user's own."""

import json
from pathlib import Path

import pytest

from planter.files.text import read_text
from planter.report import files, folder_lock
from planter.report.folder import NAME, keep, renewing, renews


@renews
def write(out: Path, names: dict[str, str]) -> None:
    for name, text in names.items():
        path = files.output_folder((out / name).parent) / Path(name).name
        files.write_text(path, text)


@renews
def stopped(out: Path) -> None:
    for name in ("both.csv", "half.csv"):
        files.write_text(out / name, "new")
    raise KeyboardInterrupt


def held(folder: Path) -> set[str]:
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return found - {NAME, folder_lock.NAME}


def test_what_an_earlier_command_wrote_goes_and_empty_folders_with_it(tmp_path: Path) -> None:
    write(tmp_path, {"summary.json": "1", "figures/a.svg": "a", "figures/deep/b.svg": "b"})
    write(tmp_path, {"summary.json": "2", "cycle.csv": "c"})
    assert held(tmp_path) == {"summary.json", "cycle.csv"}
    assert not (tmp_path / "figures").exists()
    assert set(json.loads((tmp_path / NAME).read_text())["files"]) == held(tmp_path)


def test_nothing_else_is_touched(tmp_path: Path) -> None:
    write(tmp_path, {"figures/a.svg": "a", "plan.csv": "as written", "table.csv": "read"})
    (tmp_path / "figures" / "own.svg").write_text("own")
    (tmp_path / "plan.csv").write_text("filled in since")
    read_text(tmp_path / "table.csv")
    write(tmp_path, {"summary.json": "2"})
    assert held(tmp_path) == {"figures/own.svg", "plan.csv", "table.csv", "summary.json"}


@pytest.mark.parametrize("name", ["../own.txt", "/{}", "link/own.txt", ""])
def test_a_list_that_leads_out_of_the_folder_is_not_followed(tmp_path: Path, name: str) -> None:
    own, out = tmp_path / "own.txt", tmp_path / "out"
    own.write_text("own")
    write(out, {"a.csv": "own"})
    (out / "link").symlink_to(tmp_path)
    listed = json.loads((out / NAME).read_text())
    listed["files"][name.format(own)] = listed["files"]["a.csv"]
    (out / NAME).write_text(json.dumps(listed))
    write(out, {"b.csv": "b"})
    assert own.read_text() == "own"
    assert held(out) == {"b.csv"}


@pytest.mark.parametrize(
    "content",
    ["", "[]", '{"files": 3}', "{", "[" * 100_000, '{"files": {"own.txt": 1}}', '{"files": {"a\\u0000b": ""}}'],
)
def test_a_broken_list_removes_nothing(tmp_path: Path, content: str) -> None:
    (tmp_path / NAME).write_text(content)
    (tmp_path / "own.txt").write_text("own")
    write(tmp_path, {"a.csv": "a"})
    assert held(tmp_path) == {"own.txt", "a.csv"}


def test_an_interrupted_command_removes_nothing_and_the_next_one_all(tmp_path: Path) -> None:
    write(tmp_path, {"old.csv": "old", "both.csv": "old"})
    with pytest.raises(KeyboardInterrupt):
        stopped(tmp_path)
    assert held(tmp_path) == {"old.csv", "both.csv", "half.csv"}
    assert (tmp_path / "both.csv").read_text() == "new"
    write(tmp_path, {"last.csv": "last"})
    assert held(tmp_path) == {"last.csv"}


def test_a_command_may_go_on_from_files_of_an_earlier_one(tmp_path: Path) -> None:
    write(tmp_path, {"devices/a.json": "a", "devices/b.json": "b"})
    with renewing(tmp_path):
        keep(tmp_path / "devices" / "a.json")
        write(tmp_path, {"summary.json": "1"})
        assert held(tmp_path) == {"devices/a.json", "devices/b.json", "summary.json"}
    assert held(tmp_path) == {"devices/a.json", "summary.json"}


def test_without_a_folder_nothing_is_listed(tmp_path: Path) -> None:
    with renewing(None):
        files.write_text(tmp_path / "a.csv", "a")
    assert not (tmp_path / NAME).exists()
