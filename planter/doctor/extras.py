"""The optional parts of the package, and which of them are installed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec

from planter.doctor.results import Extra

EXTRAS: Mapping[str, tuple[str, str]] = {
    "derive": ("sympy", "mechanisms of your own, audits of papers, derivation of the equations"),
    "compiler": ("ziglang", "a C compiler for systems without one, and pages without a server"),
    "notebook": ("anywidget", "machines that move in a notebook"),
    "studio": ("starlette", "the interactive page (`planter studio`)"),
    "parquet": ("pyarrow", "tables of sweeps as Parquet beside CSV"),
    "step": ("OCP", "solid bodies as STEP files"),
    "cluster": ("distributed", "jobs on a Dask cluster"),
}
"""Extras of pyproject.toml for those who use the package: a module that only the extra brings, and its purpose."""


def list_extras() -> list[Extra]:
    """Return every extra with its purpose and whether it is installed."""
    return [Extra(name, find_spec(module) is not None, purpose) for name, (module, purpose) in EXTRAS.items()]
