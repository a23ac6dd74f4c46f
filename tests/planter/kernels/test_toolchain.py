"""Compiler and cache: what is kept is what was asked for, and everything works without them."""

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from planter.kernels import compiler, toolchain
from planter.kernels.compiler import CompilerError
from tests.support.cli import run
from tests.support.lanes import needs_compiler, path_of

ROOT = Path(__file__).parents[3]
SOURCE = "double twice(double x) { return 2.0 * x; }\n"
as_a_user = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="for root no folder is closed"
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def library(source: str = SOURCE, *flags: str) -> Path:
    return toolchain.build_library("twice", source, flags or toolchain.OPTIMISED)


def twice(path: Path) -> float:
    """The library's answer for 4, in a process of its own: a library that was loaded once stays."""
    program = (
        "import ctypes, sys; f = ctypes.CDLL(sys.argv[1]).twice; f.restype = ctypes.c_double;"
        "print(f(ctypes.c_double(4)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=True
    )
    return float(done.stdout)


@needs_compiler
class TestCache:
    @pytest.fixture(autouse=True)
    def _own_folder(self, folder: Path) -> None:
        self.folder = folder

    def test_the_same_is_compiled_once(self) -> None:
        first = library()
        written = first.stat().st_mtime_ns
        assert library() == first
        assert first.stat().st_mtime_ns == written
        assert twice(first) == 8

    def test_library_path_depends_on_all_inputs(self, monkeypatch: pytest.MonkeyPatch) -> None:
        path = toolchain.library_path("twice", SOURCE, ("-O3",))
        other_paths = [
            toolchain.library_path("twice", SOURCE.replace("2.0", "3.0"), ("-O3",)),
            toolchain.library_path("twice", SOURCE, ("-O1",)),
            toolchain.library_path("twice", SOURCE, ("-O3", "-ffast-math")),
            toolchain.library_path("thrice", SOURCE, ("-O3",)),
        ]
        monkeypatch.setattr(toolchain, "_describe_processor", lambda: "another processor")
        other_paths.append(toolchain.library_path("twice", SOURCE, ("-O3",)))
        assert len({path, *other_paths}) == 6

    def test_another_version_of_the_compiler_is_another_library(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        path, older = toolchain.library_path("twice", SOURCE, ()), toolchain.find_compiler()
        newer = compiler.Compiler(older.path, "cc 99.1", older.flags)
        monkeypatch.setattr(toolchain, "find_compiler", lambda: newer)
        assert toolchain.library_path("twice", SOURCE, ()) != path

    def test_linked_library_belongs_to_user(self, tmp_path: Path) -> None:
        inner = library()
        outer = toolchain.build_library(
            "outer",
            "double twice(double); double outer(double x) { return twice(x); }",
            (),
            (inner,),
        )
        moved = tmp_path / "twice.so"
        shutil.copy(inner, moved)
        assert (
            toolchain.build_library(
                "outer",
                "double twice(double); double outer(double x) { return twice(x); }",
                (),
                (moved,),
            )
            != outer
        )

    @pytest.mark.parametrize(
        "damage",
        [
            lambda b: b[:1000] + b"\x00" + b[1001:],
            lambda b: b[: len(b) // 2],
            lambda b: b[:-1],
            lambda b: b"",
            lambda b: b + b"\x00",
            lambda b: b"\x00" * len(b),
        ],
        ids=["one byte", "half", "last byte", "empty", "one more", "zeros"],
    )
    def test_a_damaged_file_is_seen_and_built_again(self, damage) -> None:  # type: ignore[no-untyped-def]
        path = library()
        good = path.read_bytes()
        spoilt = damage(good if damage(good) != good else good.replace(good[1000:1001], b"\x01"))
        path.write_bytes(spoilt)
        assert not toolchain.is_intact(path)
        assert library() == path
        assert toolchain.is_intact(path)
        assert twice(path) == 8

    def test_a_source_with_an_error_says_so(self) -> None:
        with pytest.raises(CompilerError, match=r"did not compile twice: .*error"):
            library("double twice(double x) { return y; }\n")
        assert list(self.folder.iterdir()) == []

    def test_concurrent_processes_build_once(self) -> None:
        program = (
            "from pathlib import Path; import sys, time; from planter.kernels import toolchain\n"
            "source = Path(sys.argv[1]).read_text()\n"
            "print(toolchain.build_library('twice', source, ('-O3',)))"
        )
        source = self.folder.parent / "twice.c"
        source.write_text(SOURCE)
        command = [sys.executable, "-c", program, str(source)]
        started = [
            subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) for _ in range(4)
        ]
        outputs = {process.communicate(timeout=60)[0].strip() for process in started}
        assert [process.returncode for process in started] == [0] * 4
        assert len(outputs) == 1
        (path,) = map(Path, outputs)
        assert toolchain.is_intact(path)
        assert [p.name for p in self.folder.iterdir()] == [path.name]
        assert twice(path) == 8

    @as_a_user
    def test_unwritable_folder_is_reported(self) -> None:
        self.folder.mkdir(mode=0o500)
        with pytest.raises(CompilerError, match="cannot be written"):
            library()

    def test_uncreatable_folder_is_reported(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("PLANTER_CACHE", "/dev/null/cache")
        with pytest.raises(CompilerError, match="no folder for compiled functions"):
            library()

    def test_disk_without_execution_is_reported(self) -> None:
        path = self.folder.parent / "no.so"
        path.write_text("this is no library")
        with pytest.raises(CompilerError, match="cannot be loaded"):
            toolchain.load_library(path)


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({"PLANTER_CACHE": "/a/b", "XDG_CACHE_HOME": "/c"}, "/a/b"),
        ({"XDG_CACHE_HOME": "/c", "HOME": "/d"}, "/c/planter"),
        ({"XDG_CACHE_HOME": "", "HOME": "/d"}, "/d/.cache/planter"),
        ({"XDG_CACHE_HOME": "relative", "HOME": "/d"}, "/d/.cache/planter"),
        ({"XDG_CACHE_HOME": "./here", "HOME": "/d"}, "/d/.cache/planter"),
        ({"PLANTER_CACHE": "", "HOME": "/d"}, "/d/.cache/planter"),
    ],
)
def test_where_the_folder_is(
    variables: dict[str, str], expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("PLANTER_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert toolchain.cache_path() == Path(expected)


def test_a_user_without_a_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("could not determine home directory")

    for name in ("PLANTER_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    with pytest.raises(CompilerError, match="no folder for compiled functions"):
        toolchain.cache_folder()


@pytest.mark.parametrize("name", ["", "no-such-compiler", "false", __file__])
def test_invalid_compiler_is_ignored(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", name)
    with pytest.raises(CompilerError, match=r"compiler|CC is empty"):
        toolchain.find_compiler()


@needs_compiler
def test_the_variable_cc_names_the_compiler(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setenv("CC", path_of("clang"))
    assert "clang" in toolchain.find_compiler().version
    assert twice(library()) == 8


SUBNORMALS = """
import ctypes, sys, numpy as np
from planter.kernels import toolchain
ctypes.CDLL(sys.argv[1])
tiny, small = np.array([5e-324]), np.array([2.2250738585072014e-308])
print((tiny * 1.0).tobytes() == tiny.tobytes(), (small / 2).tobytes() == bytes([0] * 6 + [8, 0]))
"""


def subnormals_after_loading(path: Path) -> list[str]:
    command = [sys.executable, "-c", SUBNORMALS, str(path)]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()


@needs_compiler
class TestSubnormals:
    """Numbers below 2.2e-308 stay what they are in a process that loads a kernel."""

    def test_they_survive(self, folder: Path) -> None:
        path = library(SOURCE, *toolchain.OPTIMISED, *toolchain.FAST_MATH)
        assert subnormals_after_loading(path) == ["True", "True"]

    @pytest.mark.skipif(platform.machine() != "x86_64", reason="start files of x86-64")
    def test_linking_with_fast_math_loses_them(self, tmp_path: Path) -> None:
        """What the compiler did up to version 12; from 13 on it leaves shared libraries alone."""
        gcc = path_of("gcc")
        version = subprocess.run(
            [gcc, "-dumpversion"], capture_output=True, text=True, check=True
        ).stdout
        if int(version.partition(".")[0]) > 12:
            pytest.skip(f"gcc {version.strip()} does not set the processor")
        (tmp_path / "twice.c").write_text(SOURCE)
        path = tmp_path / "twice.so"
        command = [
            gcc,
            "-shared",
            "-fPIC",
            "-ffast-math",
            str(tmp_path / "twice.c"),
            "-o",
            str(path),
        ]
        subprocess.run(command, check=True)
        assert subnormals_after_loading(path) == ["False", "False"]


SEARCH = (
    "optimise",
    "wang2017",
    "--samples",
    "36",
    "--method",
    "ga",
    "--model",
    "printed",
    "--json",
)


@needs_compiler
def test_search_without_compiler_warns_once() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANTER_KERNELS", "casadi-vm")  # whoever asks for it is not warned
        code, out, err = run(*SEARCH)
    assert (code, "slower" in err) == (0, False), err
    command = [sys.executable, "-m", "planter", *SEARCH]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"CC": ""}, capture_output=True, text=True, check=True
    )
    (message,) = [line for line in done.stderr.splitlines() if "slower" in line]
    assert message.startswith("planter: slower without compiled functions: ")
    objective = json.loads(out)["objective"]
    assert json.loads(done.stdout)["objective"] == pytest.approx(objective, rel=1e-9)
