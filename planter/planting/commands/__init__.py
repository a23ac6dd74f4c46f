"""Commands of the planting device."""

from planter.planting.commands import cam, compare, device, drive, export, gears
from planter.terminal.options import joined

app = joined(device.app, compare.app, drive.app, export.app, cam.app, gears.app)
