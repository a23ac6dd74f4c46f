"""Sizes, names and docstrings: the committed totals may only fall."""

import pytest

from tests.support.names import Source, count_findings, find_names
from tests.support.size import find_rises, measure_repository, measure_sources, read_totals

CLEAN = '''
"""A module."""

class Beam:
    """A beam of constant section."""

    def stiffness(self):
        """Return the bending stiffness [N m2]."""

def compute_deflection(load):
    """Return the deflection [m] under a load [N]."""
    return [value for value in load]
'''


def count(*texts: str, path: str = "planter/engine/module_{}.py") -> dict[str, dict[str, float]]:
    """Totals of modules given as texts."""
    return count_findings(find_names(Source(path.format(i), text) for i, text in enumerate(texts)))


@pytest.mark.long
def test_totals_do_not_rise() -> None:
    """`make lint` checks it, too."""
    assert not find_rises(read_totals(), measure_repository())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x = [y for y in z]", {"comprehensions": 1}),
        ("x = [y for y in z], {y for y in z}", {"comprehensions": 2, "crowded": 1}),
        ("x = [[y for y in z] for z in a]", {"comprehensions": 2, "crowded": 1}),
        ("x = [b for y in z if (b := y)]", {"comprehensions": 1, "crowded": 1}),
        ("if [y for y in z]:\n    x = [y for y in z]", {"comprehensions": 2}),
        (f"x = {'x' * 100}", {"long_lines": 1}),
        ("class A:\n    'A.'\nclass _B: 'B.'", {"public_classes": 1}),
        ("'A module.'  # which is\n\n\nx = (\n    1\n)", {"tokens": 5, "tokens_per_line": 1.7}),
    ],
)
def test_sizes_are_measured(text: str, expected: dict[str, float]) -> None:
    totals = measure_sources([Source("planter/module.py", text)])["planter"]
    assert totals | expected == totals
    assert totals["crowded"] == expected.get("crowded", 0)


def test_clean_module_has_no_findings() -> None:
    assert count(CLEAN) == {}


@pytest.mark.parametrize(
    ("before", "after", "check"),
    [
        ("value for value in", "one for one in", "vague"),
        ("(load)", "(given)", "vague"),
        ("def stiffness", "def _of", "vague"),
        ("return [", "import ast as found; return [", "vague"),
        ("return [", "load.told = 1; return [", "vague"),
        ("return [", "with open(load) as (a, held): pass\n    return [", "vague"),
        ("return [", "try: pass\n    except ValueError as what: pass\n    return [", "vague"),
        ("return [", "match load:\n        case [*others]: pass\n    return [", "vague"),
        ("return [", "(whole := 1)\n    return [", "vague"),
        ("return [", "compute_deflection = 1; return [", "shadow"),
        ("compute_deflection", "compute", "one_word"),
        ('"""A beam of constant section."""', "", "undocumented"),
        ('"""Return the bending stiffness [N m2]."""', "pass", "undocumented"),
        ("A beam of constant section.", "Of constant section.", "fragment"),
    ],
)
def test_tampered_module_has_a_single_finding(before: str, after: str, check: str) -> None:
    assert before in CLEAN
    assert count(CLEAN.replace(before, after, 1)) == {"planter.engine": {check: 1}}


def test_classes_of_equal_names_are_all_counted() -> None:
    assert count(CLEAN, CLEAN) == {"planter.engine": {"duplicate": 2}}
    assert count(CLEAN, CLEAN, path="tests/module_{}.py") == {}


def test_rise_is_not_offset_by_another_package() -> None:
    before = {"planter.engine": {"vague": 2}, "planter.report": {"vague": 5}}
    assert find_rises(before, {"planter.engine": {"vague": 3}, "planter.report": {"vague": 1}}) == {
        "planter.engine vague": (2, 3)
    }
    assert find_rises(before, {"planter.new": {"one_word": 1}}) == {"planter.new one_word": (0, 1)}
    assert not find_rises(before, before)
