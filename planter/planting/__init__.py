"""The planting device with a two-stage non-circular planetary gear train (Wang et al. 2017)."""
