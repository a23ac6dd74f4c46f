"""A planting device as programs: what a page needs to compute it without Python."""
