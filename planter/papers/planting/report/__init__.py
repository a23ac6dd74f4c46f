"""Figures and scene of a planting device: page, figures, files."""
