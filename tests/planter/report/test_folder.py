"""A folder that is used again holds what the last command wrote, and whatever else is the user's
own.
"""

from __future__ import annotations

import errno
import json
import subprocess
import sys
import threading
from collections.abc import Callable
from os import replace as rename
from pathlib import Path

import pytest

from planter.errors import InputError
from planter.report import files, folder
from planter.report.folder import (
    LOCK_NAME,
    NAME,
    allow_overwriting,
    keep_file,
    renew_files,
    renews_files,
)
from planter.text_files import read_text


@renews_files
def write(out: Path, names: dict[str, str]) -> None:
    for name, text in names.items():
        path = files.output_folder((out / name).parent) / Path(name).name
        files.write_text(path, text)


@renews_files
def stopped(out: Path) -> None:
    for name in ("both.csv", "half.csv"):
        files.write_text(out / name, "new")
    raise KeyboardInterrupt


def list_files(folder: Path) -> set[str]:
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return files - {NAME, LOCK_NAME}


def test_earlier_files_and_empty_folders_are_removed(tmp_path: Path) -> None:
    write(tmp_path, {"summary.json": "1", "figures/a.svg": "a", "figures/deep/b.svg": "b"})
    write(tmp_path, {"summary.json": "2", "cycle.csv": "c"})
    assert list_files(tmp_path) == {"summary.json", "cycle.csv"}
    assert not (tmp_path / "figures").exists()
    assert set(json.loads((tmp_path / NAME).read_text())["files"]) == list_files(tmp_path)


def test_other_files_are_not_touched(tmp_path: Path) -> None:
    write(tmp_path, {"figures/a.svg": "a", "plan.csv": "as written", "table.csv": "read"})
    (tmp_path / "figures" / "own.svg").write_text("own")
    (tmp_path / "plan.csv").write_text("filled in since")
    read_text(tmp_path / "table.csv")
    write(tmp_path, {"summary.json": "2"})
    assert list_files(tmp_path) == {"figures/own.svg", "plan.csv", "table.csv", "summary.json"}


@pytest.mark.parametrize("name", ["../own.txt", "/{}", "link/own.txt", ""])
def test_manifest_leading_outside_is_not_followed(tmp_path: Path, name: str) -> None:
    user_file, out = tmp_path / "own.txt", tmp_path / "out"
    user_file.write_text("own")
    write(out, {"a.csv": "own"})
    (out / "link").symlink_to(tmp_path)
    listed = json.loads((out / NAME).read_text())
    listed["files"][name.format(user_file)] = listed["files"]["a.csv"]
    (out / NAME).write_text(json.dumps(listed))
    write(out, {"b.csv": "b"})
    assert user_file.read_text() == "own"
    assert list_files(out) == {"b.csv"}


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        '{"files": 3}',
        "{",
        "[" * 100_000,
        '{"files": {"own.txt": 1}}',
        '{"files": {"a\\u0000b": ""}}',
    ],
)
def test_broken_manifest_removes_no_files(tmp_path: Path, content: str) -> None:
    (tmp_path / NAME).write_text(content)
    (tmp_path / "own.txt").write_text("own")
    write(tmp_path, {"a.csv": "a"})
    assert list_files(tmp_path) == {"own.txt", "a.csv"}


def test_interrupted_command_leaves_cleanup_to_next(tmp_path: Path) -> None:
    write(tmp_path, {"old.csv": "old", "both.csv": "old"})
    with pytest.raises(KeyboardInterrupt):
        stopped(tmp_path)
    assert list_files(tmp_path) == {"old.csv", "both.csv", "half.csv"}
    assert (tmp_path / "both.csv").read_text() == "new"
    write(tmp_path, {"last.csv": "last"})
    assert list_files(tmp_path) == {"last.csv"}


def test_command_may_continue_from_earlier_files(tmp_path: Path) -> None:
    write(tmp_path, {"devices/a.json": "a", "devices/b.json": "b"})
    with renew_files(tmp_path):
        keep_file(tmp_path / "devices" / "a.json")
        write(tmp_path, {"summary.json": "1"})
        assert list_files(tmp_path) == {"devices/a.json", "devices/b.json", "summary.json"}
    assert list_files(tmp_path) == {"devices/a.json", "summary.json"}


def test_single_files_are_listed_and_not_removed(tmp_path: Path) -> None:
    with renew_files(None):
        files.write_text(tmp_path / "a.csv", "a")
    write(tmp_path, {"summary.json": "1"})
    write(tmp_path, {"cycle.csv": "2"})
    assert list_files(tmp_path) == {"a.csv", "cycle.csv"}
    files.write_text(tmp_path / "a.csv", "b")
    assert (tmp_path / "a.csv").read_text() == "b"


def write_own(path: Path) -> None:
    path.write_text("own")


def edit_result(path: Path) -> None:
    write(path.parent, {path.name: "1"})
    path.write_text("edited")


def link_elsewhere(path: Path) -> None:
    path.symlink_to(path.parent.parent / "elsewhere")


def link_to_result(path: Path) -> None:
    write(path.parent, {path.name: "1"})
    path.rename(path.with_name("own"))
    path.symlink_to("own")


@pytest.mark.parametrize("make", [write_own, edit_result, link_elsewhere, link_to_result])
def test_only_files_of_planter_are_replaced(tmp_path: Path, make: Callable[[Path], None]) -> None:
    path = tmp_path / "out" / "summary.json"
    path.parent.mkdir()
    make(path)
    before = path.read_bytes() if path.exists() else None
    with pytest.raises(InputError, match=r"summary\.json.*--overwrite"):
        files.write_bundle(path.parent, {"cycle.csv": "2", "summary.json": "2"}, {})
    assert (path.read_bytes() if path.exists() else None) == before
    assert not (path.parent / "cycle.csv").exists()
    with pytest.raises(InputError):
        write(path.parent, {"summary.json": "2"})
    with allow_overwriting(True):
        write(path.parent, {"summary.json": "2"})
    assert (path.read_text(), path.is_symlink()) == ("2", False)
    write(path.parent, {"summary.json": "3"})
    assert path.read_text() == "3"


def test_the_same_content_is_no_change(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("1")
    write(tmp_path, {"summary.json": "1"})
    write(tmp_path, {"summary.json": "2"})


@pytest.mark.parametrize("step", ["list", "file"])
def test_kill_between_manifest_and_file_is_safe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    write(tmp_path, {"summary.json": "1"})

    def killed(part: Path, path: Path) -> None:
        if (Path(path).name == NAME) is (step == "list"):
            raise KeyboardInterrupt
        rename(part, path)

    with monkeypatch.context() as patch:
        patch.setattr("os.replace", killed)
        with pytest.raises(KeyboardInterrupt):
            write(tmp_path, {"summary.json": "2"})
    write(tmp_path, {"summary.json": "3"})
    assert (tmp_path / "summary.json").read_text() == "3"


def test_figures_have_files_each_within_the_folder(tmp_path: Path) -> None:
    names = ("s < 3", "s > 3", "s * 3", "../../own")
    figures = {name: {"svg": f"<svg>{name}</svg>"} for name in names}
    files.write_bundle(tmp_path / "out", {}, figures)
    written = (tmp_path / "out" / "figures").glob("*.svg")
    assert {path.read_text(encoding="utf-8") for path in written} == {
        figure["svg"] for figure in figures.values()
    }
    assert {path.name for path in tmp_path.iterdir()} == {"out"}


OWNER = """\
import sys
from planter.report.folder import renew_files
with renew_files(sys.argv[1]):
    print("owned", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def owner(tmp_path: Path) -> subprocess.Popen[str]:
    """A process that owns a folder."""
    with subprocess.Popen(
        [sys.executable, "-c", OWNER, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "owned\n"
        yield process
        process.kill()


def test_a_second_process_is_refused_until_the_first_is_killed(
    tmp_path: Path, owner: subprocess.Popen[str]
) -> None:
    with pytest.raises(InputError) as refused, renew_files(tmp_path):
        pytest.fail("two owners")
    assert str(tmp_path) in refused.value.message
    assert str(owner.pid) in refused.value.message
    assert [path.name for path in tmp_path.iterdir()] == [folder.LOCK_NAME]
    owner.kill()
    owner.wait()
    with renew_files(tmp_path):
        pass
    assert not (tmp_path / folder.LOCK_NAME).exists()


def test_a_second_thread_is_refused_too(tmp_path: Path) -> None:
    errors: list[InputError] = []

    def own_too() -> None:
        try:
            with renew_files(tmp_path):
                pass
        except InputError as error:
            errors.append(error)

    with renew_files(tmp_path):
        thread = threading.Thread(target=own_too)
        thread.start()
        thread.join()
    assert len(errors) == 1


def test_owners_take_turns(tmp_path: Path) -> None:
    """Many at once, each of which tries until it is the owner: never two."""
    owners, largest = [], []

    def own_folder() -> None:
        while True:
            try:
                with folder.lock_folder(tmp_path):
                    owners.append(1)
                    largest.append(len(owners))
                    owners.pop()
                    return
            except InputError:
                continue

    threads = [threading.Thread(target=own_folder) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert largest == [1] * 8


def test_a_file_of_the_user_is_neither_locked_nor_removed(tmp_path: Path) -> None:
    path = tmp_path / folder.LOCK_NAME
    path.write_text("my notes")
    with pytest.raises(InputError, match=folder.LOCK_NAME), renew_files(tmp_path):
        pytest.fail("no owner")
    assert path.read_text() == "my notes"


def test_a_file_system_without_locks_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_file: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(folder, "_lock", refuse)
    with pytest.warns(RuntimeWarning, match="no locks"), renew_files(tmp_path):
        pass
