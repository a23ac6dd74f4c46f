"""Any machine for other programs: C, CUDA, units for co-simulation, tables over time."""
