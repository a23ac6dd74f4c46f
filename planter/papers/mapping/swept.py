"""Sweeps and tolerances of linkages and gear trains of poses: `ADAPTER`, as
`planter.rows.tolerance.adapter` has it.
"""

from planter.rows.tolerance.adapter import FileAdapter

ADAPTER = FileAdapter(__package__, "load_poses")
