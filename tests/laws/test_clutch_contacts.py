"""Laws of the clutches' contacts, on the generated array code alone: virtual work, power,
conservation, the linkage.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.support import xp_complex
from tests.support.structure import ROOT

Values = dict[str, Any]
MODELS = ("clutch_motion", "clutch_contact_reuleaux", "clutch_contact_dog")
CONTACTS = {
    "tooth": (MODELS[1], 5),
    "side": (MODELS[1], 6),
    "jaw": (MODELS[2], 4),
    "fit": (MODELS[2], 1),
    "bearing": (MODELS[0], 1),
    "linkage": (MODELS[0], 1),
}
PLACES = ("x", "y", "way", "output", "shaft_x", "shaft_y", "angle", "pushed")
SIZES: Values = {
    "stiffness": 2e9,
    "dissipation": 9.0,
    "friction": 0.2,
    "slip_speed": 1e-4,
    "least_depth": 1e-30,
    "core": 1e-9,
    "tip": 0.0096,
    "root": 0.0104,
    "apothem": 0.0093,
    "fillet": 0.0031,
    "width": 0.027,
    "hole": 0.01365,
    "travel": 0.004,
    "taper": 0.3,
    "jaws": 4,
    "radius": 0.012,
    "backlash": 0.0011,
    "edge": 6e-4,
    "depth": 3e-3,
    "fit": 3e-5,
}
"""A clutch that is not the built-in one."""


@cache
def sidecar(model: str) -> Values:
    content: Values = json.loads((ROOT / "generated" / f"{model}.json").read_text(encoding="utf-8"))
    return content


def module(model: str) -> ModuleType:
    return import_module(f"generated.array.{model}")


def call(model: str, function: str, values: Values) -> Values:
    """A function of a model at what is known by name."""
    description = sidecar(model)
    vectors, emitted = description["vectors"], description["functions"][function]
    values = {name: np.complex128(value) for name, value in values.items()}
    arguments = [
        [values[e["name"]] for e in vectors[n]] if n in vectors else values[n]
        for n in emitted["inputs"]
    ]
    results = getattr(module(model), function)(xp_complex, *arguments)
    return dict(
        zip(
            (e["name"] for e in vectors[emitted["output"]]),
            map(np.complex128, results),
            strict=True,
        )
    )


def numbers(model: str, function: str, values: Values) -> dict[str, float]:
    """The same, real."""
    return {name: float(value.real) for name, value in call(model, function, values).items()}


def states(seed: int, count: int) -> Iterator[Values]:
    """Places and rates near contact."""
    random = np.random.default_rng(seed)
    spread = {
        "x": 5e-4,
        "y": 5e-4,
        "way": 3e-3,
        "output": 3,
        "shaft_x": 1e-5,
        "shaft_y": 1e-5,
        "angle": 3,
        "pushed": 3e-3,
    }
    for _ in range(count):
        places = {name: size * random.uniform(-1, 1) for name, size in spread.items()}
        places |= {name: abs(places[name]) for name in ("way", "pushed")}
        yield places | {
            f"{name}_dot": 20 * size * random.uniform(-1, 1) for name, size in spread.items()
        }


def differentiate(function: Callable[[Values], Any], values: Values, direction: Values) -> float:
    """Derivative of a function of places along a direction, by a complex step."""
    step = xp_complex.STEP
    moved = {name: values[name] + 1j * step * slope for name, slope in direction.items()}
    return float(np.imag(function(values | moved)) / step)


def touching(name: str, count: int = 60) -> Iterator[Values]:
    """States in which a contact bears, each with what it does."""
    model, equal = CONTACTS[name]
    touching_count = 0
    for seed in range(200):
        for state in states(seed, 40):
            values = {**SIZES, **state, "index": seed % equal}
            if name in ("bearing", "linkage"):
                values["way"] = (
                    -abs(values["way"]) if name == "bearing" else values["pushed"] - 1e-5
                )
            done = numbers(model, name, values)
            if done["normal"] > 0 and done["gap"] > -4e-4:
                yield values
                touching_count += 1
                if touching_count == count:
                    return
    pytest.fail(f"{name} never bears")


@pytest.mark.parametrize("name", CONTACTS)
def test_normal_force_acts_along_slope_of_distance(name: str) -> None:
    """Virtual work: without friction the generalised force is the normal force times the gap's
    gradient.
    """
    model, _ = CONTACTS[name]
    acted = 0
    for values in touching(name, 30):
        at = values | {"friction": 0.0}
        done = numbers(model, name, at)
        for place in PLACES:
            slope = differentiate(lambda v: call(model, name, v)["gap"], at, {place: 1.0})
            assert done[f"on_{place}"] == pytest.approx(
                slope * done["normal"], rel=1e-9, abs=1e-11 * done["normal"]
            )
            acted += slope != 0
    assert acted


@pytest.mark.parametrize("name", CONTACTS)
def test_contact_power_is_stored_plus_lost(name: str) -> None:
    """Of all its forces, friction too, on the coordinates as they move."""
    model, _ = CONTACTS[name]
    noticed = 0
    for values in touching(name):
        done = numbers(model, name, values)
        stored = differentiate(
            lambda v: call(model, name, v)["stored"],
            values,
            {p: values[f"{p}_dot"] for p in PLACES},
        )
        taken = stored + done["damped"] + done["rubbed"]
        power = sum(done[f"on_{place}"] * values[f"{place}_dot"] for place in PLACES)
        size = abs(stored) + abs(done["damped"]) + done["rubbed"]
        assert -power == pytest.approx(taken, rel=1e-9, abs=1e-9 * size)
        tampered = power + 1e-3 * (
            done["on_way"] * values["way_dot"] + done["on_x"] * values["x_dot"]
        )
        noticed += abs(tampered + taken) > 1e-6 * size
    assert noticed > 10


@pytest.mark.parametrize("name", CONTACTS)
def test_friction_only_takes(name: str) -> None:
    for values in touching(name):
        assert numbers(CONTACTS[name][0], name, values)["rubbed"] >= 0


@pytest.mark.parametrize("name", ["tooth", "side", "jaw"])
def test_body_and_shaft_do_the_opposite_to_each_other(name: str) -> None:
    """Turning the whole clutch changes no distance: forces and their moments about the axis are in
    balance.
    """
    for values in touching(name):
        done = numbers(CONTACTS[name][0], name, values)
        if (
            name != "jaw"
        ):  # whose middles are counted along the circumference, as if it were straight
            assert done["on_x"] + done["on_shaft_x"] == pytest.approx(0, abs=1e-10 * done["normal"])
            assert done["on_y"] + done["on_shaft_y"] == pytest.approx(0, abs=1e-10 * done["normal"])
        total = (
            done["on_output"]
            + done["on_angle"]
            + sum(
                values[f"{p}x"] * done[f"on_{p}y"] - values[f"{p}y"] * done[f"on_{p}x"]
                for p in ("", "shaft_")
            )
        )
        assert total == pytest.approx(0, abs=1e-12 * done["normal"])


MOTION: Values = {
    "body": 0.31,
    "sleeve": 0.17,
    "inertia": 3e-4,
    "shaft_mass": 0.05,
    "shaft_stiffness": 2e6,
    "shaft_damping": 11.0,
    "preload": 30.0,
    "spring_rate": 5e3,
    "load": 0.8,
    "load_speed": 0.02,
    "push_x": 1.5,
    "push_y": -0.7,
    "slide": 6.0,
    "lock": 900.0,
    "lock_travel": 9e-4,
    "lock_stiffness": 4e7,
    "creep": 1e-5,
}
BENT = ("bent_x", "bent_y")
GIVEN, LOST = ("input", "linkage"), ("load", "damping", "friction", "slides", "shaft")


def moving(seed: int) -> Values:
    """A state of the whole, with whatever the contacts do."""
    random = np.random.default_rng(seed)
    values = {**MOTION, **next(states(seed, 1)), **{b: 1e-7 * random.uniform(-1, 1) for b in BENT}}
    values["way"] *= 0.2
    forces = {f"on_{place}": 40 * random.uniform(-1, 1) for place in PLACES}
    return (
        values
        | forces
        | {"stored": 0.0, "damped": random.uniform(0, 2), "rubbed": random.uniform(0, 2)}
    )


def imbalance(values: Values, dropped: str = "") -> float:
    """What is given less what is kept and lost, as a share of the largest; a power may be left
    out.
    """
    results = numbers("clutch_motion", "motion", values)
    rates = {p: values[f"{p}_dot"] for p in PLACES[:6]} | {
        f"{p}_dot": results[f"{p}_ddot"] for p in PLACES[:6]
    }
    rates |= {b: results[f"{b}_dot"] for b in BENT} | {"angle": values["angle_dot"]}
    change = differentiate(lambda v: call("clutch_motion", "motion", v)["energy"], values, rates)
    by_contacts = sum(values[f"on_{place}"] * values[f"{place}_dot"] for place in PLACES)
    powers = {name: results[f"power_{name}"] for name in (*GIVEN, *LOST) if name != dropped}
    supplied, lost = (sum(powers.get(name, 0.0) for name in names) for names in (GIVEN, LOST))
    in_contacts = -by_contacts - values["damped"] - values["rubbed"]
    return abs(supplied - lost - change - in_contacts) / max(map(abs, (*powers.values(), change)))


@pytest.mark.parametrize("seed", range(40))
def test_energy_grows_by_supplied_less_lost(seed: int) -> None:
    """What contacts take of the coordinates and do not lose, they store."""
    assert imbalance(moving(seed)) < 1e-12


@pytest.mark.parametrize("dropped", [*GIVEN, *LOST])
def test_missing_power_is_detected(dropped: str) -> None:
    assert max(imbalance(moving(seed), dropped) for seed in range(5)) > 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_bristles_hold_against_sliding_and_lose(seed: int) -> None:
    values = moving(seed)
    results = numbers("clutch_motion", "motion", values)
    assert results["power_slides"] >= 0
    free = values | {"slide": 1e12}
    forces = numbers("clutch_motion", "motion", free)
    c, s = np.cos(values["angle"]), np.sin(values["angle"])
    over = (
        values["x_dot"] + values["angle_dot"] * values["y"],
        values["y_dot"] - values["angle_dot"] * values["x"],
    )
    assert forces["bent_x_dot"] == pytest.approx(c * over[0] + s * over[1], rel=1e-6)
    assert forces["bent_y_dot"] == pytest.approx(-s * over[0] + c * over[1], rel=1e-6)


LINK: Values = {
    "l_AB": 0.013,
    "l_BC": 0.05,
    "l_AC": 0.043,
    "k": 0.4,
    "gamma": 1.45,
    "link_start": 0.2,
    "link_end": 0.03,
    "link_speed": 1.3,
}


def test_linkage_closes_and_rate_is_slope_of_path() -> None:
    moved = 0
    for t in np.linspace(-0.02, 0.2, 45):
        values = LINK | {"t": t}
        results = numbers("clutch_motion", "course", values)
        slope = differentiate(
            lambda v: call("clutch_motion", "course", v)["pushed"], values, {"t": 1.0}
        )
        assert results["pushed_dot"] == pytest.approx(slope, rel=1e-12, abs=1e-15)
        moved += slope != 0
        inclined = np.clip(0.2 - 1.3 * t, 0.03, 0.2)
        assert results["link_angle"] == pytest.approx(inclined)
        pin = LINK["l_AC"] + results["pushed"]
        start = np.arccos((0.043**2 + 0.013**2 - 0.05**2) / (2 * 0.043 * 0.013))
        crank = start - max(inclined - (np.pi / 2 - 1.45), 0) / 0.4
        rod = np.hypot(pin - 0.013 * np.cos(crank), 0.013 * np.sin(crank))
        assert rod == pytest.approx(0.05, rel=1e-13)
    assert moved > 10


def test_damping_is_critical_where_the_swing_ends() -> None:
    at = {"shaft_mass": 0.05, "shaft_stiffness": 2e6}
    critical = numbers("clutch_motion", "damping", at | {"damping_share": 1.0})["shaft_damping"]
    assert np.roots([0.05, critical, 2e6]) == pytest.approx([-np.sqrt(2e6 / 0.05)] * 2, rel=1e-6)
    half = numbers("clutch_motion", "damping", at | {"damping_share": 0.5})["shaft_damping"]
    assert half == pytest.approx(critical / 2)
