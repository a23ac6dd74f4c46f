"""What the exact model can give within stated bounds, beside wang2017's table 1, and what it says of the experiment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from planter.audit import numbers
from planter.audit.registry import front
from planter.planting.file import load
from planter.planting.model import Device
from planter.planting.undisclosed import experiment
from planter.planting.undisclosed import front as attained
from planter.progress import Listener

PAPER = "wang2017"
ROWS = ("theory", "experiment")
Found = Mapping[str, Any]


def table() -> dict[str, dict[str, float]]:
    """Range [N] and variance [N2] of the support force as the paper has them, by row of its table."""
    disclosed = numbers.load_numbers()["disclosed"][PAPER]
    return {row: {key: disclosed[row][key] for key in ("range_N", "variance_N2")} for row in ROWS}


@front(PAPER)
def attainable(progress: Listener | None) -> dict[str, Any]:
    """The front, the paper's points beside it, and the sizes of what the exact model has to say of the experiment."""
    found = attained.front(PAPER, table(), progress)
    fronts = [{**one, "most_variance_N2": _most(one)} for one in found["fronts"]]
    found = {**found, "fronts": fronts}
    low, high = numbers.load_numbers()["disclosed"][PAPER]["observed_speed_rpm"]
    sizes = experiment.told(Device(load(PAPER), "exact"), (low, high), table()["experiment"])
    return {"paper": PAPER, **found, "experiment": sizes, "statements": list(_said(found, sizes))}


def _said(found: Found, sizes: Found) -> Iterator[str]:
    for one in found["fronts"]:
        yield (
            f"Exact model, {one['contact']}: the search reached a range of {one['largest_range']['range_N']:.4g} N and "
            f"a variance of {one['most_variance_N2']:.4g} N2, within the stated bounds and with any law of the flanks."
        )
    for row in found["table"]:
        reached = {c: v for c, v in row["most_variance_N2"].items() if v is not None}
        variances = ", ".join(f"{value:.4g} N2 with {contact}" for contact, value in reached.items())
        verdict = "reached" if max(reached.values()) >= row["variance_N2"] else "not reached"
        yield (
            f"Table 1, {row['name']}: at its range of {row['range_N']:g} N the search reached a variance of "
            f"{variances}; the paper's {row['variance_N2']:g} N2 was {verdict}."
        )
    yield "The search is a heuristic one: it shows what can be attained, and does not prove that nothing else can."
    yield from _of_experiment(sizes)


def _most(one: Found) -> float:
    return max(float(point["variance_N2"]) for point in one["points"])


def _of_experiment(sizes: Found) -> Iterator[str]:
    measured = sizes["measured"]["range_N"]
    steady = ", ".join(f"{s['range_N']:.3g} N at {s['speed_rpm']:g} r/min" for s in sizes["constant_speed"])
    rippling = max(sizes["rippling_speed"], key=lambda one: one["range_N"])
    yield (
        f"The experiment's {measured:g} N, with the assumed inputs: the exact range is {steady}. Of the speeds tried "
        f"that swing over what was observed, one that does so {rippling['per_turn']} times a turn gives the largest "
        f"range, {rippling['range_N']:.3g} N; some {sizes['ripples_needed']} times a turn would give what was measured."
    )
    for one in sizes["backlash"]:
        yield (
            f"Teeth at {one['contact']} change the flank that bears {one['changes_per_turn']} times a turn. A backlash "
            f"of {one['backlash_mm']:g} mm then gives the support an impulse of up to {one['support_impulse_Ns']:.2g} "
            f"N s: {measured:g} N for {1e3 * one['support_impulse_Ns'] / measured:.2g} ms. How long an impact lasts a "
            "rigid model does not say."
        )
    yield f"What a rigid model has no size for: {', '.join(sizes['not_computed'])}."
