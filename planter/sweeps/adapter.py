"""Adapters of machines for sweeps: protocol of the object `ADAPTER` in the module `swept` of a
package of machines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from planter.errors import InputError
from planter.files import paths
from planter.files.document import Document
from planter.files.kinds import find_kind, load_part
from planter.kernels import Array


class SweepSubject(Protocol):
    """A machine that evaluates rows of inputs."""

    def evaluated(self, points: Array, threads: int) -> Array:
        """Return outputs (m, k) at points (m, n), in display units; rows without a result are
        NaN.
        """


class SweepAdapter(Protocol):
    """Adapter of a kind of machines.

    All values are in the display units [which their keys name].
    """

    choices: Mapping[str, Sequence[str]]
    """Inputs with texts as values, and their allowed values, the default first."""

    def load(self, source: str, changes: Mapping[str, float]) -> Document:
        """Load a machine from a file, with changed numbers."""

    def inputs(self, machine: Any) -> Mapping[str, str]:
        """Return the meanings of the inputs, by path."""

    def outputs(self, machine: Any) -> Mapping[str, str]:
        """Return the meanings of the outputs, by name."""

    def describe_measure(self, machine: Any, text: str, label: str) -> tuple[str, str]:
        """Return the name and the meaning of an output that is an expression in the language of
        measures.

        Raises InputError, which begins with `label`, if the expression is invalid.
        """

    def default_outputs(self, machine: Any) -> Sequence[str]:
        """Return the names of the outputs of a plan that names none."""

    def hash_curves(self, machine: Any, outputs: Sequence[str]) -> Mapping[str, str]:
        """Return the hashes of further files that outputs need, by path."""

    def frozen(self, machine: Any) -> dict[str, Any]:
        """Return a description of the machine, fit for JSON, from which `subject` builds it in
        another process.
        """

    def subject(
        self,
        frozen: Mapping[str, Any],
        choices: Mapping[str, str],
        inputs: Mapping[str, tuple[float, float]],
        outputs: Sequence[str],
    ) -> SweepSubject:
        """Build a machine whose `inputs`, by path, take values between two ends.

        Raises InputError if it cannot be built at these ends.
        """


class ResolvedMachine:
    """A machine with the adapter of its kind. Raises InputError if no adapter takes `source`."""

    def __init__(self, source: str, changes: Mapping[str, float] | None = None) -> None:
        adapter = load_part(source, "swept") if find_kind(source) else None
        if adapter is None:
            raise InputError(
                f"{source}: no such machine; name a machine file, or a built-in machine that can "
                f"be swept"
            )
        self.module, self.adapter, self.source = adapter.__name__, adapter.ADAPTER, source
        self.machine = self.adapter.load(source, changes or {})

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """Meanings of the inputs, by path."""
        inputs: Mapping[str, str] = self.adapter.inputs(self.machine)
        return inputs

    @cached_property
    def outputs(self) -> Mapping[str, str]:
        """Meanings of the outputs, by name."""
        outputs: Mapping[str, str] = self.adapter.outputs(self.machine)
        return outputs

    @property
    def choices(self) -> Mapping[str, Sequence[str]]:
        """Allowed values of inputs with texts, by name."""
        choices: Mapping[str, Sequence[str]] = self.adapter.choices
        return choices

    def path(self, name: str, label: str) -> str:
        """Return the full path of an input.

        Raises InputError, which begins with `label`, if it does not exist.
        """
        return find_full_name(name, self.inputs, label, "inputs")

    def hash_curves(self, outputs: Sequence[str]) -> dict[str, Any]:
        """Return the hashes of files that outputs need, as arguments of a recipe: other curves give
        other rows.
        """
        hashes = self.adapter.hash_curves(self.machine, outputs)
        return {"curves": dict(hashes)} if hashes else {}

    def resolve_outputs(self, names: Sequence[str], label: str) -> list[str]:
        """Return full names of outputs, the default ones if `names` is empty.

        Raises InputError as `path`.
        """
        names = names or self.adapter.default_outputs(self.machine)
        if not names:
            raise InputError(
                f"{label} is missing: name at least one output; {_hint((), 'outputs')}"
            )
        return [self.describe_output(name, label)[0] for name in names]

    def describe_output(self, name: str, label: str) -> tuple[str, str]:
        """Return the full name and the meaning of an output. Raises InputError as `path`."""
        if " " in name:
            described: tuple[str, str] = self.adapter.describe_measure(self.machine, name, label)
            return described
        full = find_full_name(name, self.outputs, f"{label}: {name}", "outputs")
        return full, self.outputs[full]


def find_full_name(name: str, meanings: Mapping[str, str], label: str, kind: str) -> str:
    """Return the key of `meanings` that is `name`, or the only one that ends in it.

    Raises InputError, which begins with `label` and names the `kind` of the names, unless there is
    exactly one.
    """
    candidates = paths.Names(list(meanings)).candidates(name)
    if len(candidates) == 1:
        return candidates[0]
    hint = (
        f"it fits several, name one of {', '.join(candidates)}"
        if candidates
        else _hint(paths.find_similar(name, meanings), kind)
    )
    raise InputError(f"{label}: {hint}")


def _hint(close: Sequence[str], kind: str) -> str:
    suggestion = f"did you mean {' or '.join(close)}? " if close else ""
    return f"{suggestion}`planter sweep --list MACHINE` lists all {kind}"


def resolve_source(source: str, folder: Path | None) -> str:
    """Return the path of a machine file that a plan names relative to its folder, else the source
    itself.
    """
    if folder is not None and not Path(source).is_absolute() and (folder / source).is_file():
        return str(folder / source)
    return source
