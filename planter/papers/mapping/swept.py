"""Sweeps and tolerances of linkages and gear trains of poses: `ADAPTER`, as
`planter.rows.adapter` has it.
"""

from planter.rows.adapter import MachineAdapter

ADAPTER = MachineAdapter(__package__, "load_poses")
