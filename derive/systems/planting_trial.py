"""What the audit asks of the planting device."""

from derive.systems.planting_claims import admissible, claims, common, reference
from derive.systems.planting_lifted import ZERO, lift

__all__ = ["ZERO", "admissible", "claims", "common", "lift", "reference"]
