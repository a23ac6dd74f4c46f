"""The file of a proof: all that its bounds follow from, and the check that they do.

Numbers that define what is proved, and bounds, are hexadecimal doubles. Evidence, of which any
gives true bounds, is in decimal numbers. `check_proof.py` beside this module checks the same file
in another arithmetic, without planter; its rules for what a file may state are applied here, too.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from planter.engine.proof.check_proof import (
    FORMAT,
    MEANT,
    TRIALS,
    RefusedError,
    check_form,
    compute_digest,
    list_trusted,
    state_claim,
)
from planter.engine.proof.continuation import AssemblyStart
from planter.engine.proof.enclosures import AnglePanels, ResponseProgram, list_angles
from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import CENTRE, Space
from planter.engine.proof.objective import (
    BoundedMeasure,
    Box,
    Evidence,
    ProvableObjective,
)
from planter.engine.proof.proof_results import ProofCheck
from planter.engine.proof.search import BoxNode, Incumbent, Proof, SharedObjective, prove_bound
from planter.errors import InputError
from planter.files.document import Document
from planter.kernels import Array, generated
from planter.progress import Listener
from planter.task import Means
from planter.text_files import read_json
from planter.version import __version__

LARGEST_BYTES, MOST_VALUES = 1_000_000_000, 100_000_000
"""Limits of a file."""
UNREADABLE = ValueError, LookupError, TypeError
"""What a part of another form than that of a proof raises."""


@dataclass(frozen=True)
class ProvedMachine:
    """A machine of which something is proved: `names` of the parameters with their `scales`, SI units per unit of the
    name; hashes `sources` of generated modules by name; the `source` of its machine, in a `model`
    if there are several, whose numbers are those there but for `changes`. `inputs` are numbers that
    the generated functions take besides the parameters, for who calls them without planter.
    """

    names: Sequence[str]
    scales: Sequence[float]
    sources: Mapping[str, str]
    source: str
    changes: Mapping[str, float]
    model: str = ""
    inputs: Mapping[str, Any] = field(default_factory=dict)

    def to_document(self, objective: ProvableObjective) -> dict[str, Any]:
        """Return it as a part of the file of a proof of an objective."""
        pairs = zip(objective.quantities, objective.factors, strict=True)
        quantities = [{**asdict(entry), "factor": float(factor).hex()} for entry, factor in pairs]
        machine = {"source": self.source, "model": self.model, "changes": dict(self.changes)}
        return {
            "generated": dict(self.sources),
            "machine": {**machine, "quantities": quantities, "inputs": dict(self.inputs)},
            "parameters": list(self.names),
            "scales": _write(self.scales),
        }


Rebuild = Callable[[Mapping[str, Any]], ProvableObjective]
"""A document -> the objective of the machine that it names, as generated here, for its parameters
and quantities; raises InputError if there is none.
"""


def find_changes(
    numbers: Mapping[str, float], source: str, load: Callable[[str], Document]
) -> dict[str, float]:
    """Return which numbers of a machine, by path, differ from those of its file; all if there is
    none.
    """
    try:
        base = load(source).numbers()
    except InputError:
        base = {}
    return {path: value for path, value in numbers.items() if base.get(path) != value}


def write_certificate(
    build: Callable[[], ProvableObjective],
    box: Box,
    incumbent: Incumbent,
    machine: ProvedMachine,
    seconds: float,
    listener: Listener | None,
    means: Means,
    earlier: Path | None = None,
    keep: Callable[[str], None] | None = None,
) -> tuple[Proof, str]:
    """Return the proof of the objective that `build` returns, also in workers, and the text of its
    file.

    A proof of the same in the file `earlier` is continued; the text of an interrupted one is handed
    to `keep`.
    """
    objective = build()

    def write(proof: Proof) -> str:
        return format_document(build_document(proof, objective, machine))

    root = None if earlier is None else _read_earlier_tree(earlier, objective, box, incumbent)
    save = None if keep is None else lambda proof: keep(write(proof))
    with SharedObjective(objective, build, means) as shared:
        proof = prove_bound(shared, box, incumbent, seconds, listener, root, shared.clock, save)
    return proof, write(proof)


def _read_earlier_tree(
    path: Path, objective: ProvableObjective, box: Box, incumbent: Incumbent
) -> BoxNode | None:
    """Return the tree of a file of an unfinished proof of the same, None if there is none or it is
    spoiled.
    """
    try:
        document = read_document(path)
        claim = describe_claim(objective, box, incumbent.samples)
        if compute_digest(document) != document["sha256"] or any(
            document[key] != claim[key] for key in claim
        ):
            return None
        root = read_tree(document)
    except (InputError, *UNREADABLE):
        return None
    root.inherited = objective.floor
    for node in root.list_nodes():
        for child in node.children:
            child.inherited = node.lower_bound
    return root


def describe_claim(objective: ProvableObjective, box: Box, samples: int | None) -> dict[str, Any]:
    """Return the part of a file that says what is proved."""
    claim = {
        "kind": "true" if samples is None else "sampled",
        "samples": samples,
        "response": objective.response.to_document(),
        "assembly": objective.start.to_document()
        if objective.response.rooted and objective.start is not None
        else None,
        "terms": [term.to_document() for term in objective.terms],
        "limits": [limit.to_document() for limit in objective.limits],
        "all_limits": objective.heeds_all,
        "quantities": list(objective.labels),
        "box": [_write(side) for side in box],
    }
    plain: dict[str, Any] = json.loads(json.dumps(claim))
    return plain


def build_document(
    proof: Proof, objective: ProvableObjective, machine: ProvedMachine
) -> dict[str, Any]:
    """Return a proof as JSON."""
    nodes = list(proof.root.list_nodes())
    places = {node: place for place, node in enumerate(nodes)}
    boxes = {_identify((node.lower, node.upper)): place for place, node in enumerate(nodes)}
    result = proof.result
    incumbent: dict[str, Any] = {"x": _write(proof.incumbent.x), "upper_bound": None}
    if proof.evidence is not None and proof.reached is not None:
        evidence = _write_evidence(proof.evidence, {})
        incumbent |= {"upper_bound": proof.reached.hex(), "evidence": evidence}
    document = {
        "format": FORMAT,
        "planter": __version__,
        **machine.to_document(objective),
        **describe_claim(objective, (proof.root.lower, proof.root.upper), result.samples),
        "incumbent": incumbent,
        "lower_bound": None if result.lower_bound is None else result.lower_bound.hex(),
        "nodes": [_write_node(node, places, boxes) for node in nodes],
    }
    plain: dict[str, Any] = json.loads(json.dumps(document))
    plain["trusted"] = list_trusted(plain)
    plain["statement"] = state_claim(plain)
    return {**plain, "sha256": compute_digest(plain)}


def format_document(document: Mapping[str, Any]) -> str:
    """Return the text of a proof's file, with a line for each node."""
    rest = {key: value for key, value in document.items() if key != "nodes"}
    nodes = ",\n".join(json.dumps(node) for node in document["nodes"])
    return f'{json.dumps(rest)[:-1]},\n"nodes": [\n{nodes}\n]}}\n'


def read_document(path: str | Path) -> dict[str, Any]:
    """Return the content of a proof's file. Raises InputError for a file that is none."""
    document = read_json(Path(path), LARGEST_BYTES, MOST_VALUES)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise InputError(
            f'{path}: format: this is no file of a proof ("{FORMAT}"), as `optimise --prove` '
            f"writes it"
        )
    return document


def read_tree(document: Mapping[str, Any]) -> BoxNode:
    """Return the tree of boxes of a document.

    Raises ValueError if boxes do not fit into each other.
    """
    lower, upper = (_read(side) for side in document["box"])
    period = list_angles([Fraction(document["response"]["period"])])
    entries, seen = document["nodes"], {0}
    root = BoxNode(lower, upper, -np.inf)
    waiting, boxes = [(root, 0)], dict[int, Box]()
    while waiting:
        node, place = waiting.pop()
        entry, boxes[place] = entries[place], (node.lower, node.upper)
        # infinite where no design of the box satisfies the limits
        node.bound = float.fromhex(entry["bound"]) if "bound" in entry else -np.inf
        if np.isnan(node.bound):
            raise ValueError("the bound of a box is no number")
        if "evidence" in entry:
            low, high = boxes[entry["evidence"].get("continued", place)]
            if not ((low <= node.lower) & (node.upper <= high)).all():
                raise ValueError("a box is not in the one to which roots were followed")
            domain = (low, high) if document["assembly"] else None
            node.evidence = _read_evidence(entry["evidence"], period, domain)
        node.widest = entry.get("next")
        children = entry.get("children", [])
        if any(child in seen or not 0 <= child < len(entries) for child in children):
            raise ValueError("a box is not a child of one other box")
        seen.update(children)
        if children:
            parts = node.divide(*_list_parts(node, entry))
            waiting += zip(parts, children, strict=True)
    if len(seen) != len(entries):
        raise ValueError("a box is not a part of another")
    return root


def _list_parts(node: BoxNode, entry: Mapping[str, Any]) -> list[Box]:
    """Return the boxes of the children of a node.

    Raises ValueError if they do not cover it, or its side.
    """
    if ("split" in entry) == ("sides" in entry):
        raise ValueError("a box with children is either split or has a side")
    if "split" in entry:
        k, at = entry["split"][0], float.fromhex(entry["split"][1])
        if not node.lower[k] <= at <= node.upper[k]:
            raise ValueError("a box is split outside of it")
        below, above = node.upper.copy(), node.lower.copy()
        below[k] = above[k] = at
        node.widest = k
        return [(node.lower, below), (above, node.upper)]
    lower, upper = node.lower.copy(), node.upper.copy()
    for k, side in entry["sides"]:
        lower[k] = upper[k] = {"lower": node.lower, "upper": node.upper}[side][k]
    return [(lower, upper)]


def check_document(document: Mapping[str, Any], rebuild: Rebuild | None = None) -> ProofCheck:
    """Return whether the bounds of a document follow from its programs, each computed again.

    With `rebuild`, the programs must be those of the machine that the document names.
    """
    try:
        check_form(document)
        if rebuild is not None:
            _compare_machine(document, rebuild)
        if changed := generated.find_changed(document["generated"]):
            raise RefusedError(
                f"generated: {', '.join(changed)} of this installation differs from what was proved"
            )
        result = _check(document)
        source = document["machine"]["source"]
        return replace(result, compared=[] if rebuild is None else [source])
    except RefusedError as error:
        return ProofCheck(valid=False, reason=str(error))
    except (*UNREADABLE, AttributeError, AssertionError, ArithmeticError) as error:
        reason = f"the file is incomplete or wrong: {type(error).__name__}: {error}"
        return ProofCheck(valid=False, reason=reason)


def _check(document: Mapping[str, Any]) -> ProofCheck:
    objective, root, boxes = read_objective(document), read_tree(document), 0
    _check_period(document, objective)
    root.inherited = objective.floor
    lowest = np.inf
    for place, node in enumerate(root.list_nodes()):
        if node.evidence is not None:
            _check_node(objective, node, place)
            boxes += 1
        elif node.bound > -np.inf or len(node.children) == 1:
            raise RefusedError(f"nodes[{place}] has a bound or a side, but no evidence")
        for child in node.children:
            child.inherited = node.lower_bound
        if not node.children:
            lowest = min(lowest, node.lower_bound)
    reached, x = _check_incumbent(document, objective, root)
    stated = document["lower_bound"]
    lower_bound = lowest if reached is None else min(lowest, reached)
    bound = None if stated is None else float.fromhex(stated)
    if bound is not None and not bound <= lower_bound:
        raise RefusedError("lower_bound is above the bound of a box")
    return ProofCheck(
        valid=True,
        objective=x,
        kind=document["kind"],
        lower_bound=bound,
        incumbent=reached,
        gap=None if bound is None or reached is None else reached - bound,
        boxes=boxes,
        statement=document["statement"],
        trusted=document["trusted"],
    )


def _compare_machine(document: Mapping[str, Any], rebuild: Rebuild) -> None:
    """Raise RefusedError unless the programs and the assembly are those of the machine as it is
    generated here.
    """
    source = document["machine"]["source"]
    try:
        objective = rebuild(document)
    except InputError as error:
        raise RefusedError(f"machine: {error.message}") from None
    count = document["response"]["parameters"]
    box = np.zeros((2, count))
    claim = describe_claim(objective, (box[0], box[1]), None)
    stated, response = document["response"], claim["response"]
    differing = [key for key in response if response[key] != stated[key]]
    differing += ["quantities"] if claim["quantities"] != document["quantities"] else []
    if differing:
        raise RefusedError(
            f"{', '.join(differing)} of the response differ from those of {source} as it is "
            f"generated here"
        )
    if document["assembly"] is not None:
        _compare_assembly(document["assembly"], claim["assembly"], source)


def _compare_assembly(stated: Mapping[str, Any], ours: Mapping[str, Any], source: str) -> None:
    pairs = zip(stated["roots"], ours["roots"], strict=True)
    for theirs, roots in (map(_read, pair) for pair in pairs):
        gaps = np.abs(theirs - roots)
        rests = np.abs(gaps - 2 * np.pi * np.round(gaps / (2 * np.pi)))
        if not (np.minimum(gaps, rests) <= MEANT * (1 + np.abs(roots))).all():
            raise RefusedError(f"assembly is not the one in which {source} begins its cycle")


def _check_period(document: Mapping[str, Any], objective: ProvableObjective) -> None:
    """Raise RefusedError if the quantities of the incumbent certainly differ after a period."""
    x, response = _read(document["incumbent"]["x"]), objective.response
    turns = [Fraction(k * 21, 34) % 1 * response.period for k in range(1, TRIALS + 1)]
    space, branch = Space(x, x), objective.find_branch((x, x))
    sides = []
    try:
        for way in (turns, [turn + response.period for turn in turns]):
            with np.errstate(all="ignore"):
                jets = response.enclose(space, space.constant(list_angles(way)), [branch])
            sides.append([jet.repeated(TRIALS).value[CENTRE] for jet in jets])
    except Unbounded:  # nothing can be said of the incumbent, nor is
        return
    for first, second in zip(*sides, strict=True):
        if ((first.high < second.low) | (second.high < first.low)).any():
            raise RefusedError("period: after it, the quantities of incumbent.x are others")


def _check_node(objective: ProvableObjective, node: BoxNode, place: int) -> None:
    """Raise RefusedError if the bound or the side of a box do not follow."""
    try:
        bounds = objective(node.lower, node.upper, node.evidence)
    except Unbounded as error:
        raise RefusedError(f"nodes[{place}] cannot be bounded: {error.message}") from None
    if not bounds.lower_bound >= node.bound:
        raise RefusedError(
            f"nodes[{place}].bound is {node.bound}, but only {bounds.lower_bound} follows"
        )
    if len(node.children) == 1:
        (side,) = node.children
        slopes = bounds.slopes
        is_zero = (slopes.mid == 0) & (slopes.rad == 0)  # of a parameter that no result takes
        rising, falling = (slopes.low >= 0) | is_zero, (slopes.high <= 0) | is_zero
        raised, lowered = side.lower > node.lower, side.upper < node.upper
        if bounds.may_jump or (raised & ~falling).any() or (lowered & ~rising).any():
            raise RefusedError(
                f"nodes[{place}].sides: the objective may be less elsewhere in the box"
            )


def _check_incumbent(
    document: Mapping[str, Any], objective: ProvableObjective, root: BoxNode
) -> tuple[float | None, float | None]:
    """Return the stated upper bound of the incumbent's objective, and the objective itself; None if
    not enclosed.
    """
    entry = document["incumbent"]
    if entry["upper_bound"] is None:
        return None, None
    x, stated = _read(entry["x"]), float.fromhex(entry["upper_bound"])
    if not ((root.lower <= x) & (x <= root.upper)).all():
        raise RefusedError("incumbent.x is outside of the box")
    try:
        period = list_angles([objective.response.period])
        domain = (x, x) if document["assembly"] else None
        bounds = objective(x, x, _read_evidence(entry["evidence"], period, domain))
    except Unbounded as error:
        raise RefusedError(f"incumbent cannot be bounded: {error.message}") from None
    if not bounds.reached <= stated:
        raise RefusedError(f"incumbent.upper_bound is {stated}, but only {bounds.reached} follows")
    return stated, (bounds.lower_bound + bounds.reached) / 2


def read_objective(document: Mapping[str, Any]) -> ProvableObjective:
    """Return the objective of a document whose form was checked."""
    terms, limits = (
        [BoundedMeasure.from_document(entry) for entry in document[key]]
        for key in ("terms", "limits")
    )
    assembly = document["assembly"]
    return ProvableObjective(
        ResponseProgram.from_document(document["response"]),
        terms,
        limits,
        document["samples"],
        None if assembly is None else AssemblyStart.from_document(assembly),
        heeds_all=document["all_limits"],
    )


def _write(values: Iterable[float]) -> list[str]:
    return [float(value).hex() for value in values]


def _read(values: Sequence[str]) -> Array:
    return np.array([float.fromhex(value) for value in values])


def _identify(box: Box) -> bytes:
    return b"".join(side.tobytes() for side in box)


def _write_node(
    node: BoxNode, places: Mapping[BoxNode, int], boxes: Mapping[bytes, int]
) -> dict[str, Any]:
    """Return a node as a JSON object; `places` are those of nodes, also by their boxes."""
    entry: dict[str, Any] = {}
    children = [places[child] for child in node.children]
    if node.bound > -np.inf:
        entry["bound"] = node.bound.hex()
    if len(children) == 2 and node.widest is not None:
        entry["split"] = [node.widest, float(node.children[0].upper[node.widest]).hex()]
    elif children:
        (side,) = node.children
        raised, lowered = side.lower > node.lower, side.upper < node.upper
        entry["sides"] = [
            [int(k), "upper" if raised[k] else "lower"] for k in np.flatnonzero(raised | lowered)
        ]
    elif node.widest is not None:
        entry["next"] = node.widest
    if children:
        entry["children"] = children
    if node.evidence is not None:
        entry["evidence"] = _write_evidence(node.evidence, boxes)
    return entry


def _write_evidence(evidence: Evidence, boxes: Mapping[bytes, int]) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    if boxes and evidence.domain is not None:
        entry["continued"] = boxes[_identify(evidence.domain)]
    for key, panels in (("panels", evidence.panels), ("narrow", evidence.narrow)):
        if panels is not None:
            sides = {"knots": panels.knots.tolist(), "rates": panels.rates.tolist()}
            entry[key] = {**sides, "parts": list(panels.parts)}
    if evidence.peaks is not None and evidence.rates is not None:
        entry["peaks"], entry["rates"] = evidence.peaks.tolist(), evidence.rates.tolist()
    return entry


def _read_evidence(entry: Mapping[str, Any], period: Ball, domain: Box | None) -> Evidence:
    def read(part: Mapping[str, Any], key: str) -> Array:
        return np.array(part[key], dtype=float)

    fields: dict[str, Any] = {
        key: AnglePanels(
            read(entry[key], "knots"), read(entry[key], "rates"), tuple(entry[key]["parts"]), period
        )
        for key in ("panels", "narrow")
        if key in entry
    }
    fields |= {key: read(entry, key) for key in ("peaks", "rates") if key in entry}
    return Evidence(domain, **fields)
