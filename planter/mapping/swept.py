"""Sweeps and tolerances of linkages and gear trains of poses: `ADAPTER`, as
`planter.tolerance.adapter` has it.
"""

from planter.tolerance.adapter import FileAdapter

ADAPTER = FileAdapter(__package__, "load_poses")
