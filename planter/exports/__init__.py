"""Any machine for other programs: C, units for co-simulation, tables over time."""
