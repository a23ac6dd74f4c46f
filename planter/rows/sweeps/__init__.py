"""Sweeps: many rows of outputs, computed in chunks on local cores or a cluster, and resumed after a
kill.

The adapter of each kind of machine evaluates the rows (`planter.rows.sweeps.adapter`); this package
depends on none of them.
"""
