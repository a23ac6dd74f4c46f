"""What of mechanisms of one's own can be swept: `ROOM`, as `planter.sweeps.room` has it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.errors import InputError, PlanterError
from planter.files import units
from planter.files.text import read_toml
from planter.kernels import Array
from planter.mechanism import file

if TYPE_CHECKING:
    from planter.mechanism.file import MechanismFile
    from planter.mechanism.model import Model
    from planter.progress import Listener
    from planter.tolerance.room import Settings
    from planter.tolerance.spread import Spread

MEASURES: dict[str, Callable[[Array], Any]] = {
    "max": np.max, "min": np.min, "range": np.ptp, "mean": np.mean, "std": np.std,
    "rms": lambda values: np.sqrt(np.mean(values**2)),
}  # fmt: skip
"""What is measured of a quantity over a turn, under the name `QUANTITY_MEASURE_UNIT`."""
AVERAGES = ("mean", "std", "rms")
"""Measures that only a turn has that ends in the state in which it began."""


class Room:
    """Mechanisms that an angle drives."""

    choices: Mapping[str, Sequence[str]] = {}
    usual: Sequence[str] = ()
    banded: Sequence[str] = ()
    curves: Sequence[str] = ()
    paths: Sequence[tuple[str, str]] = ()

    def takes(self, source: str) -> bool:
        """A mechanism's file, or its name as `planter turn` takes it."""
        try:
            return "functions" in read_toml(file.path(source))
        except InputError:
            return False

    def load(self, source: str, changes: Mapping[str, float]) -> MechanismFile:
        """The file, some numbers set."""
        return file.load(source, changes)

    def inputs(self, machine: MechanismFile) -> dict[str, str]:
        """Its values."""
        return {entry["shown"]: entry["meaning"] for entry in machine.entries}

    def outputs(self, machine: MechanismFile) -> dict[str, str]:
        """Measures of its results over a turn."""
        return {name: f"{entry['meaning']}: {kind} over a turn" for name, entry, kind in outputs(machine)}

    def nominal(self, machine: MechanismFile) -> dict[str, float]:
        """Its values."""
        own = machine.numbers()
        return {entry["shown"]: own[entry["shown"]] for entry in machine.entries}

    def tolerances(self, machine: MechanismFile) -> dict[str, dict[str, Any]]:
        """None that could be assumed of any mechanism."""
        return {}

    def robust(
        self, machine: MechanismFile, choices: Mapping[str, str], spreads: Mapping[str, Spread], settings: Settings,
        progress: Listener | None,
    ) -> None:  # fmt: skip
        """None: what is to be small, `planter optimise --least` asks."""

    def frozen(self, machine: MechanismFile) -> dict[str, Any]:
        """Its table, and where its functions are."""
        return {"table": machine.table(), "source": machine.source, "folder": str(machine.place)}

    def subject(
        self, frozen: Mapping[str, Any], choices: Mapping[str, str], inputs: Mapping[str, tuple[float, float]],
        outputs: Sequence[str],
    ) -> Mechanism:  # fmt: skip
        """A mechanism whose values take others. Raises InputError where the file does not allow their ends."""
        machine = file.made(frozen["table"], frozen["source"], Path(frozen["folder"]))
        for end in (0, 1):
            for name, ends in inputs.items():
                machine.moved_to({name.rpartition(".")[2]: ends[end]})
        return Mechanism(machine, tuple(inputs), outputs)


ROOM = Room()


def outputs(machine: MechanismFile) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Every output's name, the entry of its quantity and its measure."""
    for entry in machine.model.sidecar["vectors"]["outputs"]:
        key = units.key(entry["name"], entry["unit"])
        suffix = units.suffix(key)
        for kind in MEASURES:
            yield f"{key.removesuffix(suffix)}_{kind}{suffix}", entry, kind


class Mechanism:
    """Outputs of a mechanism by name over rows of its values by path, in the units [that the names end in]."""

    def __init__(self, machine: MechanismFile, inputs: Sequence[str], names: Sequence[str]) -> None:
        self.machine = machine
        order = [entry["shown"] for entry in machine.entries]
        self._places = [order.index(name) for name in inputs]
        self._factors = np.array([units.factor(name) for name in inputs])
        known = {name: (entry, kind) for name, entry, kind in outputs(machine)}
        self._asked = [known[name] for name in names]
        self._angles = 2 * np.pi * np.arange(machine.turn.samples) / machine.turn.samples

    def evaluated(self, points: Array, threads: int) -> Array:
        """Outputs (m, k) at points (m, n).

        They are NaN in rows whose loops do not close, or that have no forces, and averages of what does not repeat.
        """
        return np.array([self._row(point) for point in points]).reshape(len(points), len(self._asked))

    def slopes(self, point: Array) -> None:
        """None: exact ones are those of bounded values alone."""

    def curves(self, keys: Sequence[str], points: Array) -> dict[str, Array]:
        """None are usual."""
        return {}

    def _row(self, point: Array) -> list[float]:
        from planter.mechanism.periodicity import periodicity

        model = self._model(point)
        try:
            found = model(self._angles)
        except PlanterError:
            return [np.nan] * len(self._asked)
        averaged = any(kind in AVERAGES for _, kind in self._asked)
        changes = periodicity(model, self._angles, found, search=False).changes if averaged else {}
        return [self._measured(found[entry["name"]], entry, kind, changes) for entry, kind in self._asked]

    @staticmethod
    def _measured(values: Array, entry: Mapping[str, Any], kind: str, changes: Collection[str]) -> float:
        """A measure of values (n,) in its shown unit."""
        key = units.key(entry["name"], entry["unit"])
        if kind in AVERAGES and key in changes:
            return np.nan
        return float(MEASURES[kind](values / units.factor(key)))

    def _model(self, point: Array) -> Model:
        from planter.mechanism.model import Model

        data = self.machine.data()
        data[self._places] = point * self._factors
        return Model(self.machine, data)
