"""Made-up quantities, and points at which they have values, to judge small equations with."""

import random
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import sympy as sp

from derive.audit.case import Case
from derive.audit.judge import Judgement, judge_equation
from derive.audit.paper import Subject
from derive.audit.reading_search import Outcome, judge_linked_readings
from derive.audit.record import Record, record_equations
from derive.audit.texts.trial import read_trial
from derive.equations import Claimed, Equation, Relation
from derive.evaluate import Point
from derive.quantity import Quantity


def quantity(name: str, unit: str = "m") -> Quantity:
    return Quantity(name, unit, "made up", "test")


a, b, c, d, e = (quantity(f"test_{n}") for n in "abcde")
u, v, t = quantity("test_u", "1"), quantity("test_v", "1"), quantity("test_t", "s")
x, x_dot = quantity("testx"), quantity("testx_dot", "m/s")
WORDS = [a, b, c, d, e, u, v, t, x, x_dot]


def values(seed: int) -> dict[Quantity, sp.Rational]:
    rng = random.Random(seed)
    return {s: sp.Rational(rng.randint(10**9, 10**10), 10**10) for s in WORDS}


class MadeUpClaim:
    """What may be claimed of made-up quantities."""

    SUM = "made-up sum"
    SHARE = "made-up share {}"
    NOWHERE = "made-up sum that nothing derives"


@dataclass(frozen=True)
class MadeUp(Subject):
    """A subject of made-up equations; ``lifted`` is the derivation of all without the assumption of
    ``zeros``.
    """

    equations: Mapping[Claimed, Equation]
    lifted: sp.Expr | None = None
    zeros: Mapping[sp.Symbol, str] = field(default_factory=dict)

    def claims(self) -> Mapping[Claimed, Equation]:
        return self.equations

    def admissible(self, rng: random.Random) -> dict[Quantity, sp.Rational]:
        return values(rng.randint(1, 99))

    def reference(self, points: int) -> list[dict[Quantity, sp.Rational]]:
        return [values(seed) for seed in range(points)]

    def zero(self) -> Mapping[sp.Symbol, str]:
        return self.zeros

    def lift(self, claim: Claimed, printed: sp.Expr) -> sp.Expr | None:
        return self.lifted


def tampered(subject: Subject, **parts: Any) -> Subject:
    """The same subject with other methods."""
    changed: Subject = type("Tampered", (type(subject),), parts)()
    return changed


def judge_readings(case: Case, number: str) -> Outcome:
    """Return an equation's outcome under the kindest joint reading of all that it is linked with."""
    return judge_linked_readings(case, number)[number]


def judge_number(case: Case, number: str) -> Judgement:
    """Return the judgement on an equation under its kindest reading."""
    return judge_readings(case, number).kindest.judgement


def list_verdicts(outcome: Outcome) -> list[str]:
    """List the verdicts under all readings."""
    return [hearing.judgement.verdict for hearing in outcome.alternatives]


def record_equation(case: Case, number: str) -> Record:
    """Return the record of an equation of a paper."""
    return record_equations(case, [number], "key")[0]


def read_text(
    folder: Path, mechanism: str, text: str, names: str | None = None, suffix: str = ".tex"
) -> Case:
    """Return the case of a text compared with a mechanism, from files in a folder."""
    files = {"stated.py": mechanism, f"text{suffix}": text, "names.toml": names}
    for name, content in files.items():
        if content is not None:
            (folder / name).write_text(content, encoding="utf-8")
    meanings = None if names is None else folder / "names.toml"
    return read_trial(folder / f"text{suffix}", folder / "stated.py", meanings)


def record_all(case: Case) -> list[Record]:
    """Return the records of all equations of a paper."""
    return [record_equation(case, number) for number in case.paper.equations]


POINTS = [Point(values(seed)) for seed in (1, 2, 3)]


def judged(
    printed: sp.Expr,
    derived: sp.Expr,
    relations: tuple[Relation, Relation] = ("=", "="),
    defines: Quantity | None = None,
) -> Judgement:
    """The judgement on two residuals, or on what two formulas say that a symbol is."""
    first, second = (
        Equation(
            "n",
            r if defines is None else defines - r,
            "test",
            MadeUpClaim.SUM,
            defines=defines,
            relation=k,
        )
        for r, k in zip((printed, derived), relations, strict=True)
    )
    return judge_equation(first, second, POINTS, WORDS)
