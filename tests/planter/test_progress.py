"""Progress reports: their text, number and remaining time."""

from __future__ import annotations

import io
import os
import threading

import pytest

from planter import progress
from planter.progress import Progress, ProgressPhase, describe_slow_step, name_step
from planter.report.console import Console


class Clock:
    """Clock that a test sets."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(progress.time, "perf_counter", lambda: self.now)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


def test_remaining_time_is_extrapolated(clock: Clock) -> None:
    reports: list[Progress] = []
    phase = ProgressPhase("ga", "generation", 10, reports.append)
    clock.now += 6
    phase.report(3, best=1.5)
    clock.now += 14
    phase.report(10, "the last")
    assert reports[0] == Progress("ga", "generation", 3, 10, best=1.5, remaining=14.0)
    assert reports[1].remaining is None
    assert str(reports[1]) == "ga: generation 10 of 10, the last"


def test_restored_steps_do_not_count_for_time(clock: Clock) -> None:
    """Of ten devices eight were restored: the ninth took 5 s, and so will the tenth."""
    reports: list[Progress] = []
    phase = ProgressPhase("compare", "device", 10, reports.append, done=8)
    phase.report(8, "done before")
    clock.now += 5
    phase.advance("ellipse")
    assert [(report.done, report.remaining) for report in reports] == [(8, None), (9, 5.0)]


def test_long_step_is_reported_after_interval(clock: Clock) -> None:
    reports: list[Progress] = []
    phase = ProgressPhase("ipopt", "start", 2, reports.append)
    phase.report_if_slow(3.0)
    clock.now += progress.REPORT_INTERVAL + 1
    phase.report_if_slow(2.0)
    phase.report_if_slow(1.0)
    assert [str(report) for report in reports] == ["ipopt: start 0 of 2, best objective 2"]


def test_early_end_is_reported_once(clock: Clock) -> None:
    reports: list[Progress] = []
    phase = ProgressPhase("pickup", "round", 20, reports.append)
    phase.finish()
    phase.advance()
    phase.finish()
    phase.finish()
    assert [(report.done, report.total) for report in reports] == [(1, 20), (1, 1)]


def test_phase_without_listener() -> None:
    ProgressPhase("drawing", "figure", 1, None).advance("force")


def test_console_without_terminal_prints_ten_lines(capsys: pytest.CaptureFixture[str]) -> None:
    phase = ProgressPhase("drawing", "figure", 200, Console(as_json=False).progress)
    for _ in range(200):
        phase.advance()
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[-1] == "drawing: figure 200 of 200"


def test_console_rewrites_line_of_terminal_width(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setattr(
        "shutil.get_terminal_size", lambda fallback=(80, 24): os.terminal_size((30, 24))
    )
    show = Console(as_json=False).progress
    show(Progress("compare", "device", 1, 2, "eccentric-circle+ellipse objective 1.9\x1b[2J"))
    show(Progress("compare", "device", 2, 2))
    first, last = terminal.getvalue().split("\r\x1b[2K")[1:]
    assert first == "compare: device 1 of 2, eccen"
    assert last == "compare: device 2 of 2\n"


def test_slow_step_is_described_once(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with name_step("around"), name_step("within"):
        assert describe_slow_step() is None
        now[0] = progress.SLOW_S
        assert describe_slow_step() == "within"
        now[0] += progress.REPORT_INTERVAL
        assert describe_slow_step() is None
    assert describe_slow_step() is None


def test_step_that_changes_is_described_again(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with name_step(lambda: f"{now[0]:g} s of 60 s"):
        now[0] = 3.0
        assert describe_slow_step() == "3 s of 60 s"
        now[0] = 4.0
        assert describe_slow_step() is None
        now[0] += progress.REPORT_INTERVAL
        assert describe_slow_step() == "14 s of 60 s"


def test_steps_of_other_threads_are_not_described(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "SLOW_S", -1.0)
    texts: list[str | None] = []

    def work() -> None:
        with name_step("in the background"):
            texts.append(describe_slow_step())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    with name_step("in the main thread"):
        texts.append(describe_slow_step())
    assert texts == [None, "in the main thread"]
