"""Proofs with one thing in them changed: fields, numbers, signs, kinds; statement and hash are
those of the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

from planter.engine.proof.certificate_file import compute_digest
from planter.engine.proof.check_proof import MEASURES, state_claim

Document = dict[str, Any]
Tampering = Callable[[Document], None]
NOT_FINITE = ("nan", "-nan", "-inf", "inf")
WRONG: tuple[Any, ...] = (None, [], {}, "", "x", -1, 0.5, True)
"""Values that are put for a whole part."""


def renew(document: Document) -> Document:
    """Return a document with the statement and the hash that its parts have, as who tampers with it
    would write.
    """
    try:
        document["statement"] = state_claim(document)
    except Exception:  # there is no statement of what is spoiled
        document["statement"] = "proved"
    document["sha256"] = compute_digest(document)
    return document


def list_tampered(document: Document) -> Iterator[tuple[str, Document]]:
    """Yield what was changed, and the changed document."""
    for name, tamper in _list_tamperings(document):
        tampered = deepcopy(document)
        tamper(tampered)
        yield name, renew(tampered)
    for name, value in (
        ("statement", "no design is better"),
        ("statement", document["statement"] + " "),
        ("sha256", "0"),
    ):
        tampered = deepcopy(document) | {name: value}
        if name == "statement":
            tampered["sha256"] = compute_digest(tampered)
        yield f"{name} {value[-8:]}", tampered


def _list_tamperings(document: Document) -> Iterator[tuple[str, Tampering]]:
    yield from _list_spoiled_keys(document)
    yield from _list_numbers(document)
    yield from _list_measures(document)
    yield from _list_programs(document)
    yield from _list_boxes(document)
    yield from _list_trees(document)


def _list_kinds(document: Document) -> list[tuple[int, Document]]:
    """Return the first node of each set of keys with its place."""
    first: dict[frozenset[str], int] = {}
    for place, node in enumerate(document["nodes"]):
        first.setdefault(frozenset(node), place)
    return [(place, document["nodes"][place]) for place in first.values()]


def _put(*path: Any, value: Any) -> Tampering:
    def tamper(document: Document) -> None:
        part: Any = document
        for key in path[:-1]:
            part = part[key]
        part[path[-1]] = value

    return tamper


def _list_spoiled_keys(document: Document) -> Iterator[tuple[str, Tampering]]:
    """Every key left out, or with something of another kind; one key more."""
    yield "another key", _put("another", value=1)
    for key in document.keys() - {"sha256", "statement"}:
        yield f"without {key}", lambda document, key=key: document.pop(key)  # type: ignore[misc]
        for value in WRONG:
            is_version = key == "planter" and isinstance(value, str)  # any text names one
            is_weaker = key == "lower_bound" and value is None
            if document[key] != value and not is_version and not is_weaker:
                yield f"{key} = {value!r}", _put(key, value=value)
    for key in document["response"]:
        yield f"without response.{key}", lambda document, key=key: document["response"].pop(key)  # type: ignore[misc]
        for value in (None, [], "", -1, "x"):
            yield f"response.{key} = {value!r}", _put("response", key, value=value)
    for place in ("generated", "parameters", "quantities"):
        yield f"{place} of another length", _shorten(place)
    (module, *_) = document["generated"]
    for value in ("", "0" * 63, "g" * 64, "0" * 65, None, 0):
        yield f"hash = {value!r}", _put("generated", module, value=value)
    second = document["parameters"][1]
    yield "equal parameters", _put("parameters", 0, value=second)
    yield "nameless parameter", _put("parameters", 0, value="")
    yield "number for a parameter", _put("parameters", 0, value=1)


def _shorten(place: str) -> Tampering:
    def tamper(document: Document) -> None:
        if isinstance(document[place], dict):
            document[place].clear()
        else:
            document[place].pop()

    return tamper


def _list_numbers(document: Document) -> Iterator[tuple[str, Tampering]]:
    """Numbers that are none or infinite, wherever a number stands."""
    places: list[tuple[Any, ...]] = [
        ("lower_bound",),
        ("incumbent", "upper_bound"),
        ("incumbent", "x", 0),
        ("box", 0, 0),
        ("box", 1, 1),
        ("terms", 0, "weight"),
        ("terms", 1, "weight"),
        ("terms", 0, "angle_deg"),
    ]
    for index, node in _list_kinds(document):
        places += [("nodes", index, "bound")] if "bound" in node else []
        places += [("nodes", index, "split", 1)] if "split" in node else []
    operations = document["response"]["stages"][-1]["operations"]
    constant = next(n for n, step in enumerate(operations) if step[0] == "constant")
    places.append(("response", "stages", -1, "operations", constant, 2, 0))
    for place in places:
        for value in (*NOT_FINITE, float("nan"), float("inf"), "0x1p99999"):
            yield f"{'.'.join(map(str, place))} = {value}", _put(*place, value=value)
    for index, node in _list_kinds(document):
        for key in ("panels", "narrow"):
            if key in node.get("evidence", {}):
                for value in (float("nan"), float("inf"), "nan"):
                    yield (
                        f"nodes[{index}].{key} = {value}",
                        _put("nodes", index, "evidence", key, "knots", 0, value=value),
                    )
                yield (
                    f"nodes[{index}].{key}.rates",
                    _put("nodes", index, "evidence", key, "rates", 0, value=[0.0]),
                )


def _list_measures(document: Document) -> Iterator[tuple[str, Tampering]]:
    """Terms and limits of other kinds, signs, quantities and weights."""
    for index, term in enumerate(document["terms"]):
        for measure in (*MEASURES, "median", "", None):
            if measure != term["measure"]:
                yield (
                    f"terms[{index}].measure = {measure}",
                    _put("terms", index, "measure", value=measure),
                )
        for value in (-1, 1, 7, True, 0.0, "0", None):
            yield (
                f"terms[{index}].quantity = {value!r}",
                _put("terms", index, "quantity", value=value),
            )
        for value in (True, 1, "", None):
            yield f"terms[{index}].size = {value!r}", _put("terms", index, "size", value=value)
        weight = float.fromhex(term["weight"])
        for factor in (-1, 0, 0.5, 1.001, 1000):
            yield (
                f"terms[{index}].weight x {factor}",
                _put("terms", index, "weight", value=(factor * weight).hex()),
            )
        yield f"terms[{index}].angle_deg", _put("terms", index, "angle_deg", value=(30.0).hex())
        yield f"without terms[{index}]", lambda document, index=index: document["terms"].pop(index)  # type: ignore[misc]
    yield "a term more", lambda document: document["terms"].append(document["terms"][0])
    for kind, weight in (("max", -1.0), ("range", -1.0), ("min", 1.0)):
        term = {
            "measure": kind,
            "quantity": 0,
            "size": False,
            "weight": weight.hex(),
            "angle_deg": None,
        }
        yield f"{weight} {kind}", lambda document, term=term: document["terms"].append(term)  # type: ignore[misc]
    limit = {
        "measure": "max",
        "quantity": 0,
        "size": False,
        "weight": (1.0).hex(),
        "angle_deg": None,
        "sign": 1,
        "limit": (1e9).hex(),
    }
    for key, value in (
        ("sign", 0),
        ("sign", 2),
        ("sign", True),
        ("weight", (-1.0).hex()),
        ("weight", (2.0).hex()),
        ("limit", "nan"),
        ("limit", "inf"),
        ("quantity", -1),
        ("size", True),
        ("measure", "x"),
        ("limit", (-1e9).hex()),
    ):
        yield f"limit with {key} = {value}", _put("limits", value=[limit | {key: value}])
    yield "limits left out", _put("all_limits", value=False)


def _list_programs(document: Document) -> Iterator[tuple[str, Tampering]]:
    """Programs with another operation, constant, argument, input or result."""
    other = {
        "sin": "cos",
        "cos": "sin",
        "multiply": "add",
        "add": "multiply",
        "negate": "not",
        "sqrt": "exp",
    }
    seen: set[str] = set()
    for stage, entry in enumerate(document["response"]["stages"]):
        path = ("response", "stages", stage)
        for n, (name, arguments, numbers) in enumerate(entry["operations"]):
            at = (*path, "operations", n)
            if name in seen:
                continue
            seen.add(name)
            yield f"{name} unknown", _put(*at, 0, value="eval")
            if name in other:
                yield f"{name} -> {other[name]}", _put(*at, 0, value=other[name])
            if arguments:
                yield f"{name} of a later result", _put(*at, 1, 0, value=len(entry["operations"]))
                yield f"{name} of a negative index", _put(*at, 1, 0, value=-1)
            if name == "constant":
                changed = (1.01 * float.fromhex(numbers[0]) + 0.01).hex()
                yield "another constant", _put(*at, 2, 0, value=changed)
        yield f"stage {stage} without results", _put(*path, "outputs", value=[])
        yield f"stage {stage} with a result that is none", _put(*path, "outputs", 0, value=10_000)
        yield f"stage {stage} with a negative input", _put(*path, "inputs", 0, value=-1)
    last = len(document["response"]["stages"]) - 1
    number = {
        "operations": [["constant", [], [(0.5).hex()]]],
        "outputs": [0],
        "inputs": [],
        "limits": [],
    }
    yield "a constant for the programs", _put("response", "stages", last, value=number)
    for value in ("0", "-1", "1/3", "nan", 1.5):
        yield f"period = {value}", _put("response", "period", value=value)
    yield "offsets left out", lambda document: document["response"]["offsets"].pop()
    yield "an offset more", lambda document: document["response"]["offsets"].append("1/3")


def _list_boxes(document: Document) -> Iterator[tuple[str, Tampering]]:
    """Boxes that are wider, empty or of other numbers of sides; incumbents outside of them, or too
    good.
    """
    lower, upper = ([float.fromhex(x) for x in side] for side in document["box"])
    best = [float.fromhex(x) for x in document["incumbent"]["x"]]
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if best[k] == low:  # there are better designs beyond the side on which the optimum is
            yield f"box wider below {k}", _put("box", 0, k, value=(low - 0.1).hex())
        if best[k] == high:
            yield f"box wider above {k}", _put("box", 1, k, value=(high + 0.1).hex())
        yield f"box empty along {k}", _put("box", 0, k, value=(high + 0.1).hex())
        yield f"incumbent outside {k}", _put("incumbent", "x", k, value=(high + 0.2).hex())
    for side in (0, 1):
        yield (
            f"box without a number {side}",
            lambda document, side=side: document["box"][side].pop(),
        )  # type: ignore[misc]
    yield "box of one side", lambda document: document["box"].pop()
    yield "incumbent without a number", lambda document: document["incumbent"]["x"].pop()
    yield "incumbent without evidence", lambda document: document["incumbent"].pop("evidence")
    reached, bound = (
        float.fromhex(x) for x in (document["incumbent"]["upper_bound"], document["lower_bound"])
    )
    yield "a better incumbent", _put("incumbent", "upper_bound", value=(reached - 1e-4).hex())
    yield "a greater bound", _put("lower_bound", value=(bound + 1e-4).hex())
    yield "a bound above the incumbent", _put("lower_bound", value=(reached + 1.0).hex())


def _list_trees(document: Document) -> Iterator[tuple[str, Tampering]]:
    """Trees with other bounds, splits, sides, children, or without evidence."""
    for index, node in _list_kinds(document):
        at = ("nodes", index)
        if "bound" in node:
            raised = (float.fromhex(node["bound"]) + 1.0).hex()
            yield f"{index}: greater bound", _put(*at, "bound", value=raised)
        if "evidence" in node:
            yield (
                f"{index}: no evidence",
                lambda document, index=index: document["nodes"][index].pop("evidence"),
            )  # type: ignore[misc]
        if "split" in node:
            k = node["split"][0]
            yield f"{index}: split elsewhere", _put(*at, "split", 1, value=(1e6).hex())
            yield f"{index}: split of another side", _put(*at, "split", 0, value=k + 17)
        if "sides" in node:
            for n, (_, side) in enumerate(node["sides"]):
                turned = {"lower": "upper", "upper": "lower"}[side]
                yield f"{index}: other side {n}", _put(*at, "sides", n, 1, value=turned)
                yield f"{index}: no such side {n}", _put(*at, "sides", n, 1, value="middle")
        if children := node.get("children"):
            other = {
                "itself": [index] * len(children),
                "none": [],
                "one twice": [children[0]] * 2,
                "a missing one": [*children[:-1], 10_000],
                "the root": [*children[:-1], 0],
            }
            for name, value in other.items():
                yield f"{index}: children {name}", _put(*at, "children", value=value)
    yield "a box more", lambda document: document["nodes"].append({"bound": (0.0).hex()})
    yield "no boxes", _put("nodes", value=[])
