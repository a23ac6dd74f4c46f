"""Contact of the real profiles: laws of mechanics first, then closed forms, another integrator,
limits, numbers.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import jsonschema
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from planter.errors import ComputationError
from planter.kernels import Kernel
from planter.papers.clutch import contact, file, modal_engagement
from planter.papers.clutch.contact import (
    ANGLE,
    FREE,
    OUTPUT,
    SIZE,
    TRAVEL,
    WORKS,
    ClutchDynamics,
    Inputs,
    SwitchingRun,
    build_contact_inputs,
)
from tests.support import cli
from tests.support.cli import answer
from tests.support.schemas import load_schema

FILE = file.load_clutch("shi2021")
GIVEN = build_contact_inputs(FILE)
JAWS = 5
CLUTCHES: dict[str, ClutchDynamics] = {
    "reuleaux": contact.build_reuleaux(),
    "dog": contact.build_dog(JAWS),
}
RNG = np.random.default_rng(17)
HELD, OPEN = 1e12, 1.0
"""A force that nothing reaches [N], a distance that nothing bridges [m]."""


@pytest.fixture(scope="module")
def runs() -> dict[str, SwitchingRun]:
    return {
        name: contact.simulate_switching(clutch, GIVEN, 0.0) for name, clutch in CLUTCHES.items()
    }


def random_states(name: str, count: int) -> np.ndarray:
    """States near contact: bodies within their room, moving at the speeds of a planter."""
    states = np.zeros((SIZE, count))
    room = 4e-4 if name == "reuleaux" else 0.9 * GIVEN["fit"]
    states[:2] = RNG.uniform(-room, room, (2, count)) / math.sqrt(2)
    states[TRAVEL] = RNG.uniform(1e-4, GIVEN["travel"], count)
    states[OUTPUT] = RNG.uniform(-4, 4, count)
    states[4:6] = RNG.uniform(-1e-6, 1e-6, (2, count))
    states[FREE : 2 * FREE] = RNG.uniform(-0.05, 0.05, (FREE, count))
    states[FREE + OUTPUT] = RNG.uniform(-8, 8, count)
    states[ANGLE] = RNG.uniform(-4, 4, count)
    return states


def test_contacts_repeat_per_tooth_and_side() -> None:
    """A fifth of a turn of the input passes the teeth on; a sixth of a turn of the shaft turns
    nothing but sides.
    """
    clutch, states = CLUTCHES["reuleaux"], random_states("reuleaux", 500)
    base = clutch.columns(states, GIVEN)
    fifth, sixth = states.copy(), states.copy()
    fifth[ANGLE] += 2 * math.pi / 5
    sixth[OUTPUT] += math.pi / 3
    np.testing.assert_allclose(
        clutch.columns(fifth, GIVEN)["gaps"][:5],
        np.roll(base["gaps"][:5], -1, axis=0),
        atol=1e-15,
    )
    np.testing.assert_allclose(
        clutch.columns(sixth, GIVEN)["load"], base["load"], rtol=1e-6, atol=1e-6
    )


def lossless(inputs: Inputs) -> Inputs:
    still = inputs | {
        "friction": 0.0,
        "dissipation": 0.0,
        "shaft_damping": 0.0,
        "load": 0.0,
        "slide": HELD,
    }
    return still | {"link_start": 0.0, "link_end": -1e-9}


@pytest.mark.parametrize("name", CLUTCHES)
def test_without_losses_time_runs_backwards(name: str) -> None:
    inputs, clutch = lossless(GIVEN), CLUTCHES[name]
    begin = contact.find_clear_state(clutch, inputs | {"travel": GIVEN["travel"]}, 0.02, 0.0)
    begin[TRAVEL] = 2e-4
    begin[FREE + OUTPUT] = -3.0
    begin[OUTPUT] = (
        0.0
        if name == "reuleaux"
        else 0.02 + 0.5 * (2 * math.pi / JAWS - GIVEN["backlash"] / GIVEN["radius"])
    )
    end = contact.integrate_motion(clutch, inputs, begin, 4e-3, tolerance=1e-11)
    assert end.load.max() > 50
    assert end.energy().lost_J == pytest.approx(0, abs=1e-12)
    turned = contact.restart_state(end.states[:, -1])
    turned[FREE : 2 * FREE] *= -1
    back = contact.integrate_motion(
        clutch, inputs | {"input_speed": -inputs["input_speed"]}, turned, 4e-3, tolerance=1e-11
    )
    np.testing.assert_allclose(back.states[:FREE, -1], begin[:FREE], atol=2e-8)
    np.testing.assert_allclose(-back.states[FREE : 2 * FREE, -1], begin[FREE : 2 * FREE], atol=2e-4)


@pytest.mark.parametrize("name", CLUTCHES)
def test_energy_is_balanced(name: str, runs: dict[str, SwitchingRun]) -> None:
    for run in (runs[name].engagement, runs[name].cut_off):
        energy = run.energy()
        assert energy.input_J > 0.5
        assert abs(energy.imbalance_J) < 1e-6 * energy.input_J
        works = run.states[WORKS:, -1]
        assert (works[2:] >= 0).all()  # what is lost does not come back
    first = runs[name].engagement
    tampered = replace(
        first,
        seen=CLUTCHES[name].columns(first.states, contact.scale_inputs(GIVEN, 1.2, "preload")),
    )
    assert abs(tampered.energy().imbalance_J) > 1e-3 * tampered.energy().input_J


def test_halved_tolerance_keeps_the_peak(runs: dict[str, SwitchingRun]) -> None:
    name = "reuleaux"
    finer = contact.simulate_engagement(CLUTCHES[name], GIVEN, 0.0, contact.TOLERANCE / 2)
    assert finer.peak() == pytest.approx(runs[name].engagement.peak(), rel=1e-5)


@pytest.mark.parametrize("name", CLUTCHES)
def test_engaged_contact_transmits_speed_and_load(name: str, runs: dict[str, SwitchingRun]) -> None:
    run = runs[name].engagement
    creep = GIVEN["slip_speed"] / 2e-3  # of friction, on the shortest lever that a tooth has
    assert run.speed[-1] == pytest.approx(GIVEN["input_speed"], abs=creep)
    spun = 1 / math.hypot(1, GIVEN["load_speed"] / GIVEN["input_speed"])
    assert run.seen["generalised"][OUTPUT, -1] == pytest.approx(GIVEN["load"] * spun, rel=1e-3)
    if name == "dog":
        assert run.load[-1] == pytest.approx(GIVEN["load"] * spun / GIVEN["radius"], rel=1e-3)


def test_cut_off_stops_the_output_only(runs: dict[str, SwitchingRun]) -> None:
    for run in runs.values():
        assert run.cut_off.states[ANGLE, -1] - run.cut_off.states[ANGLE, 0] > 1
        assert abs(run.cut_off.speed[-1]) < 1e-2
        assert run.cut_off.states[TRAVEL, -1] == pytest.approx(GIVEN["travel"], abs=1e-5)


def test_jaw_impact_agrees_with_hertz() -> None:
    """All five jaws meet at once: N = (5K)^(2/5) (5/4 m v^2)^(3/5) with the output's inertia seen
    at the jaws.
    """
    inputs = lossless(GIVEN) | {"spring_rate": 0.0}
    state = np.zeros(SIZE)
    state[OUTPUT] = 0.5 * (2 * math.pi / JAWS - GIVEN["backlash"] / GIVEN["radius"]) + 1e-4
    run = contact.integrate_motion(CLUTCHES["dog"], inputs, state, 2e-3, tolerance=1e-11)
    speed, mass = (
        inputs["input_speed"] * inputs["radius"],
        inputs["inertia"] / inputs["radius"] ** 2,
    )
    hertz = (JAWS * inputs["stiffness"]) ** 0.4 * (1.25 * mass * speed**2) ** 0.6
    assert run.peak() == pytest.approx(hertz, rel=1e-4)
    assert run.speed[-1] == pytest.approx(
        2 * inputs["input_speed"], rel=1e-6
    )  # thrown off elastically


def test_another_integrator_finds_the_same_impact(runs: dict[str, SwitchingRun]) -> None:
    run = runs["dog"].engagement
    first = int(np.argmax(run.load)) - 20
    span = run.time[first + 30] - run.time[first]
    dae = run.clutch.dae
    rates = Kernel(ca.Function("rates", [dae["x"], dae["p"]], [dae["ode"]], ["x", "p"], ["rates"]))
    vector = contact.pack(GIVEN)
    solution = solve_ivp(
        lambda t, x: rates(x=x, p=vector)["rates"][:, 0],
        (0, span),
        run.states[:, first],
        method="DOP853",
        rtol=1e-8,
        atol=1e-12,
        max_step=1e-5,
    )
    loads = run.clutch.columns(solution.y, GIVEN)["load"][0]
    assert loads.max() == pytest.approx(run.peak(), rel=1e-4)
    np.testing.assert_allclose(solution.y[:, -1], run.states[:, first + 30], rtol=1e-6, atol=1e-8)


def limit(stiffness: float) -> tuple[contact.ContactRun, modal_engagement.Engagement]:
    """One tooth pressed on a flat of a shaft that cannot turn: no clearance, no slip, start as the
    paper does.

    A contact that gives must start with the depth and its rate that carry the load at the start.
    """
    engagement = modal_engagement.build_engagement(FILE.si)
    inputs = lossless(GIVEN) | {
        "stiffness": stiffness,
        "input_speed": 0.0,
        "inertia": 1e6,
        "preload": 0.0,
        "spring_rate": 0.0,
        "hole": OPEN,
        "lock_stiffness": 1e-9,
        "push_y": -engagement["F_M"],
    }
    extremes = modal_engagement.find_extremes(engagement)
    body, mass = engagement["m1"], engagement["M_1"]
    start = engagement["Delta_omega"] * engagement["r1"]
    approach = (extremes["N_0"] / stiffness) ** (2 / 3)
    rising = body * start * extremes["B1"] ** 2
    closing = rising / (1.5 * stiffness * math.sqrt(approach))
    share = mass / (mass + body)
    state = np.zeros(SIZE)
    state[ANGLE], state[TRAVEL] = math.pi / 2, 1e-3
    state[1] = GIVEN["apothem"] - GIVEN["tip"] - approach
    state[FREE + 1] = -start - share * closing
    state[FREE + 5] = -start + (1 - share) * closing
    end = 0.95 * extremes["t_loss"]
    return contact.integrate_motion(
        CLUTCHES["reuleaux"], inputs, state, end, end / 400, 1e-10
    ), engagement


def test_contact_without_clearance_tends_to_modal_solution() -> None:
    misses = []
    for factor in (1e2, 1e4, 1e6):
        run, engagement = limit(factor * GIVEN["stiffness"])
        exact = np.array(
            [modal_engagement.evaluate_motion(engagement, t)["N"] for t in run.time - run.time[0]]
        )
        misses.append(float(np.abs(run.load - exact).max() / exact.max()))
        assert run.peak() == pytest.approx(
            modal_engagement.find_extremes(engagement)["N_max"], rel=2 * misses[-1]
        )
    assert misses[0] > 3 * misses[1] > 9 * misses[2]
    assert misses[2] < 1e-3
    far, engagement = limit(GIVEN["stiffness"])
    exact = np.array(
        [modal_engagement.evaluate_motion(engagement, t)["N"] for t in far.time - far.time[0]]
    )
    assert np.abs(far.load - exact).max() > 0.05 * exact.max()  # a soft contact is another motion


def test_teeth_slip_off_where_the_coupling_does_not_hold(runs: dict[str, SwitchingRun]) -> None:
    """A lock of a twentieth: teeth pass a corner with every 12 deg of the input, and the output
    never follows.
    """
    run = contact.simulate_engagement(
        CLUTCHES["reuleaux"], contact.scale_inputs(GIVEN, 0.05, "lock"), 0.0, 1e-7
    )
    times = contact.find_slips(run)
    assert len(times) >= 3
    np.testing.assert_allclose(np.diff(times), math.radians(12) / GIVEN["input_speed"], rtol=0.02)
    assert contact.engagement_time(run) is None
    assert contact.classify_engagement(run) == "no engagement"
    assert contact.compare_loads(80.0, 600.0, ("no engagement", "no engagement")) is None
    assert run.load.max() < 0.5 * runs["reuleaux"].engagement.load.max()


def test_printed_teeth_need_a_sleeve_gap() -> None:
    tight = GIVEN | {"hole": GIVEN["width"] / 2}
    for phase in np.radians([0, 3, 6]):
        with pytest.raises(
            ComputationError, match=r"cannot be cut off at an input angle of .* overlap by 0\.1"
        ):
            contact.find_clear_state(CLUTCHES["reuleaux"], tight, phase, 0.0)
        contact.find_clear_state(CLUTCHES["reuleaux"], GIVEN, phase, 0.0)


def test_printed_teeth_do_not_fit_the_shaft() -> None:
    """At best two tips stand 6 deg from corners, still inside the fillets; a root must clear what a
    tip lifts off.
    """
    to_fillet = (10 - 4.8) / math.cos(math.pi / 6)
    reach = math.sqrt(10.5**2 + to_fillet**2 - 2 * 10.5 * to_fillet * math.cos(math.radians(6)))
    overlap = contact.coaxial_overlap(CLUTCHES["reuleaux"], GIVEN)
    assert overlap == pytest.approx((4.8 - reach) * 1e-3, abs=1e-9)
    assert overlap > 2e-4
    assert contact.coaxial_overlap(CLUTCHES["reuleaux"], GIVEN | {"tip": 0.0108}) == 0
    assert contact.min_root_radius(GIVEN) == pytest.approx((2 * (to_fillet + 4.8) - 10.5) * 1e-3)
    assert contact.min_root_radius(GIVEN) > GIVEN["root"]


def test_overlapping_surfaces_are_refused() -> None:
    with pytest.raises(ComputationError, match="is too small"):
        contact.simulate_engagement(
            CLUTCHES["dog"], contact.scale_inputs(GIVEN, 1e-5, "stiffness"), 0.0, 1e-6
        )


def test_load_that_stays_is_no_impact(runs: dict[str, SwitchingRun]) -> None:
    jammed, struck = runs["reuleaux"].to_result(), runs["dog"].to_result()
    assert jammed.outcome == "jam"
    assert jammed.N_end_N > 0.95 * jammed.N_max_N
    assert struck.outcome == "impact"
    assert struck.N_end_N == pytest.approx(GIVEN["load"] / GIVEN["radius"], rel=1e-3)
    assert (
        contact.compare_loads(jammed.N_max_N, struck.N_max_N, (jammed.outcome, struck.outcome))
        is None
    )
    assert contact.compare_loads(300.0, 600.0, ("impact", "impact")) == 0.5
    fits = GIVEN | {"tip": 0.0108, "root": 0.0114}
    settled = contact.simulate_engagement(CLUTCHES["reuleaux"], fits, 0.0, 1e-6)
    assert contact.classify_engagement(settled) == "held load"


@pytest.mark.usefixtures("blank_figures")
def test_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, runs: dict[str, SwitchingRun]
) -> None:
    """Beside the motions that the other tests look at."""
    motions = iter(runs.values())

    def switched(_: ClutchDynamics, inputs: Inputs, phase: float) -> SwitchingRun:
        assert (inputs, phase) == (GIVEN, 0.0)
        return next(motions)

    monkeypatch.setattr(contact, "simulate_switching", switched)
    monkeypatch.setattr(contact, "VARIED", {"speed": contact.VARIED["speed"]})
    monkeypatch.setattr(contact, "FACTORS", (10**0.5,))
    monkeypatch.setattr(contact, "PHASES_DEG", ())
    result = answer("clutch", "engage", "shi2021", "--mode", "contact", "--out", str(tmp_path))
    jsonschema.validate(result, load_schema("clutch engage"))
    energy = result["energy"]
    assert energy["input_J"] - energy["stored_J"] - energy["lost_J"] == pytest.approx(
        energy["imbalance_J"], abs=1e-14
    )
    assert abs(energy["imbalance_J"]) < 1e-6 * energy["input_J"]
    row = result["sensitivity"][0]
    assert row["dog_N_max_N"] > result["dog"]["N_max_N"]  # faster: the dog clutch is struck harder
    assert result["N_max_ratio"] is None
    assert row["N_max_ratio"] is None
    assert (result["reuleaux"]["outcome"], result["dog"]["outcome"]) == ("jam", "impact")
    assert result["reuleaux"]["cut_off_s"] < result["dog"]["cut_off_s"]
    text = (tmp_path / "dog_engagement.csv").read_text()
    rows = [line for line in text.splitlines() if not line.startswith("#")]
    assert rows[0] == "time_s,link_deg,sleeve_mm,load_N,output_rpm"
    assert len(rows) > 1000


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
    result = cli.run(
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
