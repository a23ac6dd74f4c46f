"""Incomplete gears: teeth on part of the turn, and locking arcs on the rest."""
