"""The planting device with a two-stage non-circular planetary gear train (Wang et al. 2017)."""

KIND = "planting"
OWN_TABLES = {"stage1", "stage2", "nozzle"}
"""Tables that no other kind of machine file has."""
