"""The density of inputs given data: against dense covariances and quadrature, differences, and
fits.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.linalg import toeplitz
from scipy.special import logsumexp

import planter
from planter.engine.machine import Machine
from planter.engine.response import MachineResponse
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.measured.fit import fit_curve
from planter.measured.noise import RHOS
from planter.measured.posterior import Posterior
from tests.support import own

MASS = "m_s_kg"
Write = Callable[..., Path]


@pytest.fixture(scope="module")
def crank() -> Machine:
    return own.machine("slider_crank")


@pytest.fixture
def write(tmp_path: Path, crank: Machine) -> Write:
    """Write forces and torques of the crank, with autoregressive noise, and return the file."""

    def write_record(
        points: int, noise: float = 0.5, rho: float = 0.0, seed: int = 0, offset: float = 2.0
    ) -> Path:
        phi = 2 * np.pi * np.arange(points) / points
        response = MachineResponse(crank, ["F_Ox", "M_in"])
        values = response.values(response.at_data(crank.data), phi)
        rng, errors = np.random.default_rng(seed), np.zeros((2, points))
        errors[:, 0] = rng.normal(size=2)
        for i in range(1, points):
            errors[:, i] = rho * errors[:, i - 1] + np.sqrt(1 - rho**2) * rng.normal(size=2)
        force, torque = values[0] + offset + noise * errors[0], values[1] + noise / 50 * errors[1]
        rows = [
            f"{np.degrees(a):.9f},{f:.12f},{m:.12f}"
            for a, f, m in zip(phi, force, torque, strict=True)
        ]
        path = tmp_path / "force.csv"
        path.write_text(
            "\n".join(["angle [deg],force [N],torque [Nm]", *rows]) + "\n", encoding="utf-8"
        )
        return path

    return write_record


def load(
    crank: Machine, path: Path, both: bool = False, **bounds: tuple[float, float]
) -> Posterior:
    names = ["force", "torque"] if both else ["force"]
    columns = planter.Columns(names, angle="angle")
    quantities = ["F_Ox", "M_in"] if both else ["F_Ox"]
    return planter.load_posterior(
        crank, path, columns, quantities, bounds or {MASS: (0.1, 2.0), "offset": (-20, 20)}
    )


def integrate_noise(residuals: Array) -> float:
    """The log density of residuals, their size integrated by quadrature, correlations by dense
    covariances.
    """
    sizes = np.exp(np.linspace(np.log(1e-3), np.log(1e4), 4000))
    logs = []
    for rho, step in zip(RHOS, np.gradient(RHOS), strict=True):
        covariance = toeplitz(rho ** np.arange(len(residuals)))
        square = residuals @ np.linalg.solve(covariance, residuals)
        log_det = np.linalg.slogdet(covariance)[1]
        density = -len(residuals) * np.log(sizes) - square / (2 * sizes**2) - log_det / 2
        peak = density.max()
        integral = peak + np.log(trapezoid(np.exp(density - peak), np.log(sizes)))
        logs.append(integral + np.log(step) - np.log1p(-(rho**2)) / 2)
    return float(logsumexp(logs))


def test_density_is_that_of_dense_covariances(crank: Machine, write: Write) -> None:
    posterior = load(crank, write(24, rho=0.6))
    assert posterior.units == ("kg", "N")
    points = [np.array([mass, offset]) for mass, offset in ((0.6, 2.0), (0.7, 1.0), (1.2, -3.0))]
    logs, expected = [], []
    for x in points:
        values, _ = posterior.curve(x)
        logs.append(posterior.log_density(x))
        expected.append(integrate_noise(values - posterior.curve.values))
    np.testing.assert_allclose(np.diff(logs), np.diff(expected), rtol=1e-6)


def test_gradient_is_that_of_differences(crank: Machine, write: Write) -> None:
    bounds = {
        MASS: (0.1, 2.0),
        "offset_N": (-20.0, 20.0),
        "phase_deg": (-10.0, 10.0),
        "r_mm": (30.0, 80.0),
    }
    columns = planter.Columns(["force", "torque"], angle="angle")
    posterior = planter.load_posterior(
        crank, write(90), columns, ["F_Ox", "M_in"], bounds, {"r_mm": (50.0, 0.5)}
    )
    x = np.array([0.7, 1.5, 1.0, crank.document.numbers()["values.r_mm"] * 1.01])
    gradient = posterior.gradient(x)
    for i, step in enumerate(1e-5 * (posterior.upper - posterior.lower)):
        ends = [posterior.log_density(x + side * step * np.eye(4)[i]) for side in (1, -1)]
        assert gradient[i] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-4, abs=1e-4)


def test_normal_approximation_is_the_fit_and_its_covariance(crank: Machine, write: Write) -> None:
    posterior = load(crank, write(180, noise=0.2))
    normal = posterior.approximate()
    fit = fit_curve(posterior.curve)
    assert fit.covariance is not None
    assert (np.abs(normal.mean - fit.values) < 0.05 * normal.std).all()
    np.testing.assert_allclose(normal.std, np.sqrt(np.diag(fit.covariance)), rtol=0.1)


def test_normal_approximation_has_moments_of_density(crank: Machine, write: Write) -> None:
    """The noise's correlation is uncertain, so the tails are wider than those of the curvature at
    the mode.
    """
    posterior = load(crank, write(60, rho=0.9, seed=3), offset=(-8.0, 12.0))
    normal = posterior.approximate()
    offsets = np.linspace(-8, 12, 801)
    weights = np.exp(
        [posterior.log_density(np.array([x])) - posterior.log_density(normal.mean) for x in offsets]
    )
    mean = weights @ offsets / weights.sum()
    std = np.sqrt(weights @ (offsets - mean) ** 2 / weights.sum())
    assert normal.mean[0] == pytest.approx(mean, abs=0.05 * std)
    assert normal.std[0] == pytest.approx(std, rel=0.03)
    step = 1e-4
    sides = [posterior.gradient(normal.mean + side * step)[0] for side in (1, -1)]
    assert std > 1.1 * np.sqrt(2 * step / (sides[1] - sides[0]))


def count_inside(
    crank: Machine, write: Write, rho: float, records: int, is_white: bool = False
) -> int:
    """Return how many 95 % intervals hold the offset, by a density for white noise alone if
    `is_white`.
    """
    inside, offsets = 0, np.linspace(-0.5, 4.5, 121)
    for seed in range(records):
        posterior = load(crank, write(60, rho=rho, seed=seed), offset=(-8.0, 12.0))
        if is_white:
            posterior._log_weights = [
                np.where(RHOS == 0, logs, -np.inf) for logs in posterior._log_weights
            ]
        density = np.exp([posterior.log_density(np.array([offset])) for offset in offsets])
        probability = np.interp(2.0, offsets, np.cumsum(density) / density.sum())
        inside += 0.025 <= probability <= 0.975
    return inside


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_intervals_hold_the_truth(crank: Machine, write: Write, rho: float) -> None:
    """At 95 % less than 52 of 60 have a probability of 0.3 %."""
    assert count_inside(crank, write, rho, 60) >= 52


def test_intervals_for_white_noise_miss_the_truth(crank: Machine, write: Write) -> None:
    """The tampered case: at 95 % less than 9 of 12 have a probability of 0.2 %."""
    assert count_inside(crank, write, 0.9, 12, is_white=True) < 9


def test_phase_over_a_period_has_no_bounds(crank: Machine, write: Write) -> None:
    """The true phase is where its bounds begin and end, and friction lets the curve jump."""
    path = write(90, noise=2.0)
    cyclic = load(crank, path, offset=(-20.0, 20.0), phase_deg=(0.0, 360.0))
    normal, narrow = (
        cyclic.approximate(),
        load(crank, path, offset=(-20.0, 20.0), phase_deg=(-20.0, 20.0)).approximate(),
    )
    assert 0 <= normal.mean[1] < 360
    assert (normal.mean[1] - narrow.mean[1] + 180) % 360 - 180 == pytest.approx(
        0, abs=0.02 * narrow.std[1]
    )
    assert normal.std == pytest.approx(narrow.std, rel=0.02)
    for x in (normal.mean, narrow.mean):
        assert cyclic.log_density(np.add(x, [0, 360])) == pytest.approx(
            cyclic.log_density(x), rel=1e-9
        )


def test_outside_of_bounds_is_impossible(crank: Machine, write: Write) -> None:
    posterior = load(crank, write(30))
    assert posterior.log_density(np.array([3.0, 0.0])) == -np.inf
    assert not posterior.gradient(np.array([3.0, 0.0])).any()


def test_inputs_that_data_do_not_determine_are_named(crank: Machine, write: Write) -> None:
    posterior = load(crank, write(60), offset=(-20.0, 20.0), J_kg_m2=(1e-9, 2e-9))
    with pytest.raises(ComputationError, match="J_kg_m2"):
        posterior.approximate()
    with pytest.raises(InputError, match="at least one"):
        planter.load_posterior(crank, write(30), "force", "F_Ox", {})
    with pytest.raises(InputError, match="did you mean"):
        load(crank, write(30), m_ss_kg=(0.1, 1.0))


GALLERY = Path(__file__).parents[3] / "docs" / "gallery" / "measured.md"


PAGE = GALLERY.read_text(encoding="utf-8")
SAMPLERS = {"numpyro": "NumPyro", "pymc": "PyMC"}
"""Rows of the page's table by the package that the code imports."""


def draw_by_page(package: str, posterior: Posterior) -> Array:
    """Run the page's code for a package, and return its draws (m, n)."""
    pytest.importorskip(package, reason=f"{package} is not installed")
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names: dict[str, Any] = {"posterior": posterior, "np": np}
    exec(next(block for block in blocks if f"import {package}\n" in block), names)
    draws: Array = names["draws"]
    return draws


def read_row(name: str) -> tuple[Array, Array]:
    """Return means (n,) and deviations (n,) of a row of the page's table."""
    (row,) = re.findall(rf"^\| {name} \|(.*)\|$", PAGE, re.MULTILINE)
    numbers = np.array(re.findall(r"[\d.]+", row), dtype=float)
    return numbers[::2], numbers[1::2]


@pytest.mark.long
@pytest.mark.parametrize("package", SAMPLERS)
def test_page_has_the_figures_of_its_code(package: str) -> None:
    """Its force and its samplers: means within 0.2 of a deviation, deviations within 10 %."""
    cells = re.findall(r"```\{code-cell\}\n(.*?)```", PAGE, re.DOTALL)
    names: dict[str, Any] = {}
    exec(cells[0], names)
    exec(next(cell for cell in cells if "load_posterior" in cell), names)
    normal = names["posterior"].approximate()
    means, deviations = read_row("`approximate`")
    np.testing.assert_allclose(means, normal.mean, rtol=2e-3)
    np.testing.assert_allclose(deviations, normal.std, rtol=1e-2)
    draws = draw_by_page(package, names["posterior"])
    means, deviations = read_row(SAMPLERS[package])
    assert (np.abs(draws.mean(axis=0) - normal.mean) < 0.3 * normal.std).all()
    assert (np.abs(draws.mean(axis=0) - means) < 0.2 * deviations).all()
    np.testing.assert_allclose(draws.std(axis=0), deviations, rtol=0.1)
