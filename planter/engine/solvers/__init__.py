"""Local and global optimisation of any design problem, with a certificate of optimality.

An objective (`objective`), a box and constraints (`constraints`) make a `problem.Problem`. Two
kinds of objective are provided: sums over curves of a cycle (`joined`), and
a smooth function (`expressions`). `local_search` finds local minima from one or several starts,
by `ipopt` or `sqp`; `optimiser` adds a genetic algorithm. `certificate` checks the optimality of a
point without a solver, `result` selects among equal optima, `pareto` trades range against variance,
and `proof` bounds the objective from below. The package does not depend on machines.
"""
