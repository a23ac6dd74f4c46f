"""What a system states for the trial of papers: its derivation, points to decide at, the laws of its motion."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import sympy as sp
from sympy import Expr

from ..equations import Claimed, Equation
from ..model import System
from .laws import Dynamics


class Subject(Protocol):
    """A system that papers are tried against.

    Asked for are the derived equations and values of their quantities; the rest has a default for who inherits.
    """

    def claims(self) -> Mapping[Claimed, Equation]:
        """Derived equations by what they claim to be."""
        ...

    def admissible(self, rng: random.Random) -> Mapping[Any, Any]:
        """Random values of all quantities, consistent with each other; by the seed, both cases of every branch."""
        ...

    def reference(self, points: int) -> Sequence[Mapping[Any, Any]]:
        """Values of all quantities along the machine's own cycle, to tell how large a term becomes."""
        ...

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Any, Any]] | None:
        """Values of all quantities, consistent with each other, near those of ``reference``: data changed a little.

        None where the subject finds none; every quantity of the reference is then moved a little by itself.
        """
        return None

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """Two sums, a printed and a derived one, in the same quantities."""
        return printed, derived

    def footings(self, printed: Expr, derived: Expr) -> Sequence[tuple[Expr, Expr]]:
        """Both sums in more and more of the same quantities: from the balance's own to those of ``common``."""
        return [self.common(printed, derived)]

    def folds(self) -> Mapping[sp.Symbol, Expr]:
        """Quantities that a balance holds as differences: each with what is taken from it."""
        return {}

    def actions(self) -> Mapping[sp.Symbol, str]:
        """What forces and moments between bodies are called. Symbols themselves cannot be asked: two of one name are
        one to SymPy, whatever either says that it means."""
        return {}

    def held(self, claim: Claimed, said: Expr) -> Mapping[str, Expr]:
        """What must vanish of the thing that a claim is about, by what ``said`` says that it is: where it is held."""
        return {}

    def zero(self) -> Mapping[sp.Symbol, str]:
        """Quantities that an assumption makes vanish, each with the reason."""
        return {}

    def lift(self, claim: Claimed, printed: Expr) -> Expr | None:
        """The derived residual of a claim while the quantities of ``zero`` are not, in those of the printed one.

        None for a claim that no assumption bears on.
        """
        return None

    def dynamics(self) -> Dynamics | None:
        """Laws that a chain of equations must obey as a whole, and the motion to test it in; None without any."""
        return None

    def model(self) -> System | None:
        """What computes the numbers of a paper anew; None where nothing derived here does."""
        return None

    def files(self) -> Iterable[Path]:
        """Files that the dynamics depend on beside the modules that the subject's own one imports."""
        return ()
