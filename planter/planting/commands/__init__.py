"""Commands of the planting device."""

from planter.planting.commands import analysis, calibrate, design
from planter.terminal.options import joined

app = joined(analysis.app, calibrate.app, design.app)
