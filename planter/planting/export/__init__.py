"""A planting device as source text to compile elsewhere."""
