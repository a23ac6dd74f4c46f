"""Compilers as people name them: several words, silent, talking in another tongue, warning of
everything.
"""

import os
import shlex
import sys
import tempfile
import time
from pathlib import Path

import pytest

from planter.kernels import compiler, toolchain
from planter.kernels.compiler import CompilerError
from tests.support.lanes import build_square, needs_compiler


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("PLANTER_KERNELS", raising=False)


def script(folder: Path, text: str) -> Path:
    path = folder / "some cc"
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="latin-1")
    path.chmod(0o755)
    return path


def runs(group: str) -> bool:
    """Whether something of a group of processes goes on for longer than it takes to be buried."""
    for _ in range(100):
        try:
            os.killpg(int(group), 0)
        except ProcessLookupError:
            return False
        time.sleep(0.05)
    return True


@needs_compiler
class TestSeveralWords:
    PASSED_ON = "import os, sys; os.execvp(sys.argv[1], sys.argv[1:])"

    @pytest.mark.parametrize(
        "words",
        [
            ["env", "cc"],
            [sys.executable, "-c", PASSED_ON, "cc"],
            ["env", "WORD=two words; exit 1", "cc"],
        ],
        ids=["a wrapper", "a module of Python", "words with spaces"],
    )
    def test_a_kernel_is_compiled_by_them(
        self, words: list[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("CC", shlex.join(words))
        kernel = build_square()
        kernel.compile()
        assert kernel.way == "lanes"
        assert kernel(x=[3.0])["y"][0, 0] == 9
        assert toolchain.find_compiler().words == tuple(words[1:])
        assert (
            toolchain.find_compiler().flags
            == compiler._probe_compiler("cc", os.environ["PATH"]).flags
        )  # type: ignore[union-attr]

    def test_other_words_are_another_library(self, monkeypatch: pytest.MonkeyPatch) -> None:
        places = set()
        for name in ("env cc", "env WORD=1 cc"):
            monkeypatch.setenv("CC", name)
            places.add(toolchain.library_path("f", "", ()))
        assert len(places) == 2

    def test_no_shell_reads_them(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("CC", f"cc; touch {tmp_path / 'touched'}")
        with pytest.raises(CompilerError, match="there is no C compiler 'cc;'"):
            toolchain.find_compiler()
        monkeypatch.setenv("CC", f"cc $(touch {tmp_path / 'touched'})")
        build_square().compile()
        assert not (tmp_path / "touched").exists()

    def test_path_with_space_is_a_single_word(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("CC", str(script(tmp_path, 'exec cc "$@"')))
        build_square().compile()
        assert toolchain.find_compiler().words == ()

    @pytest.mark.parametrize(
        ("name", "message"), [(" ", "CC is empty"), ("cc 'x", "cannot be read: No closing")]
    )
    def test_invalid_words_are_refused(
        self, name: str, message: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("CC", name)
        with pytest.raises(CompilerError, match=message):
            toolchain.find_compiler()


@needs_compiler
class TestFlags:
    def flags(self, text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
        monkeypatch.setenv("CC", str(script(folder, text)))
        compiler = toolchain.find_compiler()
        return (*compiler.flags, *compiler.order)

    def test_a_warning_of_something_else_takes_no_flag_away(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Which `-Werror` makes an error."""
        plain = self.flags('exec cc "$@"', tmp_path, monkeypatch)
        warned = (
            'for word; do [ "$word" = -Werror ] && { echo "-Wl,x: unused" >&2; exit 1; }; '
            'done; exec cc "$@"'
        )
        (tmp_path / "warns").mkdir()
        assert self.flags(warned, tmp_path / "warns", monkeypatch) == plain != ()

    @pytest.mark.parametrize("fails", ["exit 1", ":"])
    def test_flag_with_warning_is_not_used(
        self, fails: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        warned = 'for word; do [ "$word" = -Werror ] && { echo "unused: $2" >&2; exit 1; }; done'
        text = f'[ "$1" = --version ] && exit; {warned}; {fails}'
        assert self.flags(text, tmp_path, monkeypatch) == ()


@needs_compiler
def test_query_leaves_no_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some compilers write beside what they are told to write to, when that is no file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    compiler_script = script(
        tmp_path, 'case "$*" in *"-o /dev/null"*) touch null.s;; esac; exec cc "$@"'
    )
    monkeypatch.setenv("CC", str(compiler_script))
    assert toolchain.find_compiler().flags
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["some cc", "temporary"]


class TestNoAnswer:
    @pytest.fixture(autouse=True)
    def _soon(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(compiler, "PROBE_TIMEOUT_S", 0.5)

    @pytest.mark.parametrize("case", ["version", "flags"])
    def test_it_is_not_waited_for_and_asked_once(
        self, case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """A shell that waits for a command: both end."""
        answers = '[ "$1" = --version ] && { echo cc 1; exit; }\n' if case == "flags" else ""
        text = f"echo $$ >> '{tmp_path / 'asked'}'\n{answers}sleep 300\nexit"
        monkeypatch.setenv("CC", str(script(tmp_path, text)))
        began = time.monotonic()
        for _ in range(3):
            with pytest.raises(CompilerError, match=r"some cc does not answer within 0\.5 s"):
                toolchain.find_compiler()
        assert time.monotonic() - began < 10
        calls = (tmp_path / "asked").read_text().split()
        assert len(calls) == (1 if case == "version" else 2)
        assert not any(runs(process) for process in calls)


@needs_compiler
def test_a_version_in_another_encoding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "case $1 in --version) echo 'cc f\xfcr alle';; *) exec cc \"$@\";; esac"
    monkeypatch.setenv("CC", str(script(tmp_path, text)))
    assert toolchain.find_compiler().version == r"cc f\xfcr alle"
    kernel = build_square()
    kernel.compile()
    assert kernel.way == "lanes"
