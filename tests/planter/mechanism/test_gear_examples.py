"""Gears of the examples, held against Willis' equation, gear statics and power: none from this
project.
"""

import numpy as np
import pytest

from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from tests.support import own

ALPHA = np.radians(20)
TURN = np.linspace(0.1, 6.2, 41)


@pytest.mark.parametrize(("sun", "planet"), [(18, 27), (12, 40)])
def test_planetary_gear_follows_willis(sun: int, planet: int) -> None:
    """G.

    Niemann, H. Winter, Maschinenelemente 2: speeds by Willis, torques 1 : z_r/z_s : -(1 + z_r/z_s).
    """
    values = Model(own.machine("planetary_gear", z_s=sun, z_p=planet))(TURN)
    ring = sun + 2 * planet
    assert values["psi"] == pytest.approx(TURN * sun / (sun + ring), rel=1e-13)
    assert values["M_in"] == pytest.approx(24 * sun / (sun + ring), rel=1e-12)
    assert values["M_ringz"] == pytest.approx(24 * ring / (sun + ring), rel=1e-12)
    share = 24 / 3 * sun / (sun + ring) / (sun / 1000)  # tangential force on a tooth, module 2 mm
    for number in range(3):
        assert values[f"F_NS{number}"] == pytest.approx(share / np.cos(ALPHA), rel=1e-12)
        assert np.hypot(values[f"F_P{number}x"], values[f"F_P{number}y"]) == pytest.approx(
            2 * share, rel=1e-12
        )
    assert np.hypot(values["F_Ox"], values["F_Oy"]) == pytest.approx(0.0, abs=1e-10), (
        "three planets centre the sun"
    )


def test_reversed_load_bears_on_other_flanks() -> None:
    forward, backward = (
        Model(own.machine("planetary_gear", M_d_Nm=load))(TURN) for load in (24.0, -24.0)
    )
    assert backward["M_in"] == pytest.approx(-forward["M_in"], rel=1e-12)
    assert backward["F_NS0"] == pytest.approx(forward["F_NS0"], rel=1e-12), (
        "a normal force always pushes"
    )
    radial = [
        np.cos(v["psi"]) * v["F_S0x"] + np.sin(v["psi"]) * v["F_S0y"] for v in (forward, backward)
    ]
    assert radial[1] == pytest.approx(radial[0], rel=1e-12)
    assert radial[0] == pytest.approx(-forward["F_NS0"] * np.sin(ALPHA), rel=1e-12), (
        "external teeth push apart"
    )


@pytest.mark.parametrize("push", [500.0, -500.0])
def test_rack_bears_weight_and_press(push: float) -> None:
    values = Model(own.machine("rack_press", F_p_N=push))(TURN)
    force = push + 4 * 9.81
    assert values["M_in"] == pytest.approx(0.03 * force, rel=1e-12)
    assert values["T_P"] == pytest.approx(-force, rel=1e-12)
    assert values["F_Px"] == pytest.approx(-abs(force) * np.tan(ALPHA), rel=1e-12), (
        "teeth push the rack away"
    )


def test_internal_gears_pass_power() -> None:
    values = Model(own.machine("internal_gears"))(TURN)
    speed, ratio = 120 * np.pi / 30, (1 + 0.15 * np.cos(TURN)) / 3
    moment = 12 - 0.02 * 0.15 / 3 * np.sin(TURN) * speed**2
    assert values["M_P"] == pytest.approx(moment, rel=1e-12)
    assert values["M_in"] == pytest.approx(ratio * moment, rel=1e-12)
    assert values["r_r"] == pytest.approx(0.06 / (1 - ratio), rel=1e-13)
    assert values["F_Px"].min() > 0, "the ring's teeth push the planet towards the ring's centre"


def test_wrong_ratio_breaks_rolling() -> None:
    text = (
        (own.EXAMPLES / "internal_gears.py")
        .read_text()
        .replace("q.a / (1 - ratio)", "q.a / (1 + ratio)")
    )
    laws = {
        law.law: law.violation
        for law in compute_cycle(Model(own.machine(text, "internal_gears")), 90).result.laws
    }
    assert laws["sliding of the pitch curves at P, y, which vanishes"] > 0.01


def test_given_force_is_no_pole() -> None:
    """A load at the planet's tip: its work is the drive's, less what the drive needs without it."""
    text = (own.EXAMPLES / "planetary_train.py").read_text()
    loaded = text.replace("    J_m ", "    F_s   | N | soil | 8\n    J_m ").replace(
        'm.motor("M_in"',
        'm.force("soil", plants, tip, m.vector(m.world, 0, q.F_s))\nm.motor("M_in"',
    )
    assert loaded.count("F_s") == 2
    phi = np.linspace(0, 2 * np.pi, 721)
    machine = own.machine(loaded, "planetary_train")
    torque = Model(machine)(phi)["M_in"] - Model(own.machine("planetary_train"))(phi)["M_in"]
    rise = np.gradient(Model(machine)(phi)["y_tip"], phi, edge_order=2)
    assert torque[5:-5] == pytest.approx(-8 * rise[5:-5], abs=2e-4)
    assert max(law.violation for law in compute_cycle(Model(machine), 90).result.laws) < 1e-12
