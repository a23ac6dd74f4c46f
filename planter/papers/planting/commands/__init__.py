"""Commands of the planting device."""

from planter.papers.planting.commands import design

app = design.app
