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
    """A paper, all of its equations stated, on trial against a mechanism or formulas: what a file offers as CASE.

    How large a term becomes is told along the turn of a mechanism that an angle drives, of any other over its own
    motion until a time [s]. Raises ClaimError for a claim of which nothing is stated.
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
