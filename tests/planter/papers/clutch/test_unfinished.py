"""Motions and searches of a clutch that are stopped: what was computed is on disk and in the
JSON.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from planter.errors import ComputationError, Interrupted
from planter.papers.clutch import contact, sizing
from tests.support.cli import run


def stop_in(monkeypatch: pytest.MonkeyPatch, after: int, error: BaseException) -> None:
    """Let all motions but the first be quick, and stop after some of them."""
    calls: list[Any] = []

    def quick(*_: Any) -> tuple[float, float, str, float, str]:
        calls.append(None)
        if len(calls) > after:
            raise error
        return 2.0, 4.0 * len(calls), "impact", 2.0 * len(calls), "impact"

    class Run:
        def to_result(self) -> Any:
            return type("Loads", (), {"table": lambda _: {"N_max_N": 1.0}})()

    monkeypatch.setattr(contact, "_loads", quick)
    monkeypatch.setattr(contact, "simulate_switching", lambda *_: Run())


@pytest.mark.parametrize(
    ("error", "code"),
    [(KeyboardInterrupt(), 130), (ComputationError("surfaces go too deep into each other"), 1)],
)
def test_finished_motions_stay(
    error: BaseException, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop_in(monkeypatch, 7, error)
    result = run(
        "clutch", "engage", "shi2021", "--mode", "contact", "--out", str(tmp_path), "--json"
    )
    assert result[0] == code
    summary, partial = (
        json.loads((tmp_path / "summary.json").read_text()),
        json.loads(result[1])["partial"],
    )
    assert summary["finished"] is False
    for table in (summary, partial):
        assert table["motions"] == 9
        assert len(table["sensitivity"]) == 7
        assert table["reuleaux"] == {"N_max_N": 1.0}


def test_stopped_search_hands_over_its_best(monkeypatch: pytest.MonkeyPatch) -> None:
    from planter.papers.clutch.file import load_clutch

    search = sizing.search_from_points

    def stop(problem: Any, starts: Any, iterations: Any) -> Any:
        search(problem, starts[:1], iterations)
        raise KeyboardInterrupt

    monkeypatch.setattr(sizing, "search_from_points", stop)
    with pytest.raises(Interrupted) as caught:
        sizing.optimise_clutch(load_clutch("shi2021"), starts=2)
    assert caught.value.partial is not None
    assert caught.value.partial["design"].keys() == sizing.VARIABLES.keys()
    lower, upper = load_clutch("shi2021").table()["search"]["crank_bounds_mm"]
    assert lower <= caught.value.partial["design"]["crank_mm"] <= upper


def test_infeasible_search_hands_over_the_closest() -> None:
    from planter.papers.clutch.file import load_clutch

    with pytest.raises(ComputationError, match="from 2 starts") as caught:
        sizing.optimise_clutch(load_clutch("shi2021", {"teeth_least": 40}), starts=2)
    assert caught.value.partial is not None
    assert not caught.value.partial["met"]
