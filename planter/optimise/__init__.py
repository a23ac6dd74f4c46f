"""Local and global optimisation with a certificate, of anything that states three things.

What is made small (`objective.Objective`), where it may lie (`box.Box`) and what has to be kept meanwhile
(`constraints.Constraints`) make a `problem.Problem`. Two kinds of objective come with it: range and spread of a
response over a turn (`range_and_spread`, by the formulas in `spread`), and a smooth function (`smooth`). `descent`
finds a local minimum from one start, by `ipopt` or `sequential`, `starts` from several, `hybrid` beside a genetic
algorithm; `certificate` judges a point without knowing a solver, `flat` chooses among equal optima and `result` says
how sure one is; `equations` takes points onto what has to hold exactly. For responses, `directions` says which
parameters matter at all, `pareto` weighs range against variance and `joints` lists where the curve is not smooth.

A machine brings its own objective, box and constraints; nothing here knows one.
"""
