"""Recomputation of numbers that the paper prints: polygon in the hexagon, load of an impact, field
trials.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache, partial
from itertools import combinations

import numpy as np

from planter.audit.registry import MM, Inputs, Value, formula
from planter.papers.clutch import modal_engagement
from planter.papers.clutch.field import Factor, Sample, Trial, evaluate_trial, welch_probability
from planter.papers.clutch.model import SIDES, VERTICES, Model, least_travel, load_model
from planter.papers.clutch.results import FieldTest, Level, LevelMeans
from planter.papers.clutch.rotor import Rotor


@formula("distance from the centre of the corner's path")
def centre_offset(inputs: Inputs) -> float:
    """Distance of a printed centre of the ellipse from the centre of the corner's path, over R."""
    path = _path()
    return float(np.hypot(*np.subtract([path["x_E"], path["y_E"]], inputs["centre_over_width"])))


@formula("angle from the major axis of the corner's path")
def axis_offset(inputs: Inputs) -> float:
    """Angle between a printed line of the foci, by its slope, and the major axis of the ellipse
    [deg].
    """
    angle = np.degrees(_path()["axis"] - np.arctan(inputs["foci_slope"])) % 180
    return float(min(angle, 180 - angle))


@formula("mismatch with the third pair of sides")
def mismatch(inputs: Inputs) -> float:
    """Largest distance by which a Reuleaux pentagon misses a hexagon's third pair of sides, over R.

    The sides are one width apart and two pairs of them are held exactly.
    """
    return _in_widths("miss")


@formula("play that the hexagon lacks")
def lacking_play(inputs: Inputs) -> float:
    """Distance of opposite sides beyond R that the pentagon needs to turn freely, over R."""
    return _in_widths("free") - 1


@formula("outline by both sections")
def outline_by_both(inputs: Inputs) -> float:
    """Circumradius over side of the hexagon: by the rule for tooth tips less that by the rule for
    the outline.
    """
    tips = np.sqrt(3) / 2 / np.sin(np.radians(inputs["tip_angle_deg"]))
    outline = np.sqrt(3 / (2 + 2 * np.cos(np.radians(inputs["outline_angle_deg"]))))
    return float(tips - outline)


@formula("width of the tips over the shaft")
def tip_play(inputs: Inputs) -> float:
    """Width of the pentagon of tooth tips with the printed tip radius less the shaft's across flats
    [mm].
    """
    return float(inputs["shaft_flats_mm"] * (inputs["tip_radius_mm"] / tip_radius(inputs) - 1))


@formula("curvature of the tips' path over the fillet")
def fillet_play(inputs: Inputs) -> float:
    """Curvature radius of the tooth tips' path at the corner less the printed fillet radius
    [mm].
    """
    return fillet(inputs) - float(inputs["fillet_mm"])


@formula("semi-axis of the corner's path")
def semi_axis(inputs: Inputs) -> float:
    """Semi-axis of the ellipse, over R: 1 is the major one."""
    return _path()[f"s_{inputs['axis']}"]


@formula("curvature radius where the path meets the side")
def contact_radius(inputs: Inputs) -> float:
    """Curvature radius of the ellipse where it touches the side of the hexagon, over R."""
    return _path()["tangency"]


@formula("fillet from the path")
def fillet(inputs: Inputs) -> float:
    """Curvature radius of the tooth tips' path round a shaft [mm]: the tips' width is the shaft's
    across flats.
    """
    return contact_radius(inputs) * float(inputs["shaft_flats_mm"])


@formula("fillet from the printed curvature")
def fillet_printed(inputs: Inputs) -> float:
    """Fillet radius from the printed curvature radius [mm]."""
    return float(inputs["contact_radius_over_width"]) * float(inputs["shaft_flats_mm"])


@formula("least tip radius")
def tip_radius(inputs: Inputs) -> float:
    """Circumradius of the pentagon of tooth tips whose width is the shaft's across flats [mm]."""
    return _teeth(inputs)["b1"] / MM


@formula("least root radius")
def root_radius(inputs: Inputs) -> float:
    """Distance of the filleted corner's outermost point from the shaft's axis [mm]."""
    return _teeth(inputs)["b2"] / MM


@formula("angle between tooth faces")
def face_angle(inputs: Inputs) -> float:
    """Angle between both faces of a tooth whose faces lie flat on the shaft [deg]."""
    face = load_model().at("face", flats=inputs.si("shaft_flats_mm"), b1=inputs.si("tip_radius_mm"))
    return float(np.degrees(face["xi"]))


@formula("travel as printed")
def travel_printed(inputs: Inputs) -> float:
    """Axial travel with the radial gap counted on both sides, as the print has it [mm]."""
    return _travel(inputs, "printed")


@formula("travel that frees the body")
def travel(inputs: Inputs) -> float:
    """Axial travel after which the body's circle is clear of the hexagon's sides [mm]: radial gap
    over the taper.
    """
    return _travel(inputs, "exact")


@formula("width by the travels over the shaft")
def width_by_travels(inputs: Inputs) -> float:
    """Width of the body that the printed travels belong to, by the printed formula, less the
    shaft's flats [mm].
    """
    pairs = zip(inputs.si("travels_mm"), inputs.si("tapers_deg"), strict=True)
    sides = [
        travelled / least_travel(_of_side(1.0), float(taper), "printed")
        for travelled, taper in pairs
    ]
    width = load_model().at("polygon", a=float(np.mean(sides)))["R"]
    return float(width / MM - inputs["shaft_flats_mm"])


@formula("ratio of radii")
def radius_ratio(inputs: Inputs) -> float:
    """Crank gear's pitch radius over the rack's."""
    return float(inputs["crank_gear_mm"]) / float(inputs["rack_mm"])


@formula("rotation of the crank gear by both equations")
def crank_gear_rotation(inputs: Inputs) -> float:
    """Rotation by (6), of the fixed frame, less that by which the gear rolls on the rack, for the
    link's unit rotation.

    By (7) the gear turns by the arc of the teeth that it passes, which is its rotation relative to
    the link.
    """
    k = radius_ratio(inputs)
    angles = [
        load_model("printed").at("gears", alpha=alpha, k=k, gamma=np.pi / 2)["theta_A"]
        for alpha in (1.0, 2.0)
    ]
    return float(angles[1] - angles[0] - 1 / k)


def _path() -> dict[str, float]:
    """The ellipse of the corner's path, over R."""
    return Rotor(VERTICES, SIDES).ellipse


def _in_widths(name: str) -> float:
    """A length that goes with the hexagon's size, over R."""
    return load_model().at("rotor", a=1.0)[name] / load_model().at("polygon", a=1.0)["R"]


def _teeth(inputs: Inputs) -> dict[str, float]:
    return load_model().at("teeth", flats=inputs.si("shaft_flats_mm"), r=inputs.si("fillet_mm"))


def _travel(inputs: Inputs, name: Model) -> float:
    """Travel by a model [mm]."""
    return (
        least_travel(
            _of_side(float(inputs.si("hexagon_side_mm"))), float(inputs.si("taper_deg")), name
        )
        / MM
    )


def _of_side(a: float) -> dict[str, float]:
    """Return the inputs of a travel from the side of the hexagon [m]; friction and forces have no
    effect on it.
    """
    return {"a": a, "mu": 0.0, "F1": 0.0, "F2": 0.0}


_PATHS = {
    "shaft.density_kg_m3": "density_kg_m3",
    "shaft.overhang_mm": "overhang_mm",
    "shaft.modulus_GPa": "elastic_modulus_GPa",
    "shaft.flat_to_flat_mm": "shaft_flats_mm",
    "engagement.body_kg": "engaging_mass_kg",
    "engagement.contact_radius_mm": "tip_radius_mm",
    "engagement.input_speed_rpm": "input_speed_rpm",
    "engagement.load_Nm": "load_torque_Nm",
}
"""The audit's inputs by their places in a clutch file."""


@formula("largest contact load as printed")
def load_printed(inputs: Inputs) -> float:
    """The printed form: the beam's whole overhanging mass moves, and the engaging mass does not
    move with it [N].
    """
    return modal_engagement.find_extremes(_engagement(inputs), modal_engagement.PRINTED)["N_max"]


@formula("largest contact load")
def load(inputs: Inputs) -> float:
    """Return the load by projection on the assumed mode [N], with half the overhanging mass and the
    engaging mass.
    """
    return modal_engagement.find_extremes(_engagement(inputs))["N_max"]


def _engagement(inputs: Inputs) -> modal_engagement.Engagement:
    values = {path: float(inputs.si(name)) for path, name in _PATHS.items()}
    return modal_engagement.build_engagement(values.__getitem__)


@formula("level mean")
def level_mean(inputs: Inputs) -> float:
    """Mean response of the runs at one level of a factor."""
    return _means(inputs).k[inputs["level"] - 1]


@formula("range of level means")
def level_range(inputs: Inputs) -> float:
    """Largest less least of a factor's level means: its influence in range analysis."""
    return _means(inputs).R


@formula("printed difference")
def printed_difference(inputs: Inputs) -> float:
    """Difference of two printed numbers, in size."""
    return abs(float(inputs["minuend"]) - float(inputs["subtrahend"]))


@formula("reduction")
def reduction(inputs: Inputs) -> float:
    """Reduction from one printed value to another [%]."""
    before, after = float(inputs["before"]), float(inputs["after"])
    return 100 * (before - after) / before


@formula("place in the order of influence")
def place(inputs: Inputs) -> float:
    """Place of a factor when the factors are put in the order of their ranges of level means, the
    largest first.
    """
    ranges = _trial(inputs).range[inputs["response"]]
    order = sorted(ranges, key=lambda name: -ranges[name].R)
    return 1.0 + order.index(inputs["factor"])


@formula("best level by level means")
def best_level(inputs: Inputs) -> float:
    """Level of a factor whose mean response is least in size."""
    return 1.0 + float(np.argmin(np.abs(_means(inputs).k)))


@formula("best level by ranks")
def best_ranked_level(inputs: Inputs) -> float:
    """Level of a factor whose worst rank among some responses is best; each ranks levels by the
    size of their means.
    """
    means = [_means(inputs, name).k for name in inputs["responses"]]
    ranks = [np.argsort(np.argsort(np.abs(k))) for k in means]
    return 1.0 + float(np.argmin(np.max(ranks, axis=0)))


@formula("freedom of interactions over what they take")
def interaction_freedom(inputs: Inputs) -> float:
    """Degrees of freedom that runs leave for interactions of two factors after main effects, less
    all that these have.

    Negative: some interactions cannot be separated from others or from the error (Montgomery,
    Design and Analysis of Experiments, chapter 8).
    """
    codes = [
        np.unique(inputs[f"column_{name}"], return_inverse=True)[1] for name in inputs["factors"]
    ]
    contrasts = [np.eye(code.max() + 1)[code][:, 1:] for code in codes]
    pairs = [
        np.einsum("ri,rj->rij", a, b).reshape(len(a), -1) for a, b in combinations(contrasts, 2)
    ]
    main = np.column_stack([np.ones(len(codes[0])), *contrasts])
    left = np.linalg.matrix_rank(np.column_stack([main, *pairs])) - np.linalg.matrix_rank(main)
    return float(left - sum(pair.shape[1] for pair in pairs))


@formula("best level by prediction")
def best_predicted_level(inputs: Inputs) -> float:
    """Level of a factor where the sum of the sizes of some predicted responses is least, over all
    combinations.
    """
    return _level(inputs, _trial(inputs, inputs["responses"]).best["both"])


@formula("excess of a predicted response")
def excess(inputs: Inputs) -> float:
    """Size of a predicted response at some levels less its size at others."""
    name = inputs["response"]
    sizes = {tuple(row.levels): abs(row.means[name]) for row in _trial(inputs).prediction}
    size, reference = (sizes[tuple(inputs[key])] for key in ("levels", "against"))
    return float(size - reference)


@formula("chance that two means differ so")
def welch(inputs: Inputs) -> Value:
    """Two-sided chance of a difference of two means at least as large for equal means, from printed
    mean, SD, count.

    Welch, Biometrika 34, 1947.
    """
    first, second = (_sample(inputs, name) for name in ("first", "second"))
    return welch_probability(first, second)


@formula("mean of two")
def mean_of_two(inputs: Inputs) -> float:
    """Mean of two printed numbers."""
    return (float(inputs["first"]) + float(inputs["second"])) / 2


@formula("product of counts")
def product_of_counts(inputs: Inputs) -> float:
    """Product of printed counts, over a printed divisor."""
    return math.prod(float(inputs[name]) for name in inputs["factors"]) / float(
        inputs[inputs["divisor"]]
    )


@formula("sum of counts")
def sum_of_counts(inputs: Inputs) -> float:
    """Sum of printed counts."""
    return sum(float(inputs[name]) for name in inputs["terms"])


@formula("not computed")
def not_computed(inputs: Inputs) -> None:
    """Stands for a number that rests on inputs that are not disclosed."""


def _trial(inputs: Inputs, responses: Sequence[str] | None = None) -> FieldTest:
    """The evaluated trial of the paper's columns with some responses, `response` unless said
    otherwise.
    """
    columns = tuple((name, tuple(inputs[f"column_{name}"])) for name in inputs["factors"])
    names = responses or [inputs["response"]]
    return _evaluated(columns, tuple((name, tuple(inputs[name])) for name in names))


@cache
def _evaluated(
    columns: tuple[tuple[str, tuple[int, ...]], ...],
    responses: tuple[tuple[str, tuple[float, ...]], ...],
) -> FieldTest:
    factors = {}
    for name, column in columns:
        levels, codes = np.unique(column, return_inverse=True)
        factors[name] = Factor(tuple(levels.tolist()), codes)
    measured = {name: np.array(values) for name, values in responses}
    trial = Trial("printed runs", factors, measured, {})
    return evaluate_trial(trial, dict.fromkeys(measured, "zero"))


def _sample(inputs: Inputs, name: str) -> Sample:
    mean, sd = inputs[name]
    return Sample(name, speed_m_s=0.0, measure="", mean=mean, sd=sd, n=inputs["repeats"])


def _variance(inputs: Inputs, part: str) -> Value:
    """An entry of the table of the analysis of variance."""
    row = _trial(inputs).anova[inputs["response"]][inputs["source"]]
    entry: Value = getattr(row, part)
    return None if entry is None else float(entry)


for _name, _part in {
    "sum of squares": "ss",
    "degrees of freedom": "df",
    "mean square": "ms",
    "variance ratio": "F",
    "probability": "p",
}.items():
    formula(_name)(partial(_variance, part=_part))


def _means(inputs: Inputs, response: str | None = None) -> LevelMeans:
    """Means of the runs at each level of a factor."""
    name = response or inputs["response"]
    return _trial(inputs, [name]).range[name][inputs["factor"]]


def _level(inputs: Inputs, levels: Sequence[Level]) -> float:
    return float(levels[inputs["factors"].index(inputs["factor"])])
