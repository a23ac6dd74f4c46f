"""A paper of one's own on trial against a mechanism or formulas of one's own."""

from __future__ import annotations

from ...audit.case import Case
from ...audit.paper import Paper
from ...chain import Chain
from ...formulas import Formulas
from ...mechanics.mechanism import Mechanism
from .closed import OwnFormulas
from .driven import Driven
from .free import Free
from .own import Own
from .printed import chain

SECONDS = 1.0


def trial(stated: Mechanism | Formulas, paper: Paper, until: float = SECONDS) -> Case:
    r"""Compare all equations of a paper with a mechanism or formulas: what a file offers as CASE to `planter audit`.

    The size of a term is taken along the turn of a mechanism that an angle drives, else over free motion ``until`` a
    time [s]. Raises ClaimError for a claim to be something that the mechanism or the formulas do not state.

    >>> from derive import Formulas, Paper, quantities, trial, what
    >>> q = quantities("r | m | radius | 0.02\nd | m | diameter")
    >>> f = Formulas("disc", given=q)
    >>> f.defines(q.d, 2 * q.r)
    d
    >>> paper = Paper("invented2026", "An invented paper")
    >>> paper.defines("1", q.d, 2 * q.r, what(q.d))
    >>> trial(f, paper).paper.name
    'invented2026'
    """
    case = (
        Case(paper, OwnFormulas(stated)) if isinstance(stated, Formulas) else _of_mechanism(own(stated, until), paper)
    )
    for number, equation in paper.equations.items():
        if not equation.stands_alone:
            case.derived(number)
    return case


def _of_mechanism(subject: Own, paper: Paper) -> Case:
    subject.printed = chain(paper, subject)
    return Case(paper, subject, (subject.printed, Chain({}, [])) if subject.printed.order else None)


def own(mechanism: Mechanism, until: float = SECONDS) -> Own:
    """A mechanism as what papers are tried against."""
    lane = mechanism.system().lane
    if lane is None or mechanism.angle is None or mechanism.speed is None:
        return Free(mechanism, until)
    return Driven(mechanism, mechanism.angle, mechanism.speed, lane)
