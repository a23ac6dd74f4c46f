"""Sweeps and tolerances of linkages and gear trains of poses: `ROOM`, as `planter.tolerance.adapter` has it."""

from planter.tolerance.adapter import FileAdapter

ROOM = FileAdapter(__package__, "load_poses")
