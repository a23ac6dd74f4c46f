"""Commands of the planting device."""

from planter.planting.commands import design

app = design.app
