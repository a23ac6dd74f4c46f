"""What other programs take: units for co-simulation, tables over time for multibody programs and
Simulink.
"""
