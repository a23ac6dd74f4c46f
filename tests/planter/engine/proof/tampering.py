"""Proofs with one thing in them changed: fields, numbers, signs, kinds; statement and hash are
those of the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import partial, reduce
from operator import getitem
from typing import Any

from planter.engine.proof.certificate_file import compute_digest
from planter.engine.proof.check_proof import MEASURES, list_trusted, state_claim

Document = dict[str, Any]
Changes = Iterator[tuple[str, Callable[[Document], None]]]
"""What is changed, and the change."""
NOT_FINITE = ("nan", "-nan", "-inf", "inf", float("nan"), float("inf"), "0x1p99999")
WRONG: tuple[Any, ...] = (None, [], {}, "", "x", -1, 0.5, True)
"""Values that are put for a whole part."""
OTHER = {"sin": "cos", "cos": "sin", "multiply": "add", "add": "multiply", "negate": "not"}
"""Operations that are put for others."""


def renew(document: Document) -> Document:
    """Return a document with the statement and the hash that its parts have, as who tampers with it
    would write.
    """
    try:
        document["trusted"] = list_trusted(document)
        document["statement"] = state_claim(document)
    except Exception:  # there is no statement of what is spoiled
        document["statement"] = "proved"
    document["sha256"] = compute_digest(document)
    return document


def list_tampered(document: Document) -> Iterator[tuple[str, Document]]:
    """Yield what was changed, and the changed document."""
    lists = _spoil_keys, _change_numbers, _change_measures, _change_programs, _change_boxes
    for change in (*lists, _change_trees, _change_assembly):
        for name, tamper in change(document):
            tampered = deepcopy(document)
            tamper(tampered)
            yield name, renew(tampered)
    first, *rest = document["trusted"]
    for key, values in (
        ("statement", ("no design is better", document["statement"] + " ", None)),
        ("trusted", ([], rest, [*rest, first], [first + " ", *rest], None)),
    ):
        for value in values:
            tampered = deepcopy(document) | {key: value}
            yield key, tampered | {"sha256": compute_digest(tampered)}
    yield "sha256", deepcopy(document) | {"sha256": "0"}


def _put(path: tuple[Any, ...], *values: Any) -> Changes:
    """Yield the exchange of what stands at a path for each of some values."""
    for value in values:
        yield f"{'.'.join(map(str, path))} = {value!r}", partial(_set, path, value)


def _set(path: tuple[Any, ...], value: Any, document: Document) -> None:
    *way, last = path
    reduce(getitem, way, document)[last] = value  # type: ignore[index]


def _pop(*path: Any) -> Changes:
    """Yield the loss of what stands at a path."""
    *way, last = path
    yield f"without {path}", lambda document: reduce(getitem, way, document).pop(last)  # type: ignore[attr-defined]


def _append(key: str, *values: Any) -> Changes:
    for value in values:
        yield f"another of {key}", lambda document, value=value: document[key].append(value)  # type: ignore[misc]


def _list_kinds(document: Document) -> list[tuple[int, Document]]:
    """Return the first node of each set of keys with its place."""
    first: dict[frozenset[str], int] = {}
    for place, node in enumerate(document["nodes"]):
        first.setdefault(frozenset(node), place)
    return [(place, document["nodes"][place]) for place in first.values()]


def _spoil_keys(document: Document) -> Changes:
    """Every key left out, or with something of another kind; one key more."""
    yield from _put(("another",), 1)
    yield from _put(("kind",), {"true": "sampled", "sampled": "true"}[document["kind"]])
    for key in document.keys() - {"sha256", "statement", "trusted"}:
        yield from _pop(key)
        for value in WRONG:
            is_version = key == "planter" and isinstance(value, str)  # any text names one
            is_weaker = key == "lower_bound" and value is None
            if document[key] != value and not is_version and not is_weaker:
                yield from _put((key,), value)
    for key in document["response"]:
        yield from _pop("response", key)
        yield from _put(("response", key), None, [], "", -1, "x")
    (module, *_) = document["generated"]
    yield from _pop("generated", module)
    yield from _put(("generated", module), "", "0" * 63, "g" * 64, "0" * 65, None, 0)
    yield from _pop("quantities", 0)
    yield from _pop("parameters", -1)
    yield from _put(("parameters", 0), *document["parameters"][1:2], "", 1)


def _change_numbers(document: Document) -> Changes:
    """Numbers that are none or infinite, wherever a number stands."""
    places: list[tuple[Any, ...]] = [
        ("lower_bound",),
        ("incumbent", "upper_bound"),
        ("incumbent", "x", 0),
        ("box", 0, 0),
        ("box", 1, -1),
        ("terms", 0, "angle_deg"),
        *(("terms", index, "weight") for index in range(len(document["terms"]))),
    ]
    for index, node in _list_kinds(document):
        places += [("nodes", index, "bound")] if "bound" in node else []
        places += [("nodes", index, "split", 1)] if "split" in node else []
        for key in ("panels", "narrow"):
            if key in node.get("evidence", {}):
                path = ("nodes", index, "evidence", key)
                yield from _put((*path, "knots", 0), float("nan"), float("inf"), "nan")
                yield from _put((*path, "rates", 0), [0.0])
    operations = document["response"]["stages"][-1]["operations"]
    constant = next(n for n, step in enumerate(operations) if step[0] == "constant")
    places.append(("response", "stages", -1, "operations", constant, 2, 0))
    for place in places:
        yield from _put(place, *NOT_FINITE)


def _change_measures(document: Document) -> Changes:
    """Terms and limits of other kinds, signs, quantities and weights."""
    for index, term in enumerate(document["terms"]):
        path = ("terms", index)
        kinds = {*MEASURES, "median", "", None} - {term["measure"]}
        yield from _put((*path, "measure"), *kinds)
        yield from _put((*path, "quantity"), -1, 1, 7, True, 0.0, "0", None)
        yield from _put((*path, "size"), True, 1, "", None)
        weight = float.fromhex(term["weight"])
        weights = [(factor * weight).hex() for factor in (-1, 0, 0.5, 1.001, 1000)]
        yield from _put((*path, "weight"), *weights)
        yield from _put((*path, "angle_deg"), (30.0).hex())
        yield from _pop(*path)
    plain = {"measure": "max", "quantity": 0, "size": False, "angle_deg": None}
    for kind, weight in (("max", -1.0), ("range", -1.0), ("min", 1.0)):
        yield from _append("terms", {**plain, "measure": kind, "weight": weight.hex()})
    yield from _append("terms", document["terms"][0])
    limit = {**plain, "weight": (1.0).hex(), "sign": 1, "limit": (1e9).hex()}
    wrong: dict[str, tuple[Any, ...]] = {
        "sign": (0, 2, True),
        "weight": ((-1.0).hex(), (2.0).hex()),
        "limit": ("nan", "inf", (-1e9).hex()),
        "quantity": (-1,),
        "size": (True,),
        "measure": ("x",),
    }
    for key, values in wrong.items():
        yield from _put(("limits",), *([limit | {key: value}] for value in values))
    yield from _put(("all_limits",), False)


def _change_programs(document: Document) -> Changes:
    """Programs with another operation, constant, argument, input or result."""
    seen: set[str] = set()
    for stage, entry in enumerate(document["response"]["stages"]):
        path = ("response", "stages", stage)
        for n, (name, arguments, numbers) in enumerate(entry["operations"]):
            at = (*path, "operations", n)
            if name in seen:
                continue
            seen.add(name)
            yield from _put((*at, 0), "eval", *([OTHER[name]] if name in OTHER else []))
            if arguments:
                yield from _put((*at, 1, 0), len(entry["operations"]), -1)
            if name == "constant":
                yield from _put((*at, 2, 0), (1.01 * float.fromhex(numbers[0]) + 0.01).hex())
            for extra in ([*numbers, (0.0).hex()], numbers[:-1] if numbers else [(0.5).hex()]):
                yield from _put((*at, 2), extra)
            yield from _put((*at, 1), [*arguments, 0], arguments[:-1] or [0, 0])
            if name == "power":
                yield from _put((*at, 2, 0), *((float(n)).hex() for n in (-1, 0, 0.5, 3)))
            if name == "below":  # a jump that is not said to be one, or the other way round
                yield from _put((*at, 2), [(1.0).hex(), (0.5).hex()])
        yield from _put((*path, "outputs"), [])
        yield from _put((*path, "outputs", 0), 10_000)
        yield from _put((*path, "inputs", 0), -1)
    number = {"operations": [["constant", [], [(0.5).hex()]]], "outputs": [0]}
    last = len(document["response"]["stages"]) - 1
    yield from _put(("response", "stages", last), {**number, "inputs": [], "limits": []})
    yield from _put(("response", "period"), "0", "-1", "1/3", "nan", 1.5)
    offsets = document["response"]["offsets"]
    yield from _put(("response", "offsets"), offsets[:-1], [*offsets, "1/3"])


def _change_assembly(document: Document) -> Changes:
    """Assemblies that are none, or are not the one from which roots were followed."""
    for index, node in _list_kinds(document):
        if "evidence" in node:
            path = ("nodes", index, "evidence")
            key = "peaks" if document["kind"] == "sampled" else "starts"
            yield from _put((*path, key), [1.0])
            yield from _put((*path, "continued"), len(document["nodes"]), -1, None)
            yield from _put((*path, "domain"), document["box"])
    if document["assembly"] is None:
        yield from _put(("assembly",), {"design": document["box"][0], "roots": []})
        return
    yield from _put(("assembly",), None)
    roots = document["assembly"]["roots"][0]
    for k, root in enumerate(roots):
        path = ("assembly", "roots", 0, k)
        yield from _put(path, _raise(root, 1e-3), _raise(root, -0.5), *NOT_FINITE[:4], None)
    yield from _pop("assembly", "roots", 0, -1)
    yield from _pop("assembly", "roots", 0)
    yield from _put(("assembly", "roots", 0), [*roots, roots[0]])
    yield from _put(("assembly", "design", 0), *NOT_FINITE[:4], (0.3).hex())
    yield from _pop("assembly", "design", 0)
    for stage, entry in enumerate(document["response"]["stages"]):
        if entry["limits"]:
            outputs, limits = (("response", "stages", stage, key) for key in ("outputs", "limits"))
            yield from _put(outputs, entry["outputs"][:-1], [*entry["outputs"], 0])
            yield from _put(outputs, entry["outputs"][:1] * len(entry["outputs"]))
            yield from _put(limits, entry["limits"][:-1], [])


def _change_boxes(document: Document) -> Changes:
    """Boxes that are wider, empty or of other numbers of sides; incumbents outside of them, or too
    good.
    """
    lower, upper = ([float.fromhex(x) for x in side] for side in document["box"])
    best = [float.fromhex(x) for x in document["incumbent"]["x"]]
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if best[k] == low:  # there are better designs beyond the side on which the optimum is
            yield from _put(("box", 0, k), (low - 0.1).hex())
        if best[k] == high:
            yield from _put(("box", 1, k), (high + 0.1).hex())
        yield from _put(("box", 0, k), (high + 0.1).hex())
        yield from _put(("incumbent", "x", k), (high + 0.2).hex())
    for path in (("box", 0, -1), ("box", 1, -1), ("box", 1), ("incumbent", "x", -1)):
        yield from _pop(*path)
    yield from _pop("incumbent", "evidence")
    reached, bound = document["incumbent"]["upper_bound"], document["lower_bound"]
    yield from _put(("incumbent", "upper_bound"), _raise(reached, -1e-4))
    yield from _put(("lower_bound",), _raise(bound, 1e-4), _raise(reached, 1.0))


def _raise(number: str, change: float) -> str:
    return (float.fromhex(number) + change).hex()


def _raise_all(document: Document) -> None:
    """Raise the bounds of the last leaf, of all designs and of the incumbent together."""
    leaves = [node for node in document["nodes"] if "bound" in node and "children" not in node]
    bounds = (
        (leaves[-1], "bound"),
        (document, "lower_bound"),
        (document["incumbent"], "upper_bound"),
    )
    for entry, key in bounds:
        entry[key] = _raise(entry[key], 1e-4)


def _change_trees(document: Document) -> Changes:
    """Trees with other bounds, splits, sides, children, or without evidence."""
    yield "all bounds greater", _raise_all
    for index, node in _list_kinds(document):
        at = ("nodes", index)
        if "bound" in node:
            yield from _put((*at, "bound"), _raise(node["bound"], 1.0))
        if "evidence" in node:
            yield from _pop(*at, "evidence")
        if "split" in node:
            k = node["split"][0]
            low, high = (float.fromhex(side[k]) for side in document["box"])
            yield from _put((*at, "split", 1), (1e6).hex(), (low + 0.9 * (high - low)).hex())
            yield from _put((*at, "split", 0), k + 17)
        for n, (_, side) in enumerate(node.get("sides", [])):
            turned = {"lower": "upper", "upper": "lower"}[side]
            yield from _put((*at, "sides", n, 1), turned, "middle")
        if children := node.get("children"):
            first = children[:-1]
            changed = [[index] * len(children), [], first, [children[0]] * 2]
            yield from _put((*at, "children"), *changed, [*first, 10_000], [*first, 0])
    yield from _append("nodes", {"bound": (0.0).hex()})
    yield from _put(("nodes",), [])
