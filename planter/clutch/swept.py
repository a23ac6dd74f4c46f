"""Adapter of clutches for sweeps and tolerances (`planter.tolerance.adapter`)."""

from planter.tolerance.adapter import FileAdapter

ADAPTER = FileAdapter(__package__, "load_clutch")
