"""Adapter of pick-ups for sweeps and tolerances (`planter.rows.tolerance.adapter`)."""

from planter.rows.tolerance.adapter import FileAdapter

ADAPTER = FileAdapter(__package__, "load_pickup")
