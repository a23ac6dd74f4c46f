"""Sweeps and tolerances of linkages and gear trains of poses: `ROOM`, as `planter.tolerance.room` has it."""

from planter.tolerance.room import FileRoom

ROOM = FileRoom(__package__, "load_poses")
