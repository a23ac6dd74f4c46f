"""Commands of the planting device."""

from planter.planting.commands import analysis, design
from planter.terminal.options import joined

app = joined(analysis.app, design.app)
