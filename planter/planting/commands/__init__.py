"""Commands of the planting device."""

from planter.planting.commands import compare, device, export
from planter.terminal.options import joined

app = joined(device.app, compare.app, export.app)
