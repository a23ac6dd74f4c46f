"""Commands of the planting device."""

from planter.planting.commands import calibrate, cam, compare, device, drive
from planter.terminal.options import joined

app = joined(device.app, calibrate.app, compare.app, drive.app, cam.app)
