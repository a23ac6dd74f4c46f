"""Commands of the clutch."""

from planter.clutch.commands import engage, field, shape
from planter.clutch.commands.group import app

__all__ = ["app", "engage", "field", "shape"]
