"""No determinant or solution of a linear system by expansion or without pivots, held over the
syntax.
"""

import ast
from collections.abc import Iterator

import pytest

from derive.emit.targets import array, casadi
from tests.support.structure import ROOT

GRAPHS = {
    "det",
    "solve",
    "inv",
    "inv_minor",
    "adj",
    "minor",
    "cofactor",
    "pinv",
    "mldivide",
    "mrdivide",
    "qr",
}
"""Functions of CasADi that expand minors of a graph, or solve by Gram-Schmidt without pivots."""
SYMBOLS = {"det", "inv", "LUsolve", "cramer_solve", "adjugate", "cofactor", "minor"}
"""Methods of SymPy's matrices whose results grow without bounds."""
NUMBERS = ("np.linalg", "scipy.linalg")
ALLOWED = {
    "derive/systems/clutch/geometry.py": "a conic, 3 x 3",
    "derive/systems/clutch/rotor.py": "two vectors in a plane",
    "derive/systems/user_mechanism/subject.py": "two simultaneous equations at most",
    "derive/mechanics/free_motion.py": "accelerations in symbols, which somebody asks for",
    "planter/optimise/proof/check_proof.py": "numbers with error bounds",
}
"""Modules with small matrices of symbols, or of numbers."""


def list_expansions(source: str) -> Iterator[str]:
    """Calls of such functions and methods, and imports of them, as text."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module == "casadi":
            yield from (alias.name for alias in node.names if alias.name in GRAPHS)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            receiver = ast.unparse(node.func.value)
            forbidden = GRAPHS if receiver in ("ca", "casadi") else SYMBOLS
            if node.func.attr in forbidden and receiver not in NUMBERS:
                yield ast.unparse(node.func)


def test_no_module_expands_determinants() -> None:
    modules = {
        path.relative_to(ROOT).as_posix()
        for package in ("planter", "derive", "generated")
        for path in (ROOT / package).rglob("*.py")
        if list(list_expansions(path.read_text(encoding="utf-8")))
    }
    assert modules == ALLOWED.keys()


@pytest.mark.parametrize("text", [array.SOLVER, casadi.SOLVER])
def test_generated_elimination_expands_nothing(text: str) -> None:
    assert not list(list_expansions(text))


@pytest.mark.parametrize(
    "text",
    [
        "ca.det(jacobian)",
        "-ca.solve(a, b)",
        "from casadi import det",
        "casadi.inv(m)",
        "matrix.det()",
    ],
)
def test_an_expansion_is_noticed(text: str) -> None:
    assert list(list_expansions(text))


@pytest.mark.parametrize(
    "text", ["np.linalg.solve(a, b)", "recorder.solve(x)", "solve_system(a, b).solution"]
)
def test_numbers_may_be_solved(text: str) -> None:
    assert not list(list_expansions(text))
