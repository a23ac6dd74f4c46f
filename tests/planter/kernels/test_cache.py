"""What is loaded is the user's own: strangers' files, folders and links are refused with one
warning.
"""

import os
import shutil
import socket
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from planter.kernels import Kernel, backends, toolchain
from planter.kernels.toolchain import RefusedFileError
from tests.support.lanes import build_square, needs_compiler

pytestmark = needs_compiler


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "above" / "cache"))
    monkeypatch.delenv("PLANTER_KERNELS", raising=False)
    monkeypatch.setattr(toolchain, "_warnings", [])
    return tmp_path / "above" / "cache"


def way(kernel: Kernel) -> str:
    """How a kernel is evaluated after `compile`; its numbers are right in any case."""
    kernel.compile()
    assert kernel(x=[3.0, 4.0])["y"].tolist() == [[9, 16]]
    return kernel.way


def compiled() -> Path:
    """The library of a kernel, by the work of a process before."""
    return backends.build_library(build_square().work, "lanes")


def owned_by_another(monkeypatch: pytest.MonkeyPatch, path: Path) -> None:
    """As seen by those who ask; giving files away takes root."""
    number = path.stat().st_ino

    def seen(ask: Callable[..., os.stat_result]) -> Callable[..., os.stat_result]:
        def read_status(*words: object, **how: object) -> os.stat_result:
            state = ask(*words, **how)
            return (
                os.stat_result([*state[:4], 54321, *state[5:]]) if state.st_ino == number else state
            )

        return read_status

    for name in ("stat", "fstat"):
        monkeypatch.setattr(os, name, seen(getattr(os, name)))


def _link(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))
    path.symlink_to("elsewhere")


def _pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def _folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def _socket(path: Path) -> None:
    path.unlink()
    before = Path.cwd()
    os.chdir(path.parent)
    try:
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(path.name)
    finally:
        os.chdir(before)


STRANGE = {
    "a link": (_link, "is a link"),
    "a pipe": (_pipe, "is no file"),
    "a folder": (_folder, "is no file"),
    "a socket": (_socket, "cannot be read"),
    "a file that others may write": (lambda path: path.chmod(0o702), "may be written by others"),
}


class TestLibrary:
    @pytest.mark.parametrize("case", STRANGE)
    def test_unsafe_folder_is_refused_with_a_single_warning(
        self, case: str, caplog: pytest.LogCaptureFixture
    ) -> None:
        path = compiled()
        assert way(build_square()) == "lanes"
        change, reason = STRANGE[case]
        change(path)
        for _ in range(2):
            assert way(build_square()) == "casadi-vm"
        (message,) = [r.getMessage().partition("functions: ")[2] for r in caplog.records]
        assert message.startswith(f"{path} is not loaded: it {reason}")
        assert not backends.is_compiled(build_square().work)

    def test_folder_of_another_user_is_refused(
        self, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
    ) -> None:
        path = compiled()
        owned_by_another(monkeypatch, path)
        assert way(build_square()) == "casadi-vm"
        assert [r.getMessage() for r in caplog.records] == [
            f"planter: slower without compiled functions: {path} is not loaded: it belongs to "
            f"another user"
        ]

    def test_each_folder_has_a_warning(self, caplog: pytest.LogCaptureFixture) -> None:
        kernels = [build_square(name) for name in ("one", "two")]
        for kernel in kernels:
            backends.build_library(kernel.work, "lanes").chmod(0o777)
        for kernel in kernels:
            kernel.compile()
        first, second = (r.getMessage() for r in caplog.records)
        assert "/one-" in first
        assert "/two-" in second

    def test_library_without_function_is_ignored(
        self, tmp_path: Path, caplog: pytest.LogCaptureFixture
    ) -> None:
        """A whole library with its true digest, under another's name: nothing in it has run."""
        path, trace = compiled(), tmp_path / "trace"
        other = (
            f"#include <stdio.h>\n__attribute__((constructor)) void f(void) {{ "
            f'fclose(fopen("{trace}", "w")); }}\n'
        )
        wrong = toolchain.build_library("other", other, toolchain.OPTIMISED)
        shutil.copy(wrong, path)
        assert toolchain.is_intact(path)
        assert way(build_square()) == "casadi-vm"
        assert not trace.exists()
        assert [r.getMessage().partition("functions: ")[2] for r in caplog.records] == [
            f"{path} is not used: it lacks one of the functions square"
        ]
        toolchain.load_library(wrong)
        assert trace.exists()

    def test_library_naming_only_the_function_is_ignored(
        self, caplog: pytest.LogCaptureFixture
    ) -> None:
        path = compiled()
        wrong = toolchain.build_library(
            "other", 'const char *f(void) { return "square"; }\n', toolchain.OPTIMISED
        )
        shutil.copy(wrong, path)
        assert way(build_square()) == "casadi-vm"
        assert "lacks one of the functions square" in caplog.text


class TestFolder:
    @pytest.mark.parametrize(
        ("mode", "above"), [(0o777, 0o755), (0o770, 0o755), (0o700, 0o777), (0o700, 0o775)]
    )
    def test_library_writable_by_others_is_refused(
        self,
        mode: int,
        above: int,
        folder: Path,
        monkeypatch: pytest.MonkeyPatch,
        caplog: pytest.LogCaptureFixture,
    ) -> None:
        monkeypatch.setattr(toolchain, "_is_private_group", lambda group: False)
        compiled()
        folder.chmod(mode)
        folder.parent.chmod(above)
        for _ in range(2):
            assert way(build_square()) == "casadi-vm"
        open_one = folder if above == 0o755 else folder.parent
        assert [r.getMessage().partition("functions: ")[2] for r in caplog.records] == [
            f"the folder for compiled functions, {folder}, is open to other users: {open_one} may "
            f"be written by others"
        ]
        folder.chmod(0o700)
        folder.parent.chmod(0o1777)
        assert way(build_square()) == "lanes"

    def test_a_group_of_the_user_alone_is_nobody_else(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        compiled()
        folder.parent.chmod(0o775)
        monkeypatch.setattr(
            toolchain, "_is_private_group", lambda group: group == folder.parent.stat().st_gid
        )
        assert way(build_square()) == "lanes"

    def test_library_of_another_user_is_refused(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        compiled()
        for place in (folder, folder.parent):
            with monkeypatch.context() as patch:
                owned_by_another(patch, place)
                with pytest.raises(
                    RefusedFileError, match=f"open to other users: {place} belongs to another user"
                ):
                    toolchain.cache_folder()

    def test_link_target_is_judged(self, folder: Path, tmp_path: Path) -> None:
        """Whoever moves his cache to another disk keeps it; what is loaded is where the link
        led.
        """
        (tmp_path / "disk").mkdir()
        folder.parent.symlink_to("disk")
        assert compiled().parent == tmp_path / "disk" / "cache"
        (tmp_path / "disk").chmod(0o777)
        with pytest.raises(RefusedFileError, match="disk may be written by others"):
            toolchain.cache_folder()


def test_written_files_are_private(folder: Path) -> None:
    before = os.umask(0)
    try:
        path = compiled()
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o700
    assert [stat.S_IMODE(place.stat().st_mode) for place in (folder, folder.parent)] == [0o700] * 2
