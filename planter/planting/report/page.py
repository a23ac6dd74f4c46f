"""The HTML page of a planting device: its inputs, its results and their basis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from planter.engine.sensitivity import SensitivityResult
from planter.explain import dictionary
from planter.files import units
from planter.mechanism.presentation import list_sensitivity_sections
from planter.planting import cycle, design_results, tables
from planter.planting.design_results import DesignersSummary
from planter.planting.tooth_count_results import ToothCountResult, list_tooth_count_blocks
from planter.report import labels
from planter.report.html import Block, FigureSvg, Folded, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.proof import describe_proof

if TYPE_CHECKING:
    from planter.planting.file import Machine

Summary = Mapping[str, Any]
Sidecar = Mapping[str, Any]

CAPTIONS = {
    "support_force": "Vertical force of the frame on sun and carrier over a turn. Ticks below: angles where a gear's "
    "pitch curve, the cam or the bearing tooth flank changes from one formula to the next.",
    "tip_path": "Path of the nozzle's tip, side 1, with the nozzle at twelve carrier angles. Its outline is a sketch: "
    "the machine file holds its length only. It opens out of the plane of the drawing.",
    "pitch_curves": "Pitch curves in mesh. P and Q are the pitch points, where the teeth are taken to touch.",
    "rotation": "Rotation of middle body and planet relative to the carrier, ratios of both stages, and the absolute "
    "rate of the planet.",
    "joint_forces": "Polar load diagrams: the force vector of each joint over a turn. A dot stands every 30 deg of "
    "carrier angle, the cross is zero force, circles tell the size in N.",
    "convergence": "Best objective so far against evaluations: of the genetic algorithm (ga), of descents from starts "
    "all over the box (ipopt), of descents from the best individuals of the genetic algorithm (polish).",
    "pareto": "Range against variance of the support force.",
}
"""What a figure shows, by the name under which it is handed in; other names stand for themselves."""

_ELSEWHERE = (
    "design", "start_design", "certificate", "warnings", "at", "cross", "gradient", "scaled", "combinations",
    "insensitive", "requirements",
    "proof", "target", "reached", "miss_percent", "designer", "start_designer", "statement",
)  # fmt: skip
NAMED = ("name", "unit", "meaning", "source", "drawn in")
_CROSS = ("design", "machine file", "optimum")


def render_device_page(
    machine: Machine,
    model: Sidecar,
    summary: Summary,
    figures: Mapping[str, str],
    provenance: Summary | None = None,
    motion: Block | None = None,
) -> str:
    """The page for a run: `summary` is its JSON object, `model` the sidecar, `figures` SVG texts by name.

    `motion` shows the machine as it moves.

    What the summary does not hold is left out, so that simulations and optimisations share the page.
    """
    title = f"{_kind(summary)[0]} of the planting device {machine.name}"
    return page(title, list(list_sections(machine, model, summary, figures, provenance, motion)), machine.description)


def _kind(summary: Summary) -> tuple[str, str]:
    """What a summary is of, and the command that gives it."""
    if "fitted" in summary:
        return "Calibration", "calibrate"
    if "gradient" in summary:
        return "Sensitivity", "sensitivity"
    return ("Optimisation", "optimise") if "certificate" in summary else ("Simulation", "simulate")


def list_sections(
    machine: Machine,
    model: Sidecar,
    summary: Summary,
    figures: Mapping[str, str],
    provenance: Summary | None,
    motion: Block | None = None,
) -> Iterator[Section]:
    """The sections of `device_page`, for a page that has more to say."""
    if "start_design" in summary:
        yield Section("In one sentence", [Text(f"{summary['statement'][0].upper()}{summary['statement'][1:]}.")])
    if "fitted" in summary:
        yield Section("Target", list(describe_target(summary)))
        yield Section("Fitted inputs", [tabulate_fitted_inputs(summary["fitted"])])
        for name, fitted_model in summary["models"].items():
            yield Section(f"What the {name} model can give", list(describe_model_fit(fitted_model)))
    if summary.get("warnings"):
        yield Section("Warnings", [list_warnings(summary["warnings"])])
    yield Section("Results", list(describe_results(summary)))
    if "designer" in summary:
        yield Section("Designer's summary", list(describe_design_summary(summary)))
    if "certificate" in summary:
        yield Section("Certificate", list(describe_certificate(summary["certificate"])))
    if "proof" in summary:
        yield Section("Proof", list(describe_proof(summary["proof"])))
    if summary.get("requirements"):
        yield Section("Requirements", [tabulate_requirements(summary["requirements"])])
    if summary.get("teeth"):
        yield Section("Whole teeth", list(list_tooth_count_blocks(ToothCountResult.read(summary["teeth"]))))
    if "gradient" in summary:
        yield from list_sensitivity_sections(SensitivityResult.read(summary))
    elif "insensitive" in summary:
        yield Section("What the force does not feel", list(describe_insensitive_directions(summary["insensitive"])))
    yield Section("Design", [tabulate_design(machine, summary)])
    if "front" in summary and "fitted" not in summary:
        yield Section("Front of range and variance", [tabulate_front(summary["front"])])
    if motion is not None:
        yield Section("Motion", [motion])
    if figures:
        figure_blocks = [FigureSvg(svg, CAPTIONS.get(name, name)) for name, svg in figures.items()]
        yield Section("Figures", figure_blocks)
    if summary.get("lifted"):
        yield Section("Relaxed assumptions", [tables.tabulate_assumption_effects(summary["lifted"])])
    if summary.get("at"):
        yield Section("At single angles", [tabulate_angles(summary["at"])])
    yield Section(
        "Model",
        [Text(f"{model['title']} ({model['source']}). It assumes:"), Items(model["assumptions"])],
    )
    yield Section("Inputs", list(inputs(machine, list_input_meanings(model), besides=("design", "bounds"))))
    yield Section("Names", [list_names(model, summary)])
    if provenance is not None:
        yield provenance_section(provenance)


def list_names(model: Sidecar, summary: Summary) -> Block:
    """Columns of a turn and numbers of the summary: unit, meaning, source, and the figures that draw them."""
    columns = [quantity.shown for quantity in cycle.list_device_quantities(model) if quantity.side != 2]
    keys = [key for key, value in summary.items() if isinstance(value, int | float)]
    meanings_by_name = dictionary.find_meanings("planting", [*columns, *keys], _kind(summary)[1])
    rows = [
        (name, units.unit(name), quantity.meaning, quantity.source, ", ".join(quantity.figures or ()))
        for name, quantity in meanings_by_name
    ]
    return Folded("columns of a turn and numbers of the summary; planter explain tells all", [Table(NAMED, rows)])


def describe_target(summary: Summary) -> Iterator[Block]:
    """Whether a calibration met its target, and each of its numbers beside what is reached."""
    yield Text(summary["statement"], "" if summary["met"] else "warning")
    rows = [
        (labels.name(key), value, summary["reached"][key], units.unit(key), summary["miss_percent"][key])
        for key, value in summary["target"].items()
    ]
    yield Table(("support force", "target", "reached", "unit", "miss / %"), rows)


def describe_model_fit(fit: Summary) -> Iterator[Block]:
    """Whether a model meets the target of a calibration, how far its inputs are from the machine's, the best misses."""
    yield Text(fit["statement"], "" if fit["met"] else "warning")
    distance = fit["distance"]
    yield Keys({"flanks": ", ".join(fit["choices"].values()), "least force of the cam on the roller / N":
                fit["least_push_N"], "distance from the machine's own / widths": distance["rms_share"],
                "on a bound": ", ".join(distance["at_bounds"]) or "none"})  # fmt: skip
    if distance["unusual"]:
        yield Items(distance["unusual"], "warning")
    if fit.get("front"):
        keys = tuple(fit["miss_percent"])
        rows = [(*tradeoff["choices"].values(), *(tradeoff["miss_percent"][key] for key in keys), tradeoff["range_N"])
                for tradeoff in fit["front"]]  # fmt: skip
        yield Table(("flanks", *(f"{labels.name(key)} missed / %" for key in keys), "range / N"), rows)


def tabulate_fitted_inputs(entries: Sequence[Summary]) -> Block:
    """The values that a calibration found, with the bounds that it searched and where they come from."""
    keys = ("name", "value", "unit", "lower", "upper", "origin")
    return Table(("input", *keys[1:]), [tuple(entry[key] for key in keys) for entry in entries])


def tabulate_requirements(entries: Sequence[Summary]) -> Block:
    """Each requirement with its value, limits, margins and origin."""
    keys = ("meaning", "value", "lower", "upper", "unit", "margin", "wanted_margin", "phi_deg", "verdict", "origin")
    head = ("requirement", "value", "min", "max", "unit", "margin", "wanted", "phi / deg", "verdict", "origin")
    return Table(head, [tuple(entry[key] for key in keys) for entry in entries])


def list_warnings(entries: Sequence[Summary]) -> Block:
    """The warnings of a result, each with its carrier angle if it has one."""
    places = (f"At {w['phi_deg']:.4g} deg: " if "phi_deg" in w else "" for w in entries)
    return Items([f"{at}{w['message']} ({w['name']})" for at, w in zip(places, entries, strict=True)], "warning")


def describe_results(summary: Summary) -> Iterator[Block]:
    """Every single number of a summary, then its groups: the keys say the units."""
    separate = {*_ELSEWHERE, *tables.KEYS} if "refined" in summary else {*_ELSEWHERE}
    if "refined" in summary:
        yield (tables.tabulate_optimised_force if "sampled" in summary else tables.tabulate_simulated_force)(summary)
    single = {labels.label(key): value for key, value in summary.items()
              if not isinstance(value, dict | list) and key not in separate}  # fmt: skip
    if single:
        yield Keys(single)
    for key, value in summary.items():
        if isinstance(value, Mapping) and key not in separate:
            rows = [(labels.name(k), labels.flat(v), units.unit(k) or units.unit(key)) for k, v in value.items()]
            yield Table(("quantity", "value", "unit"), rows, labels.name(key))
    if "cross" in summary:
        rows = [(f"{model} model", both["start"], both["optimum"]) for model, both in summary["cross"].items()]
        yield Table(_CROSS, rows, "Objective of both designs in both models")


def describe_design_summary(summary: Summary) -> Iterator[Block]:
    """Torques, peaks of forces, gears and shocks; beside the machine file's own where that is another design."""
    record = DesignersSummary.read(summary["designer"])
    if "start_designer" in summary:
        yield design_results.compare_peaks(DesignersSummary.read(summary["start_designer"]), record)
    yield from design_results.list_design_tables(record)
    yield from (Text(sentence) for sentence in design_results.describe_design(record))
    yield Text("Angles are those of the carrier, counted for side 1; side 2 follows half a turn later.", "note")


def describe_certificate(record: Summary) -> Iterator[Block]:
    """How well an optimum is proved: what the numbers are, and what they mean."""
    yield Keys({labels.label(key): value for key, value in record.items() if not isinstance(value, list)})
    yield Text(
        "The KKT residual is zero at an exact local optimum. Starts that agree ended at the optimum's objective; the "
        "spread is the largest less the least objective that any start ended at. None of this proves that there is no "
        "better design elsewhere.",
        "note",
    )
    bounds = record.get("active_bounds", [])
    if bounds:
        rows = [(bound["name"], bound["side"], bound["multiplier"]) for bound in bounds]
        yield Table(("parameter", "bound", "multiplier"), rows, "Bounds that hold the optimum")
    lists = {key: value for key, value in record.items() if isinstance(value, list) and key != "active_bounds"}
    for key, value in lists.items():
        yield Items([f"{labels.spaced(key)}: {labels.flat(item)}" for item in value])


def describe_insensitive_directions(directions: Sequence[Sequence[Mapping[str, float]]]) -> Iterator[Block]:
    """Directions in the design along which the support force does not change, in parts of the box width."""
    if not directions:
        yield Text("Every parameter matters.")
        return
    yield Text("Moved together as below, in parts of their box widths, these parameters leave the force as it is.")
    for number, direction in enumerate(directions, 1):
        parts = {name: weight for entry in direction for name, weight in entry.items()}
        yield Table(("parameter", "weight"), list(parts.items()), f"direction {number}" if len(directions) > 1 else "")


def tabulate_design(machine: Machine, summary: Summary) -> Block:
    """The design with its bounds; beside the machine file's own where the two differ."""
    start = machine.design
    optimum = {name: summary.get("design", start).get(name) for name in start}
    values = [start, optimum] if optimum != start else [start]
    head = ("machine file", "optimum") if optimum != start else ("value",)
    rows = [
        (labels.name(k), *(v[k] for v in values), units.unit(k), *machine.bounds[k], machine.origin(f"design.{k}"))
        for k in start
    ]
    return Table(("parameter", *head, "unit", "lower", "upper", "origin"), rows)


def tabulate_front(points: Sequence[Summary]) -> Block:
    """Designs of which neither range nor variance can be made smaller without the other growing."""
    names = list(points[0]["design"]) if points else []
    head = ("range / N", "variance / N2", *(labels.label(name) for name in names))
    return Table(head, [(point["range_N"], point["variance_N2"], *point["design"].values()) for point in points])


def tabulate_angles(rows: Sequence[Summary]) -> Block:
    """Quantities down, angles across."""
    head = ("quantity", "unit", *(f"{row['phi_deg']:.6g} deg" for row in rows))
    keys = [key for key in rows[0] if key != "phi_deg"]
    return Table(head, [(labels.name(key), units.unit(key), *(row[key] for row in rows)) for key in keys])


def list_input_meanings(model: Sidecar) -> dict[str, str]:
    """Meaning of the machine's numbers by their full path."""
    return {entry["shown"]: entry["meaning"] for entry in model["vectors"]["machine"] if "shown" in entry}
