"""Sweeps and tolerances of clutches: `ROOM`, as `planter.tolerance.room` has it."""

from planter.tolerance.machine_room import FileRoom

ROOM = FileRoom(__package__)
