"""Commands of the planting device."""

from planter.planting.commands import analysis, design
from planter.terminal.options import join_applications

app = join_applications(analysis.app, design.app)
