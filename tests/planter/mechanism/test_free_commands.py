"""`simulate` and `diff` of what moves freely: limits judged, and motions side by side, against
closed forms.
"""

from pathlib import Path

import numpy as np
import pytest

from planter.mechanism import file
from planter.mechanism.dynamics import Dynamics
from planter.report.subject import open_machine
from tests.planter.mechanism.test_motion_measures import OSCILLATOR, oscillate
from tests.support import own
from tests.support.cli import answer, refusal


def write_file(folder: Path, name: str, limit: str = "", **values: str) -> str:
    source = own.generated(OSCILLATOR) / "own.toml"
    text = source.read_text("utf-8").replace("[values]", f'folder = "{source.parent}"\n[values]', 1)
    for key, (old, new) in {k: v.split("->") for k, v in values.items()}.items():
        assert f"{key} = {old}" in text
        text = text.replace(f"{key} = {old}", f"{key} = {new}")
    path = folder / name
    path.write_text(text + (f'\n[requirements]\nhold = ["{limit}"]\n' if limit else ""), "utf-8")
    return str(path)


@pytest.mark.parametrize(("bound", "met"), [(60.0, False), (80.0, True)])
def test_limits_of_a_motion_are_judged(tmp_path: Path, bound: float, met: bool) -> None:
    """The first minimum is half a damped period after the start, beyond the time that is shown."""
    omega = np.sqrt(40 / 0.5 - 0.8**2)
    lowest = 100 * np.exp(-0.8 * np.pi / omega)
    source = write_file(tmp_path, "own.toml", f"min x over 0..1 s >= {-bound:g} mm")
    result = answer("simulate", source, "--until", "0.1")
    assert result["met"] is met
    (limit,) = result["holds"]
    assert limit["value"] == pytest.approx(-lowest, rel=1e-8)
    assert limit["met"] is met


def test_without_limits_nothing_is_judged_and_with_inputs_neither(tmp_path: Path) -> None:
    result = answer("simulate", write_file(tmp_path, "own.toml"), "--until", "0.1")
    assert "holds" not in result
    (tmp_path / "u.csv").write_text("t_s,k_N_m\n0,40\n1,50\n", "utf-8")
    source = write_file(tmp_path, "limited.toml", "x at 0.5 s <= 1")
    words = ("--until", "0.1", "--input", str(tmp_path / "u.csv"))
    assert "met" not in answer("simulate", source, *words)


def test_motions_side_by_side_are_those_of_the_closed_form(tmp_path: Path) -> None:
    first = write_file(tmp_path, "a.toml", "x at 0.5 s <= 1 mm")
    second = write_file(tmp_path, "b.toml", k_N_m="40->60")
    result = answer("diff", first, second, "--until", "2")
    assert [entry["name"] for entry in result["values"][:1]] == ["values.k_N_m"]
    times = np.array(result["curves"][0]["t_s"])
    assert (times[0], times[-1]) == (0.0, 2.0)
    curve = next(curve for curve in result["curves"] if curve["name"] == "x")
    dense = np.linspace(0, 2, 100_001)
    rows = {row["name"]: row for row in result["results"]}
    for index, k in enumerate((40.0, 60.0)):
        x = 1e3 * oscillate(0.5, k, 0.8, 0.1, times)
        assert curve["values"][index] == pytest.approx(x, abs=1e-7)
        fine = 1e3 * oscillate(0.5, k, 0.8, 0.1, dense)
        at = rows["min x over 0..2 s"]["values"][index], rows["rms x over 0..2 s"]["values"][index]
        rms = np.sqrt(np.trapezoid(fine**2, dense) / 2)
        assert at == pytest.approx((fine.min(), rms), rel=1e-7)
    assert result["requirements"][0]["values"] == pytest.approx(
        [float(1e3 * oscillate(0.5, k, 0.8, 0.1, np.array([0.5]))[0]) for k in (40.0, 60.0)]
    )


def test_equal_motions_have_no_differences(tmp_path: Path) -> None:
    source = write_file(tmp_path, "a.toml")
    result = answer("diff", source, source, "--until", "0.5")
    assert result["values"] == []
    assert {row["difference"][0] for row in result["results"]} == {0.0}


def test_time_of_the_file_is_that_of_commands_without_one(tmp_path: Path) -> None:
    source = Path(write_file(tmp_path, "a.toml"))
    text = source.read_text("utf-8")
    assert "until_s = 2" in text
    source.write_text(text.replace("until_s = 2", "until_s = 0.3"), "utf-8")
    assert answer("simulate", str(source))["until_s"] == 0.3
    assert answer("simulate", str(source), "--until", "0.1")["until_s"] == 0.1
    times = answer("diff", str(source), str(source))["curves"][0]["t_s"]
    assert times[-1] == 0.3
    source.write_text(text.replace("[motion]\nuntil_s = 2", ""), "utf-8")
    for command in (["simulate", str(source)], ["diff", str(source), str(source)]):
        assert "motion" in refusal(*command)


def test_time_of_a_motion_is_refused_to_a_cycle(tmp_path: Path) -> None:
    source = write_file(tmp_path, "a.toml")
    assert "--until" in refusal("diff", "wang2017", "compact", "--until", "1")
    driven = str(own.generated("slider_crank") / "slider_crank.toml")
    assert "angle" in refusal("diff", source, driven, "--until", "1")


@pytest.mark.parametrize(("until", "integrations"), [(2.0, 1), (0.1, 2)])
def test_limits_are_judged_on_the_motion_that_is_shown(
    tmp_path: Path, until: float, integrations: int
) -> None:
    """One integration serves both, unless limits are on later times than are shown."""
    source = write_file(tmp_path, "own.toml", "min x over 0..1 s >= -80 mm")
    with pytest.MonkeyPatch.context() as patch:
        calls = count_calls(patch, Dynamics, "integrate")
        result = answer("simulate", source, "--until", str(until))
    omega = np.sqrt(40 / 0.5 - 0.8**2)
    lowest = 100 * np.exp(-0.8 * np.pi / omega)
    assert result["holds"][0]["value"] == pytest.approx(-lowest, rel=1e-8)
    assert len(calls) == integrations


def test_page_shows_the_motion_and_its_limits(tmp_path: Path) -> None:
    source = write_file(tmp_path, "own.toml", "min x over 0..1 s >= -75 mm")
    view = open_machine(source, {"motion.until_s": 1.0})
    values = {control.path: control.value for control in view.controls}
    values |= {"values.k_N_m": 50.0}
    (scene,) = view.scenes(values, "exact")
    assert (scene.seconds, scene.place, scene.again) == (1.0, "time", False)
    times = np.linspace(0, 1, len(scene.places))
    assert scene.points[-1].x == pytest.approx(1e3 * oscillate(0.5, 50, 0.8, 0.1, times), abs=1e-6)
    lowest = -100 * np.exp(-0.8 * np.pi / np.sqrt(50 / 0.5 - 0.8**2))
    (check,) = view.checks(values, "exact")
    assert check.value == pytest.approx(lowest, rel=1e-8)
    assert not check.met
    readings = {reading.name: reading.value for reading in view.readings(values, "exact")}
    assert lowest == pytest.approx(
        next(value for name, value in readings.items() if "x" in name and "least" in name), rel=1e-4
    )


@pytest.mark.parametrize("command", ["simulate", "simulate --check"])
@pytest.mark.parametrize("name", ["pendulum", "crank_rocker"])
def test_file_of_a_mechanism_is_read_once(command: str, name: str) -> None:
    path = str(own.generated(name) / f"{name}.toml")
    until = ("--until", "0.1") if (name, command) == ("pendulum", "simulate") else ()
    with pytest.MonkeyPatch.context() as patch:
        calls = count_calls(patch, file, "load")
        answer(command, path, *until)
    assert len(calls) == 1


def count_calls(patch: pytest.MonkeyPatch, owner: object, name: str) -> list[object]:
    """Return a list that grows by an entry with each call of a function."""
    calls: list[object] = []
    function = getattr(owner, name)

    def count(*arguments: object, **named: object) -> object:
        calls.append(None)
        return function(*arguments, **named)

    patch.setattr(owner, name, count)
    return calls
