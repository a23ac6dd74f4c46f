"""The seedling pick-up: from the path of its needle to its gears, and back (Yu et al. 2023)."""
