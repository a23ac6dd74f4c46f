"""A machine along its angle: all quantities by name, loops closed, and where the points of its bodies are."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine
from planter.engine.response import DesignPoint, Response
from planter.kernels import Array, Kernel


class Model:
    """A machine along its angle: all quantities by name, at its values or at others ``data`` (v,); SI and radians.

    >>> import numpy as np
    >>> from planter import load_mechanism
    >>> machine = Model(load_mechanism("wang2017"))
    >>> machine.speed == 40 * 2 * np.pi / 60
    True
    >>> np.degrees(machine.list_angles(4))
    array([  0.,  90., 180., 270.])
    >>> machine(np.radians([0.0, 90.0]))["x_tip"].round(4)
    array([-0.1177, -0.1796])
    >>> machine.results(np.radians([0.0, 90.0]))["tip_x_mm"].round(1)
    array([-117.7, -179.6])
    """

    def __init__(self, machine: Machine, data: Array | None = None) -> None:
        self.machine = machine if data is None else machine.with_data(data)
        still = replace(self.machine, moved=(), lower=np.empty(0), upper=np.empty(0))  # slopes are not asked for
        self._response, self._kernels = Response(still), dict[str, Kernel]()

    @property
    def speed(self) -> float:
        """The speed of the drive [rad/s]."""
        return float(self.machine.data[self.machine.speed])

    def list_angles(self, samples: int | None = None) -> Array:
        """Return the angles (n,) [rad] of a cycle in equal steps, as many as the file says unless `samples` does."""
        count = self.machine.samples if samples is None else samples
        return self.machine.turn * np.arange(count) / count

    def __call__(self, angles: Array) -> dict[str, Array]:
        """Return all quantities (n,) by name at angles (n,) [rad].

        Raises ComputationError where loops do not close, or where forces are not determined.
        """
        angles = np.asarray(angles, dtype=float)
        values = self._response.values(self._point, angles)
        self._response.check(values, angles)
        return {q.name: row for q, row in zip(self.machine.quantities, values, strict=True)}

    def results(self, angles: Array) -> dict[str, Array]:
        """Return the results (n,) at angles (n,) [rad] by key, each in the unit that its key ends in.

        Raises ComputationError as a call does.
        """
        values = self(angles)
        return {q.key: values[q.name] / q.factor for q in self.machine.results}

    def places(self, angles: Array) -> dict[str, Array]:
        """Return where the points of all bodies are (n,) [m] at angles (n,) [rad], by name.

        Components are along the axes of the world. Names are ``x_BODY__POINT`` and its like. Machines without bodies of
        their own statement have none.
        """
        return self.evaluate("places", angles)

    def evaluate(self, name: str, angles: Array) -> dict[str, Array]:
        """Return the values (n,) [SI] of a further function of the machine at angles (n,) [rad] by name.

        Functions are "places", "followers" and "meshes"; the result is empty for one that the machine lacks. Raises
        ComputationError if loops do not close.
        """
        stage = self.machine.stages.get(name)
        if stage is None:
            return {}
        kernel = self._kernels.setdefault(name, Kernel(stage.function, lanes=["phi", "q"]))
        q = self._response.coordinates(self.machine.data, angles)
        rows = kernel(phi=angles, d=self.machine.data, h=self._point.h, q=q)["y"]
        return {quantity.name: row for quantity, row in zip(stage.quantities, rows, strict=True)}

    @cached_property
    def _point(self) -> DesignPoint:
        return self._response.at_data(self.machine.data)
