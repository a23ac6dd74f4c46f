"""Mechanics is derived, not typed: what can be held of that over the sources of the numeric
layer.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from planter import plugins
from planter.kernels import generated
from tests.support.structure import ROOT

ANGLES = {
    "cos",
    "sin",
    "tan",
    "acos",
    "asin",
    "atan",
    "atan2",
    "arccos",
    "arcsin",
    "arctan",
    "arctan2",
}
"""Functions that turn angles into components and back."""
DRAWN = ("report", "scene", "figures")
"""Folders and modules of figures and scenes, which draw."""
READ = "printed"
"""Folders of what papers print, computed anew in their own terms."""
BY_HAND = {
    "clutch/contact_simulation.py": "where a search starts",
    "clutch/geometry.py": "direction of a line through two generated points",
    "clutch/machines.py": (
        "lift of the link along the crank's angle, compared with the generated model in its test"
    ),
    "clutch/rotor.py": (
        "normals of a polygon's sides in a linear programme; the outline that is drawn"
    ),
    "gear_geometry/trimming.py": "points and directions on circles",
    "gear_geometry/pitch_curves.py": "how steep a curve of a table is, to refuse it",
    "mapping/dyads.py": "poses as points of a linear system, directions to search in",
    "mapping/linkage.py": "roots of the generated closed loop, intervals between them",
    "mapping/machines.py": (
        "the closed-form loop of a linkage, compared with the synthesis in its test"
    ),
    "mapping/model.py": "angle of a generated vector",
    "mapping/nearest.py": "angles of given poses",
    "mapping/synthesis.py": "angles of given poses",
    "pickup/file.py": "whether a law that a user hands in goes forward",
    "pickup/inverse.py": "directions of given points",
    "pickup/law.py": "a law of motion that a user chooses, between its joints",
    "planting/proof.py": "sines of enclosures, of the series that is generated",
    "planting/toothed.py": "directions of generated points",
    "planting/labelled.py": "directions and arcs of a drawing",
    "planting/lifted.py": (
        "how far from the pitch point teeth are let touch, an input of the lifted model"
    ),
    "planting/browser_programs.py": (
        "points of a generated outline as the planet holds them, for a drawing"
    ),
}
"""Modules of machines that call them, and what for; forces, contacts and rotations of gears are not
among it.
"""


def called(text: str) -> Iterator[str]:
    """Functions of angles that a source calls, whatever library they are of."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call):
            name = (
                node.func.attr
                if isinstance(node.func, ast.Attribute)
                else getattr(node.func, "id", "")
            )
            if name in ANGLES:
                yield name


def modules() -> Iterator[tuple[str, Path]]:
    """Sources of the machines' rooms and of the gears, by their place in the package; what draws or
    reads is left.
    """
    for room in (*sorted(plugins.find_folders("examples")), "gear_geometry"):
        for path in sorted((ROOT / "planter" / room).rglob("*.py")):
            if not {*DRAWN, READ} & set(path.relative_to(ROOT / "planter").with_suffix("").parts):
                yield path.relative_to(ROOT / "planter").as_posix(), path


def test_angle_components_by_hand_have_reasons() -> None:
    assert {
        name for name, path in modules() if set(called(path.read_text(encoding="utf-8")))
    } == BY_HAND.keys()


@pytest.mark.parametrize("text", ["ca.cos(x)", "math.atan2(y, x)", "from numpy import sin\nsin(1)"])
def test_a_formula_by_hand_is_noticed(text: str) -> None:
    assert set(called(text))


def test_names_alone_do_not_count() -> None:
    assert not set(called('found["cos"]\n"sin(x)"\ncosine(2)\n'))


@pytest.mark.parametrize("constant", ["9.81", "9.80665"])
def test_weight_is_not_typed(constant: str) -> None:
    assert not [name for name, path in modules() if constant in path.read_text(encoding="utf-8")]


def test_every_generated_model_is_used() -> None:
    """Of a machine or of the gears; what nobody calls would be derived for nothing."""
    text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "planter").rglob("*.py"))
    complete = {
        name
        for name in generated.names()
        if f'"{name}"' not in text and not name.startswith("curve_")
    }
    composed = {name for name in complete if 'f"' + name.rpartition("_")[0] + "_{" in text}
    composed |= {name for name in complete if f'"{name.partition("_")[0]}_"' in text}
    assert complete - composed - {"audit", "audit_mathml"} == set()
