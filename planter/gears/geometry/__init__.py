"""Pitch curves of non-circular gears: families, stages, sizes."""
