"""Reference pages by task: stating a mechanism, formulas and papers, running a generated mechanism."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from pkgutil import resolve_name

import derive

MECHANISM = """\
# Stating a mechanism

Words of `derive` for a mechanism of your own; [an example](../examples/slider_crank.py) uses most of them. Quantities
are in SI and radians. A joint acts on the body `on`, and its reverse on the body `by`. `m.equations()` returns every
balance with the sign of each force.
"""
PAPERS = """\
# Formulas and papers

Words of `derive` for equations without bodies, and for equations as a paper prints them;
[a paper on the slider-crank](../gallery/own_paper.md) shows verdicts.
"""
RUNNING = """\
# Running a mechanism

`planter derive FILE.py` writes functions and a file of values; these classes of `planter` run them. `Model` is for a
mechanism that an angle drives, `Dynamics` for one that moves freely.
"""


@dataclass(frozen=True)
class Page:
    """A page: its head, and the names of each section."""

    head: str
    sections: dict[str, str]


M = "derive.Mechanism"
PAGES = {
    "mechanism": Page(
        MECHANISM,
        {
            "Mechanism": "derive.Mechanism .time",
            "Table of quantities": "derive.quantities derive.Quantities derive.Quantity",
            "Tables from CSV files as functions": "derive.read_table",
            "Frames and points": ".frame .point .vector .position .velocity .rate derive.displacement derive.unit "
            "derive.zero derive.Frame derive.Point derive.Vec derive.Motion derive.FrameError",
            "Coordinates": ".coordinate .follow",
            "Bodies": ".body .bodies derive.Body derive.Part derive.about_pin",
            "Joints": ".pin .weld .slide .ball .universal .cylinder .plane .wheel",
            "Forces": (
                ".force .torque .spring .strut .bushing .motor .actuator derive.creeping "
                "derive.dahl"
            ),
            "Contacts and teeth": ".contact .compliant_contact .impact .follower .mesh .compliant_mesh .couple "
            "derive.GearContact "
            "derive.SlidingContact derive.SharedContact derive.tangent_angle derive.Impact "
            "derive.ImpactLaw",
            "Gears that are not round": (
                "derive.gear_pair derive.read_gear_pair derive.RollingPair derive.GearTable"
            ),
            "Closed loops": ".close .parallel .constrain",
            "Free motion": ".free_frame .begin .input .roll .accelerations",
            "Release of a driven mechanism": "derive.ReleasedMechanism derive.Release derive.ElasticTeeth "
            "derive.LoosePin derive.LiftingFollower derive.FrameMount",
            "Results": ".name_ .let .report .system .equations .balance .named .unknowns",
            "Pitch curves and cam laws chosen at run time": (
                ".stage .flank derive.GearStage derive.FollowerLaw"
            ),
            "Named places and equal sides": (
                ".name_place .name_acceleration .hang .mirror_place .twin_lane derive.Sides"
            ),
        },
    ),
    "papers": Page(
        PAPERS,
        {
            "Formulas": "derive.Formulas derive.Formulas.defines derive.Formulas.holds derive.Formulas.expr "
            "derive.Formulas.steps derive.Formulas.function derive.Formulas.followed "
            "derive.Formulas.mesh "
            "derive.Formulas.system",
            "Papers": "derive.Paper derive.Paper.equation derive.Paper.defines derive.Paper.inequality "
            "derive.Paper.symbol "
            "derive.Paper.reads derive.Paper.admits derive.Paper.rebuilds derive.Paper.shows "
            "derive.Paper.refers "
            "derive.Paper.rank",
            "Claims and verdicts": (
                "derive.what derive.loop derive.Balance derive.Equation derive.trial"
            ),
        },
    ),
    "running": Page(
        RUNNING,
        {
            "Along an angle": "planter.load_machine planter.mechanism.model.Model",
            "Free motion": "planter.mechanism.file.load planter.mechanism.dynamics.Dynamics "
            "planter.mechanism.dynamics.MotionRun planter.mechanism.dynamics.Equations "
            "planter.mechanism.ensemble.compute_ensemble planter.mechanism.ensemble.EnsembleSpec "
            "planter.mechanism.ensemble.MechanismEnsemble",
        },
    ),
}
"""Names that begin with a dot are those of `derive.Mechanism`."""
SPLIT = (derive.Mechanism, derive.Formulas, derive.Paper)
"""Classes whose members have entries of their own."""
UNLISTED = {
    "anchor",
    "axes",
    "chosen",
    "common",
    "component_axes",
    "data",
    "defined",
    "list_centroids",
    "name_accelerations",
    "name_supports",
    "pin_of",
    "refuse_shared_names",
    "support_forces",
    "told_in",
    "world_components",
}
"""Members of `derive.Mechanism` for derivations, which no statement needs."""


def names(page: str) -> list[str]:
    """Return the full names on a page, in their order."""
    entries = " ".join(PAGES[page].sections.values()).split()
    return [complete(entry) for entry in entries]


def complete(entry: str) -> str:
    """Return the full name of an entry."""
    return M + entry if entry.startswith(".") else entry


def directive(name: str) -> Iterator[str]:
    """Yield the lines by which Sphinx shows a name."""
    item = resolve_name(name)
    parent = resolve_name(name.rpartition(".")[0])
    if isinstance(item, property):
        kind = "autoproperty"
    elif inspect.isclass(item):
        kind = "autoclass"
    elif inspect.isclass(parent):
        kind = "automethod"
    else:
        kind = "autofunction" if callable(item) else "autodata"
    yield f".. {kind}:: {name}"
    if kind == "autodata":
        yield "   :no-value:"
    if (
        kind == "autoclass"
        and item not in (*SPLIT, derive.Quantity)
        and not issubclass(item, Exception)
    ):
        yield "   :members:"
        yield "   :special-members: __call__"
    yield ""


def page(name: str) -> str:
    """Return a page."""
    text = [PAGES[name].head]
    for title, entries in PAGES[name].sections.items():
        text += [f"## {title}", "", "```{eval-rst}"]
        for entry in entries.split():
            text += directive(complete(entry))
        text += ["```", ""]
    return "\n".join(text)
