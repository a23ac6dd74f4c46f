"""Generated models of independent functions, called with named arguments, over any number of
lanes.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel, generated
from planter.progress import name_step

HOISTED = "hoisted"
"""What a prologue gives and a lane takes."""


class Formulas:
    """A generated model without functions that are composed at run time. SI units and radians.

    `folder` is where a model of the user's own was generated; else it is one of ours or of an
    installed package.

    >>> load("clutch_exact")("taper", R2=0.013, d=0.010, phi=0.0)
    {'R1': array([0.013])}
    """

    def __init__(self, name: str, folder: Path | None = None) -> None:
        self.name, self.folder = name, folder
        self._functions: dict[str, ca.Function] = {}
        self._kernels: dict[str, Kernel] = {}

    @cached_property
    def sidecar(self) -> dict[str, Any]:
        return generated.sidecar(self.name, self.folder)

    def function(self, stage: str) -> ca.Function:
        """The CasADi function of a stage, to compose others from; numbers come from `__call__`."""
        if stage not in self._functions:  # a lane with many unknowns takes seconds to build
            with name_step(f"{self.name}: building the function {stage}"):
                self._functions[stage] = self._build_function(stage)
        return self._functions[stage]

    def _build_function(self, stage: str) -> ca.Function:
        module = generated.module(self.name, self.folder)
        if self.folder is None:
            function: ca.Function = getattr(module, stage)()
            return function
        path = self.folder / f"{self.name}.py"
        try:
            function = getattr(module, stage)()
        except Exception as error:  # of whatever kind: the file may have been edited
            problem = f"{stage} does not run: {type(error).__name__}: {error}"
            raise generated.refuse_generated(path, problem) from None
        if not isinstance(function, ca.Function):
            raise generated.refuse_generated(path, f"{stage} is no function")
        return function

    def outputs(self, stage: str) -> list[str]:
        """Names of what a stage gives, in their order."""
        return self.entries(self.sidecar["functions"][stage]["output"])

    def entries(self, vector: str) -> list[str]:
        """Names in a packed input or output, in their order."""
        return [entry["name"] for entry in self.sidecar["vectors"][vector]]

    def composed(self, stage: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """A stage as part of a graph: its outputs by name, from what is known by name, entries of
        packed inputs too.
        """
        function = self.function(stage)
        packed = self.sidecar["vectors"]
        arguments = [
            ca.vertcat(*(values[entry] for entry in self.entries(name)))
            if name in packed
            else values[name]
            for name in function.name_in()
        ]
        return dict(zip(self.outputs(stage), ca.vertsplit(function(*arguments)), strict=True))

    def __call__(self, stage: str, **inputs: object) -> dict[str, Array]:
        """Outputs by name, each (n,): single inputs are numbers or (n,), packed ones (rows,) or
        (rows, n).

        What a lane takes from its prologue is found from the other inputs. Raises CallError for
        inputs that do not fit, ComputationError where a result is not finite.
        """
        kernel = self._kernel(stage)
        if HOISTED in kernel.names and HOISTED not in inputs:
            inputs[HOISTED] = self._hoisted(inputs)
        packed = {name: _columns(kernel, name, value) for name, value in inputs.items()}
        count = max((columns.shape[1] for columns in packed.values()), default=1)
        lanes = {
            k: np.broadcast_to(v, (v.shape[0], count)) if v.shape[1] == 1 else v
            for k, v in packed.items()
        }
        (result,) = kernel(**lanes).values()
        return dict(zip(self.outputs(stage), result, strict=True))

    def at(self, stage: str, **inputs: object) -> dict[str, float]:
        """Return the results for a single lane, as numbers."""
        return {name: float(value[0]) for name, value in self(stage, **inputs).items()}

    def pick(self, stage: str, values: Mapping[str, Any]) -> dict[str, float]:
        """Return the results for a single lane from what is known by name, entries of packed inputs
        too.
        """
        packed = self.sidecar["vectors"]
        inputs = {
            name: [values[entry] for entry in self.entries(name)]
            if name in packed
            else values[name]
            for name in self.function(stage).name_in()
        }
        return self.at(stage, **inputs)

    def _hoisted(self, inputs: Mapping[str, object]) -> Array:
        prologue = self._kernel("prologue")
        return prologue(**{name: inputs[name] for name in prologue.names if name in inputs})[
            HOISTED
        ]

    def _kernel(self, stage: str) -> Kernel:
        if stage not in self._kernels:
            function = self.function(stage)
            self._kernels[stage] = Kernel(function, lanes=function.name_in())
        return self._kernels[stage]


def _columns(kernel: Kernel, name: str, value: object) -> Array:
    array = np.asarray(value, dtype=float)
    if array.ndim == 2 or name not in kernel.names:
        return np.atleast_2d(array)
    single = kernel.function.size1_in(kernel.names.index(name)) == 1
    return array.reshape(1, -1) if single else array.reshape(-1, 1)


@cache
def load(name: str, folder: Path | None = None) -> Formulas:
    """The generated model of a name; each is loaded once."""
    return Formulas(name, folder)
