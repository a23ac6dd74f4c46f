"""What a designer reads off a turn: torques, peaks of forces, gears with their stresses, and shocks.

`quantities` says which functions of the carrier angle count, `summary` looks at them over the turn.
"""
