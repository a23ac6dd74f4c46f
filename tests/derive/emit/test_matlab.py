"""Function files for MATLAB: run in Octave, where there is one, they give what the CasADi functions
give.
"""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from derive.__main__ import main
from derive.emit.folder import built_in, render_texts
from derive.mechanics.gearing.families import FAMILIES
from derive.model import ClosedForm, Let, System
from derive.papers.planting import derivation, flanks
from derive.quantity import Quantity, Vector
from planter.engine.response import MachineResponse
from planter.kernels import generated
from tests.support import machines, octave, own

(MATLAB,) = (target for target in built_in() if target.name == "matlab")
PHI = np.radians([0.0, 37.0, 121.0, 233.0, 359.0])
CURVES = {
    "eccentric_circle": [0.03, 0.004],
    "ellipse": [0.03, 0.1],
    "fourier": [0.03, 0.003, 0.0005, 1e-4],
    "limacon": [0.03, 0.1],
    "sine": [0.06, 0.2],
}
"""Parameters of a curve of each family."""


def largest_deviation(values: np.ndarray, expected: np.ndarray) -> float:
    """The largest difference of two arrays (rows, lanes), over the largest value of its row or
    one.
    """
    sizes = np.maximum(1.0, np.abs(expected).max(axis=1, keepdims=True))
    return float((np.abs(values.reshape(expected.T.shape).T - expected) / sizes).max())


@pytest.fixture(scope="module")
def planting(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of the planting device, its pitch curves and the laws of its cam."""
    place = tmp_path_factory.mktemp("planting")
    systems = [derivation.build_exact_system(), *(build() for build in flanks.SYSTEMS)]
    for name, text in render_texts(systems, FAMILIES.values(), [MATLAB]).items():
        path = place / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return place / "matlab"


@octave.needed
@pytest.mark.parametrize("name", ["slider_crank", "transplanting_arm"])
def test_user_mechanism_agrees_in_matlab(name: str, tmp_path: Path) -> None:
    """Newton steps, simultaneous equations and friction by cases."""
    assert (
        main([str(own.EXAMPLES / f"{name}.py"), "--target", "matlab", "--out", str(tmp_path)]) == 0
    )
    machine = own.machine(name)
    at = MachineResponse(machine).coordinates(machine.data, PHI)
    module = generated.module(name, own.generated(name))
    lane, hoisted = module.lane(), module.prologue()(machine.data)
    expected = np.array(
        [lane(p, machine.data, g, hoisted).full()[:, 0] for p, g in zip(PHI, at.T, strict=True)]
    ).T

    def derived_outputs(data: np.ndarray) -> np.ndarray:
        return octave.run(
            tmp_path / "matlab",
            {"phi": PHI, "data": data, "loops": at.T},
            f"""
            m = {name}(); hoisted = m.prologue(data); loops = reshape(loops, [], numel(phi)); found = [];
            for i = 1:numel(phi), found = [found, m.lane(phi(i), data, loops(:, i), hoisted)]; end""",
        )

    assert largest_deviation(derived_outputs(machine.data), expected) < 1e-12
    assert largest_deviation(derived_outputs(machine.data * 1.001), expected) > 1e-5


@octave.needed
@pytest.mark.long
def test_planting_device_agrees_in_matlab(planting: Path) -> None:
    """Curves by closure and in closed form, composed functions, angles that wrap, both sides and
    the frame.
    """
    device = machines.device("wang2017")
    x, c = device.design, device.constants
    h = device.functions.prologue_function(x, c)
    first, second, totals = device.functions.both
    function = ca.Function("cycle", device.functions.inputs, [ca.vertcat(first, second, totals)])
    expected = np.array([function(p, x, c, h).full()[:, 0] for p in PHI]).T
    families, terms = [s.family for s in device.stages], [s.terms for s in device.stages]
    ends = np.cumsum([4, *(len(s.names) for s in device.stages)])
    law = next(f.args[0] for f in flanks.SYSTEMS if f.args[0] == device.machine.cam.flank)
    inputs = {"phi": PHI, "mounting": x[:4], "p1": x[4 : ends[1]], "p2": x[ends[1] :], "c": c}
    results = octave.run(
        planting,
        inputs,
        f"""
        m = planting_exact(); one = curve_{families[0]}(); two = curve_{families[1]}();
        cam = flank_{law.replace(" ", "_").replace("-", "_")}();
        h1 = one.prologue(p1, {terms[0]}); h2 = two.prologue(p2, {terms[1]});
        h = m.prologue(mounting, p1, h1, p2, h2, c, one.contact, two.contact);
        side = @(phi) m.lane(phi, mounting, p1, h1, p2, h2, c, h, one.contact, two.contact, cam.law);
        found = [];
        for i = 1:numel(phi)
            a = side(phi(i)); b = side(phi(i) - pi); found = [found, [a; b; m.frame(a, b, c)]];
        end""",
    )
    assert largest_deviation(results, expected) < 1e-12


@octave.needed
@pytest.mark.parametrize("family", FAMILIES)
def test_a_pitch_curve(family: str, planting: Path) -> None:
    terms, t, parameters = 64, np.array([0.3, 2.0, 3.9, 7.0]), [*CURVES[family], 1.2]
    module = generated.module(f"curve_{family}")
    hoisted = module.prologue(terms)(parameters)
    contact = module.contact(terms)
    expected = np.array([[float(out) for out in contact(at, parameters, hoisted)] for at in t]).T
    results = octave.run(
        planting,
        {"t": t, "p": parameters},
        f"""
        m = curve_{family}(); h = m.prologue(p, {terms}); found = [];
        for i = 1:numel(t), found = [found, m.contact(t(i), p, h)]; end""",
    )
    assert largest_deviation(results, expected) < 1e-12


def system(name: str) -> System:
    symbol, result = (Quantity(n, "1", f"{n} of the test", "test") for n in (name, "result"))
    form = ClosedForm(
        "twice", (symbol,), (Let(result, 2 * symbol, "test"),), Vector("given", (result,))
    )
    return System("small", "Small", "test", (), closed_forms=(form,))


def test_reserved_matlab_name_is_refused() -> None:
    with pytest.raises(ValueError, match="function twice: _a: a name in MATLAB is a letter"):
        render_texts([system("_a")], (), [MATLAB])
    assert "result = 2 * a;" in render_texts([system("a")], (), [MATLAB])["matlab/small.m"]


def test_a_language_is_written_where_it_is_asked_for_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(own.EXAMPLES / "manipulator.py")
    assert main([file, "--out", str(tmp_path / "without")]) == 0
    assert not list((tmp_path / "without").rglob("*.m"))
    assert main([file, "--out", str(tmp_path), "--target", "matlap"]) == 2
    assert capsys.readouterr().err.startswith(
        "--target: no target is called matlap; there are array, casadi, "
    )
    assert main(["code", "--target", "matlab"]) == 2
    assert "`code --target NAME --out DIR`" in capsys.readouterr().err
