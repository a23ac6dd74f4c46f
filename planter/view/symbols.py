"""Names of symbols as they are set in a drawing."""

from __future__ import annotations

import re
from collections.abc import Sequence

from planter.files import units

GREEK = (
    "alpha", "beta", "gamma", "delta", "epsilon", "theta", "lambda", "mu", "nu", "xi", "rho", "sigma", "tau", "phi",
    "psi", "omega", "Delta", "Theta", "Phi", "Psi", "Omega",
)  # fmt: skip
_NAME = re.compile(rf"({'|'.join(GREEK)}|[A-Za-z])_?(\d*|(?<=_).+)$")
_SHAPES = {"phi": "varphi", "epsilon": "varepsilon"}


def set_name(name: str) -> str:
    """A name for matplotlib's mathtext: a letter with its index, without a unit, or a word as it stands.

    >>> set_name("phi52"), set_name("x_A1"), set_name("circumradius"), set_name("x_tip_machine")
    ('$\\\\varphi_{52}$', '$x_{A1}$', 'circumradius', '$x_{tip,machine}$')
    >>> set_name("phi_deg"), set_name("cell_top_mm")
    ('$\\\\varphi$', 'cell_top_mm')
    """
    found = _NAME.match(name.removesuffix(units.suffix(name)))
    if found is None:
        return name
    letter, index = found.groups()
    base = f"\\{_SHAPES.get(letter, letter)}" if letter in GREEK else letter
    return f"${base}_{{{index.replace('_', ',')}}}$" if index else f"${base}$"


def set_names(names: Sequence[str]) -> str:
    """Several in a row, each once."""
    return ", ".join(dict.fromkeys(map(set_name, names)))
