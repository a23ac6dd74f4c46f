"""Gears that have teeth on part of their turn, and locking arcs that hold them over the rest."""
