"""How far long work is: what listeners hear, what of it is shown, and that the time left is that of the rest."""

from __future__ import annotations

import io
import os

import pytest

from planter import progress
from planter.progress import Phase, Progress
from planter.terminal.console import Console


class Clock:
    """Seconds that pass when they are told to."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(progress.time, "perf_counter", lambda: self.now)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


def test_the_time_left_goes_on_as_it_went(clock: Clock) -> None:
    heard: list[Progress] = []
    phase = Phase("ga", "generation", 10, heard.append)
    clock.now += 6
    phase.reached(3, best=1.5)
    clock.now += 14
    phase.reached(10, "the last")
    assert heard[0] == Progress("ga", "generation", 3, 10, best=1.5, left=14.0)
    assert heard[1].left is None
    assert str(heard[1]) == "ga: generation 10 of 10, the last"


def test_what_was_done_before_took_no_time(clock: Clock) -> None:
    """Of ten devices eight are kept: the ninth took 5 s, and so will the tenth."""
    heard: list[Progress] = []
    phase = Phase("compare", "device", 10, heard.append, done=8)
    phase.reached(8, "done before")
    clock.now += 5
    phase.next("ellipse")
    assert [(at.done, at.left) for at in heard] == [(8, None), (9, 5.0)]


def test_a_long_step_is_told_once_it_is_long(clock: Clock) -> None:
    heard: list[Progress] = []
    phase = Phase("ipopt", "start", 2, heard.append)
    phase.under_way(3.0)
    clock.now += progress.QUIET + 1
    phase.under_way(2.0)
    phase.under_way(1.0)
    assert [str(at) for at in heard] == ["ipopt: start 0 of 2, best objective 2"]


def test_work_that_ends_early_is_told_to_have_ended(clock: Clock) -> None:
    heard: list[Progress] = []
    phase = Phase("pickup", "round", 20, heard.append)
    phase.end()
    phase.next()
    phase.end()
    phase.end()
    assert [(at.done, at.total) for at in heard] == [(1, 20), (1, 1)]


def test_nobody_need_listen() -> None:
    Phase("drawing", "figure", 1, None).next("force")


def test_ten_lines_in_all_where_there_is_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    phase = Phase("drawing", "figure", 200, Console(as_json=False).progress)
    for _ in range(200):
        phase.next()
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[-1] == "drawing: figure 200 of 200"


def test_one_line_as_wide_as_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setattr("shutil.get_terminal_size", lambda: os.terminal_size((30, 24)))
    show = Console(as_json=False).progress
    show(Progress("compare", "device", 1, 2, "eccentric-circle+ellipse objective 1.9\x1b[2J"))
    show(Progress("compare", "device", 2, 2))
    first, last = terminal.getvalue().split("\r\x1b[2K")[1:]
    assert first == "compare: device 1 of 2, eccen"
    assert last == "compare: device 2 of 2\n"
