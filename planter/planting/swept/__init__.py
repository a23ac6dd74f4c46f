"""Sweeps of planting devices: turns of many designs and many machines, and what is measured of each."""

from planter.planting.swept.room import ROOM

__all__ = ["ROOM"]
