"""Other programs for the same machines: Pinocchio, MuJoCo and SymPy's Kane, where they are installed."""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp
from sympy.physics import mechanics

from planter.kernels import Array
from tests.planter.mechanism.state_space.statements import build_tree

NAMES = ("pin", "mujoco", "sympy", "opty", "symforce")
"""Distributions of the other programs."""
CALLS_S = 0.05
"""Time of the calls of which one is an average."""


def find_versions() -> dict[str, str]:
    """Return the versions of the programs, "not installed" where there is none."""
    versions = {}
    for name in NAMES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "not installed"
    return versions


def is_installed(name: str) -> bool:
    """Whether a program of NAMES can be used."""
    return find_versions()[name] != "not installed"


def time_call(call: Callable[[], object]) -> float:
    """Return the CPU time [ns] of a call: the shortest average of five."""
    call()
    began = time.process_time()
    call()
    count = max(3, int(CALLS_S / max(time.process_time() - began, 1e-6)))
    averages = []
    for _ in range(5):
        began = time.process_time()
        for _ in range(count):
            call()
        averages.append((time.process_time() - began) / count)
    return 1e9 * min(averages)


class Pinocchio:
    """A tree of Pinocchio: accelerations and their derivatives; a call by Python is taken off."""

    def __init__(self, links: int = 0, robot: Path | None = None) -> None:
        import pinocchio

        self._pin = pinocchio
        self.tree: Any = build_tree(links) if robot is None else self._read(robot)
        self._data = self.tree.createData()

    def _read(self, robot: Path) -> Any:
        return self._pin.buildModelFromUrdf(str(robot))

    def accelerate(self, q: Array, rates: Array, efforts: Array) -> Array:
        """Return the accelerations (k,); without efforts there are none."""
        loads = efforts if len(efforts) else np.zeros(self.tree.nv)
        result: Array = self._pin.aba(self.tree, self._data, q, rates, loads)
        return result

    def differentiate(self, q: Array, rates: Array, efforts: Array) -> Array:
        """Return their derivatives (k, 2k) by state."""
        loads = efforts if len(efforts) else np.zeros(self.tree.nv)
        parts = self._pin.computeABADerivatives(self.tree, self._data, q, rates, loads)
        return np.hstack(parts[:2])

    def measure(self) -> dict[str, float]:
        """Return the times [ns] of both, less that of the accelerations of a single link."""
        call = Pinocchio(1)._time("aba")
        return {
            "f_ns": self._time("aba") - call,
            "jacobian_ns": self._time("computeABADerivatives") - call,
            "call_ns": call,
        }

    def _time(self, name: str) -> float:
        function, tree, data = getattr(self._pin, name), self.tree, self._data
        q, rates, efforts = 0.3 * np.random.default_rng(0).standard_normal((3, tree.nv))
        return time_call(lambda: function(tree, data, q, rates, efforts))


def _write_mujoco_chain(links: int) -> str:
    bodies = (
        f'<body pos="{0.4 * (k > 0)} 0 0"><joint type="hinge" axis="0 0 1"/>'
        '<inertial pos="0.2 0 0" mass="1" diaginertia="0.005 0.01 0.01"/>'
        for k in range(links)
    )
    return (
        '<mujoco><option gravity="0 -9.81 0"><flag contact="disable" constraint="disable"/>'
        f"</option><worldbody>{''.join(bodies)}{'</body>' * links}</worldbody></mujoco>"
    )


def measure_mujoco(links: int) -> dict[str, float]:
    """Return times [ns] of `mj_forward` and of centred differences of a step, less a call's, and the
    error of the accelerations of a chain against Pinocchio.
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(_write_mujoco_chain(links))
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    data.qpos[:], data.qvel[:] = 0.3 * rng.standard_normal((2, links))
    slopes = np.zeros((2 * links, 2 * links))
    call = time_call(mujoco.mj_versionString)
    times = {
        "f_ns": time_call(lambda: mujoco.mj_forward(model, data)) - call,
        "jacobian_ns": time_call(
            lambda: mujoco.mjd_transitionFD(model, data, 1e-6, True, slopes, None, None, None)
        )
        - call,
    }
    if is_installed("pin"):
        mujoco.mj_forward(model, data)
        expected = Pinocchio(links).accelerate(data.qpos, data.qvel, np.zeros(links))
        times["error"] = find_error(data.qacc, expected)
    return times


def find_error(values: Array, expected: Array) -> float:
    """Return the largest error over the largest number."""
    return float(np.abs(values - expected).max() / np.abs(expected).max())


def measure_kane(links: int) -> dict[str, float]:
    """Return what SymPy's method of Kane takes for a chain: `derive_s` and `compile_s` [CPU s], the
    latter of `lambdify`, `f_ns` with NumPy's solution for the accelerations, and their error.
    """
    began = time.process_time()
    q, u = (mechanics.dynamicsymbols(f"{name}:{links}") for name in "qu")
    world, point = mechanics.ReferenceFrame("N"), mechanics.Point("O")
    point.set_vel(world, 0)
    frame, bodies, loads = world, [], []
    for k in range(links):
        turned = frame.orientnew(f"F{k}", "Axis", (q[k], world.z))
        turned.set_ang_vel(frame, u[k] * world.z)
        centroid, end = (
            point.locatenew(f"{n}{k}", x * turned.x) for n, x in (("C", 0.2), ("E", 0.4))
        )
        for place in (centroid, end):
            place.v2pt_theory(point, world, turned)
        inertia = 0.01 * mechanics.outer(turned.z, turned.z)
        bodies.append(mechanics.RigidBody(f"b{k}", centroid, turned, 1, (inertia, centroid)))
        loads.append((centroid, -9.81 * world.y))
        point, frame = end, turned
    method = mechanics.KanesMethod(world, q, u, [a.diff() - b for a, b in zip(q, u, strict=True)])
    method.kanes_equations(bodies, loads)
    derived = time.process_time()
    symbols = sp.symbols(f"y:{2 * links}")
    places = dict(zip([*q, *u], symbols, strict=True))
    parts = [mechanics.msubs(part, places) for part in (method.mass_matrix, method.forcing)]
    function = sp.lambdify([symbols], parts, cse=True)
    compiled = time.process_time()
    state = np.random.default_rng(0).standard_normal(2 * links)

    def accelerate() -> Array:
        inertia, forces = function(state)
        return np.linalg.solve(inertia, forces)[:, 0]

    result = {
        "derive_s": derived - began,
        "compile_s": compiled - derived,
        "f_ns": time_call(accelerate),
    }
    if is_installed("pin"):
        expected = Pinocchio(links).accelerate(state[:links], state[links:], np.zeros(links))
        result["error"] = find_error(accelerate(), expected)
    return result
