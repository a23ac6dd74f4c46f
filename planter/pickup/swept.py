"""Adapter of pick-ups for sweeps and tolerances (`planter.tolerance.room`)."""

from planter.tolerance.room import FileRoom

ROOM = FileRoom(__package__, "load_pickup")
