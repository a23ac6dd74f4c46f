"""What a machine's tolerances do to its turn: Monte Carlo, Sobol' indices, first-order bands, robust designs.

Which inputs a machine has and how they act, its room says (`planter.sweeps.room`); this one knows no machine.
"""
