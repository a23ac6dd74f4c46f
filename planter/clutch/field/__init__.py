"""Field tests by orthogonal designs: their plans, their evaluation, and the comparison of clutches.

A field test is a CSV file: lines that start with `#`, a header, then one row per run. The header
says what a column is:

* `run` counts the runs and may be left out; a number that is left out in between is a missing run,
  and one that occurs in several rows of the same levels is a repetition;
* `blank`, `empty` or `error`, with a number behind it or without, is a column of the array that no
  factor is assigned to; its effect belongs to the error. `--blank NAME` names others;
* `Y`, `y`, or one of them followed by anything but a letter (`Y1`, `Y2_cm`), is a response.
  `--response NAME` names the responses instead, and then no other column is one;
* `--ignore NAME` leaves a column out;
* every other column is a factor. Its levels are all numbers, in increasing order, or all words, in
  the order in which they come.

Two kinds of comment, above the header, carry what a column means into figures and report. The
values of a factor are those of its levels in their order; where its levels are words they must be
the levels themselves, and fix their order:

    # factor A: axial angle / deg = 10, 15, 20
    # response Y1: lag at engagement / cm

What is computed, for any design in which all main effects can be estimated:

* analysis of variance of main effects. The error is what they leave: blank columns, unassigned
  columns, repetitions. In an orthogonal design all types of sums of squares agree. In any other
  they are of type II: each factor over all others, which without interactions is type III too; they
  do not add up to the total. A design without degrees of freedom left for the error has no F and no
  p;
* range analysis, only where every level of a factor occurs equally often with every level of any
  other, for else the means of the levels carry effects of other factors;
* the additive prediction for every combination of levels, and which of them is best: by the goal of
  each response, and by the mean of its ranks over all responses.

The user states the goal of a response: `--goal Y1=larger`, `smaller`, `zero`, or a number for a
target value. The paper's own responses are lags, and there zero is the default; any other table
needs a goal for each response.

The comparison needs means, standard deviations and numbers of measurements, which a table of runs
does not hold: a second CSV file (`--comparison FILE`) with the header
`clutch,speed_m_s,measure,mean,sd,n`. The clutch that it names first is compared with the one that
it names next, by Welch's test of the difference of means; all other pairs follow apart. Without
such a file there is no comparison; the paper's own comes with the paper's own runs.

Sources: Montgomery, Design and Analysis of Experiments, chapters 3 and 8 (analysis of variance,
fractional designs); Welch, Biometrika 34 (1947) 28; Holm, Scandinavian Journal of Statistics 6
(1979) 65; Shi et al. 2021, section 4.
"""

from planter.clutch.field.evaluation import (
    NEAREST_ZERO,
    FieldEvaluation,
    ResponseGoal,
    evaluate_field,
)
from planter.clutch.field.trial import Factor, FieldColumns, FieldResponse, Trial

__all__ = [
    "NEAREST_ZERO",
    "Factor",
    "FieldColumns",
    "FieldEvaluation",
    "FieldResponse",
    "ResponseGoal",
    "Trial",
    "evaluate_field",
]
