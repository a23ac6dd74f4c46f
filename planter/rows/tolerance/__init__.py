"""Effect of tolerances on a cycle: Monte Carlo, Sobol' indices, first-order bands, robust designs.

The adapter of each kind of machine evaluates it (`planter.rows.tolerance.adapter`); this package depends
on none of them.
"""
