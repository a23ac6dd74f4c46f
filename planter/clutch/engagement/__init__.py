"""Engagement and cut-off of the clutch: the one-mode beam of the paper, and contact of the real profiles."""
