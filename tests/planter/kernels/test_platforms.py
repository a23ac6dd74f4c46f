"""Names and commands of other systems: libraries for them are built wherever the bundled compiler
is installed.
"""

import os
import shutil
import subprocess
import sys
import timeit
from importlib.util import find_spec
from pathlib import Path

import pytest

from planter import workers
from planter.engine.outputs import CycleObjective
from planter.kernels import backends, compiler, toolchain
from planter.kernels.compiler import LINUX, MACOS, WINDOWS, Platform
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from tests.support.lanes import needs_compiler

needs_bundled = pytest.mark.skipif(
    find_spec("ziglang") is None, reason="the extra `compiler` is not installed"
)
TARGETS = {
    "x86_64-windows-gnu": WINDOWS,
    "aarch64-macos": MACOS,
    "x86_64-macos": MACOS,
    "aarch64-linux-gnu": LINUX,
}
MAGIC = {LINUX: b"\x7fELF", MACOS: b"\xcf\xfa\xed\xfe", WINDOWS: b"MZ"}
INNER = "double twice(double x) { return 2.0 * x; }\n"
OUTER = "double twice(double x);\ndouble outer(double x) { return 1.0 + twice(x); }\n"


@pytest.mark.parametrize(
    ("system", "expected"),
    [("linux", LINUX), ("darwin", MACOS), ("win32", WINDOWS), ("freebsd14", LINUX)],
)
def test_the_system_decides(
    system: str, expected: Platform, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", system)
    assert compiler.current_platform() is expected


def test_background_process_ignores_interrupt(monkeypatch: pytest.MonkeyPatch) -> None:
    """On Windows a group of its own, elsewhere a session."""
    monkeypatch.setattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 512, raising=False)
    for system, expected in (
        ("win32", {"creationflags": 512}),
        ("linux", {"start_new_session": True}),
    ):
        monkeypatch.setattr(sys, "platform", system)
        assert workers.detached_process_options() == expected


@needs_compiler
def test_library_locked_by_another_process_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows lets nobody replace what is loaded: who comes second takes what the first has
    built.
    """
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))

    def build_and_read(self: Path, target: Path) -> None:
        shutil.copy2(self, target)
        raise PermissionError(
            13, "The process cannot access the file because it is being used by another process"
        )

    monkeypatch.setattr(Path, "replace", build_and_read)
    assert toolchain.is_intact(toolchain.build_library("twice", INNER, ()))


@needs_compiler
@pytest.mark.parametrize(
    ("system", "suffix"), [(LINUX, ".so"), (MACOS, ".dylib"), (WINDOWS, ".dll")]
)
def test_library_name_follows_system(
    system: Platform, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(compiler, "current_platform", lambda: system)
    assert toolchain.library_path("f", "", ()).suffix == suffix


def commands(
    system: Platform, command: tuple[str, ...] = ("cc",), folder: Path = Path("/f")
) -> list[list[str]]:
    place = Path("/kept") / f"f{system.suffix}"
    return [
        system.compile(command, ("-O3",), folder / "f.c", folder / "f.o"),
        system.link(command, folder / "f.o", folder / place.name, place, [Path("/kept/g")]),
    ]


def test_code_is_position_independent_except_on_windows() -> None:
    assert ["-fPIC" in commands(system)[0] for system in (LINUX, MACOS, WINDOWS)] == [
        True,
        True,
        False,
    ]


def test_a_library_says_where_others_find_it() -> None:
    """By its place on macOS, else by the name that it is linked under; all are linked to what they
    need.
    """
    assert "-Wl,-install_name,/kept/f.dylib" in commands(MACOS)[1]
    for system in (LINUX, MACOS, WINDOWS):
        link = commands(system)[1]
        assert link[link.index("-o") + 1] == f"/f/f{system.suffix}"
        assert "/kept/g" in link
        assert ("-lm" in link) == (system is not WINDOWS)


def test_windows_path_stays_a_single_word(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "current_platform", lambda: WINDOWS)
    assert compiler._split_words(r'"C:\Program Files\llvm\clang.exe" -target x') == [
        r"C:\Program Files\llvm\clang.exe",
        "-target",
        "x",
    ]


@pytest.mark.parametrize(
    ("library", "taken"), [(("glibc", "2.36"), True), (("", ""), False), (("musl", "1.2"), False)]
)
def test_mathematics_in_vectors_are_gnus(
    library: tuple[str, str], taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("platform.libc_ver", lambda: library)
    assert bool(compiler.vector_library_flags()) == taken


def built(
    system: Platform,
    target: str,
    folder: Path,
    name: str,
    source: str,
    needed: tuple[Path, ...] = (),
) -> Path:
    """A library for another system, by the flags of the toolchain."""
    command = (*compiler.bundled_command(), "-target", target)
    text, compiled, linked = (folder / f"{name}{suffix}" for suffix in (".c", ".o", system.suffix))
    text.write_text(source)
    flags = toolchain.loop_flags(toolchain.OPTIMISED)
    for result in (
        system.compile(command, flags, text, compiled),
        system.link(command, compiled, linked, linked, needed),
    ):
        subprocess.run(result, check=True, capture_output=True, text=True)
    return linked


@pytest.mark.long
@needs_bundled
@pytest.mark.parametrize("target", TARGETS)
def test_libraries_for_other_systems_are_built(
    target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The force of the built-in machine and a library that needs another, with their names in the
    bytes.
    """
    monkeypatch.setattr(compiler, "ORDER_FLAGS", ())
    monkeypatch.setattr(
        toolchain, "find_compiler", lambda: compiler.Compiler(*compiler.bundled_command(), ())
    )
    system = TARGETS[target]
    work = Device(load("wang2017")).force.response.values_kernel.work
    loop = built(system, target, tmp_path, "support", work.loop)
    inner = built(system, target, tmp_path, "twice", INNER)
    outer = built(system, target, tmp_path, "outer", OUTER, (inner,))
    for library, name in ((loop, b"support"), (inner, b"twice"), (outer, b"outer")):
        content = library.read_bytes()
        assert content.startswith(MAGIC[system])
        assert name in content
    assert inner.name.encode() in outer.read_bytes()


def as_bundled(monkeypatch: pytest.MonkeyPatch, *words: str) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compiler, "bundled_command", lambda: words)


@needs_compiler
class TestWithoutACompiler:
    """The bundled one is used where there is no `cc`, and CC names none."""

    @pytest.fixture(autouse=True)
    def _nothing_on_the_path(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.cc = str(shutil.which("cc"))
        monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
        monkeypatch.delenv(compiler.CACHE_VARIABLE, raising=False)
        monkeypatch.setenv("PATH", f"{os.environ['PATH']}{os.pathsep}{tmp_path}")
        monkeypatch.setattr(shutil, "which", lambda name: None)

    def test_it_is_used_and_says_how_long_it_takes(
        self, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
    ) -> None:
        as_bundled(monkeypatch, self.cc, "-DSOME=1")
        assert toolchain.find_compiler().bundled
        toolchain.build_library("twice", INNER, ())
        toolchain.build_library("thrice", INNER.replace("2.0", "3.0"), ())
        (message,) = [record.getMessage() for record in caplog.records]
        assert (
            f"prepares itself, once: this takes about {compiler.preparation_time_s()} s" in message
        )

    def test_prepared_compiler_is_silent(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
    ) -> None:
        as_bundled(monkeypatch, self.cc)
        monkeypatch.setenv(compiler.CACHE_VARIABLE, str(tmp_path))
        compiler.mark_prepared(tmp_path)
        toolchain.build_library("twice", INNER, ())
        assert not caplog.records

    def test_compiler_in_cc_has_priority(self, monkeypatch: pytest.MonkeyPatch) -> None:
        as_bundled(monkeypatch, self.cc)
        monkeypatch.setenv("CC", "no-such-compiler")
        with pytest.raises(toolchain.CompilerError, match="no-such-compiler"):
            toolchain.find_compiler()

    def test_no_compiler_without_extra(self, monkeypatch: pytest.MonkeyPatch) -> None:
        as_bundled(monkeypatch)
        with pytest.raises(toolchain.CompilerError, match="there is no C compiler 'cc'"):
            toolchain.find_compiler()


def quickest(turns: CycleObjective) -> float:
    """Time of the gradient of a turn [s], of many calls the shortest."""
    return min(timeit.repeat(lambda: turns.gradient(turns.machine.design), number=1, repeat=2000))


@pytest.mark.long
@needs_bundled
@needs_compiler
def test_the_bundled_compiler_finds_the_same_not_much_slower(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The gradient of a turn to 1e-12 of its largest entry, in at most three times the time."""
    monkeypatch.delenv("CC", raising=False)
    usual = CycleObjective(Device(load("wang2017")))
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", str(tmp_path))
    assert toolchain.find_compiler().bundled
    turns = CycleObjective(Device(load("wang2017")))
    assert turns.way == usual.way == backends.BACKENDS[0]
    (value, gradient), (other, slopes) = (t.gradient(t.device.design) for t in (usual, turns))
    assert other == pytest.approx(value, rel=1e-12)
    assert abs(slopes - gradient).max() <= 1e-12 * abs(gradient).max()
    assert quickest(turns) <= 3 * quickest(usual)
