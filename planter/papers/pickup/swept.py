"""Adapter of pick-ups for sweeps and tolerances (`planter.rows.adapter`)."""

from planter.rows.adapter import MachineAdapter

ADAPTER = MachineAdapter(__package__, "load_pickup")
