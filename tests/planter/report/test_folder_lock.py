"""A folder has one owner at a time, and the lock ends with the owner, whatever ends it."""

import errno
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from planter.errors import InputError
from planter.report import folder
from planter.report.folder import renew_files

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
