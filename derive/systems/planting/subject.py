"""What the audit asks of the planting device."""

from .assumptions import ZERO, lift
from .claims import admissible, claims, common, reference

__all__ = ["ZERO", "admissible", "claims", "common", "lift", "reference"]
