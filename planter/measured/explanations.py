"""`planter calibrate --explain`: what gives a measured curve, the rigid machine or the least that
is added to it.

Explanations are nested: the rigid machine with its inputs, with one effect between it and the
sensor, and, if no effect leaves noise alone, with two. Each is fitted with the phase and the zero
of the sensor; one is preferred to the rigid machine if the F test for whitened noise allows for it,
at a level divided by the number of effects, and the evidence is for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.engine.machine import Machine
from planter.engine.wording import name_quantity
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document
from planter.measured.calibration import (
    describe_active_bounds,
    describe_inputs,
    describe_noise,
    judge_fit,
    leaves_noise,
    read_measurement,
    rebuild_machine,
    state_active_bounds,
)
from planter.measured.curve import (
    EFFECT,
    PHASE,
    Chosen,
    find_measured,
    find_phases,
    find_records,
    is_offset,
)
from planter.measured.findings import EffectParameter, Explanation, ExplanationFound
from planter.measured.fit import MOST_POINTS, Fit, fit_curve
from planter.measured.noise import (
    LackOfFit,
    RhoLikelihood,
    assess_lack_of_fit,
    compare_likelihoods,
    compute_log_evidence,
    find_independent,
)
from planter.measured.reading import Columns, Measurement
from planter.measured.sensor_curve import SensorCurve, describe_view, name_parameter
from planter.measured.sensor_view import (
    DRIFTS,
    ElasticMount,
    ElectricCoupling,
    Gain,
    Imbalance,
    LeakedForce,
    LeakedTorque,
    SensorEffect,
    SpeedHarmonics,
    StatedEffect,
    ZeroDrift,
    with_view,
)
from planter.progress import Listener, ProgressPhase

RIGID, STATED = "rigid", "stated"
"""Names of the explanations that add no effect: to the rigid machine, and to what the machine file
states.
"""
MEANINGS = {
    RIGID: "the sensor sees the rigid machine",
    STATED: "the sensor sees what the machine file states",
}
SUBJECTS = {RIGID: "the rigid machine", STATED: "the machine behind the file's [measurement]"}
STARTS = 6
ENCLOSURES, LEVERS = 3, 2
"""Number of enclosed forces and levers that are fitted, of all that are scanned."""
LEVEL = 0.01
"""Level of the test against the rigid machine, for all effects together."""
DECISIVE = 1.0
"""Logarithm, to the base 10, of the ratio of evidences from which on data decide."""
MOST_DECADES = 6.0
"""Logarithm, to the base 10, of the largest ratio of evidences that a sentence states as a
number.
"""
FORCE, TORQUE = "N", "N m"


@dataclass(frozen=True)
class ExplainedFit:
    """A fit of the rigid machine with effects, the test of what it leaves, and the logarithm of its
    evidence.
    """

    effects: tuple[SensorEffect, ...]
    fit: Fit
    lack: LackOfFit
    log_evidence: float
    likelihood: RhoLikelihood

    @property
    def name(self) -> str:
        """The names of the effects."""
        return " + ".join(effect.name for effect in self.effects) or self.base

    @property
    def words(self) -> str:
        """The effects in words, for pages."""
        return describe_effects(self.curve.machine, self.effects) or self.base

    @property
    def base(self) -> str:
        """The name of the explanation without effects."""
        return STATED if self.curve.stated else RIGID

    @property
    def curve(self) -> SensorCurve:
        """The fitted curve."""
        assert isinstance(self.fit.curve, SensorCurve)
        return self.fit.curve


@dataclass(frozen=True)
class ExplanationFits:
    """Fits of all explanations by name, the machine file with the inputs of the preferred one, and
    the result.
    """

    measured: Measurement
    fits: Mapping[str, ExplainedFit]
    machine: Document | None
    result: ExplanationFound


def explain_curve(
    machine: Machine,
    model: str,
    measured: Measurement,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str,
    rebuild: Callable[[Mapping[str, float]], Document] | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> ExplanationFits:
    """Explain a measured curve of a quantity of a machine, with inputs within `bounds` (display
    units, by path).

    A phase of a whole cycle and an offset as large as the data's range are fitted unless `bounds`
    has them. Raises InputError for inputs that do not exist.
    """
    chosen = Chosen.from_bounds(machine, _with_nuisances(machine, measured, bounds), priors)
    stated = SensorCurve(machine, chosen, measured, quantity).stated
    effects = [
        effect
        for effect in list_effects(machine, quantity, measured)
        if not _is_stated(effect, stated)
    ]
    phase = ProgressPhase("explanations", "fit", ENCLOSURES + LEVERS + len(DRIFTS) + 6, progress)

    def fit_effects(*chosen_effects: SensorEffect) -> ExplainedFit:
        curve = SensorCurve(machine, chosen, measured, quantity, chosen_effects)
        fit = fit_curve(curve, seed, STARTS)
        explained = _assess_fit(chosen_effects, fit)
        phase.advance(explained.name)
        return explained

    rigid = fit_effects()
    screened = list(_screen_effects(machine, chosen, measured, quantity, effects))
    fits = [rigid, *(fit_effects(effect) for effect in screened)]
    compared = len(effects)
    if not any(leaves_noise(each.fit, each.lack) for each in fits):
        pairs = _pair_effects(fits[1:])
        phase.total += len(pairs)
        fits += [fit_effects(*pair) for pair in pairs]
        compared += len(pairs)
    preferred, rivals = _find_better(fits, compared)
    undecided = [each.name for each in rivals]
    detailed = {preferred.name, *undecided}
    rows = [_describe_explanation(each, rigid, compared, each.name in detailed) for each in fits]
    fitted, notes = (None, []) if rebuild is None else rebuild_machine(preferred.fit, rebuild)
    if fitted is not None and preferred.effects:
        fitted = with_view(fitted, preferred.curve.find_view(preferred.fit.values))
    assert measured.reading is not None
    drifts = [effect for effect in preferred.effects if isinstance(effect, ZeroDrift)]
    result = ExplanationFound(
        machine=machine.name,
        model=model,
        quantity=preferred.fit.curve.keys[0],
        unit=preferred.fit.curve.unit,
        outcome=judge_fit(preferred.fit, preferred.lack),
        statement=_state_result(
            {row.name: row for row in rows},
            preferred.name,
            undecided,
            compared,
            {each.name: each.words for each in fits},
        ),
        preferred=preferred.name,
        undecided=undecided,
        compared=compared,
        explanations=rows,
        fitted=describe_inputs(preferred.fit),
        treatment=[
            *measured.treatment,
            *describe_view(preferred.curve, preferred.fit.values),
            *(
                f"{effect.name}: it belongs to the record, and no machine file has it"
                for effect in drifts
            ),
            *notes,
        ],
        reading=measured.reading,
    )
    return ExplanationFits(measured, {each.name: each for each in fits}, fitted, result)


def read_and_explain(
    machine: Machine,
    model: str,
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantities: Sequence[str],
    rebuild: Callable[[Mapping[str, float]], Document] | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> ExplanationFits:
    """Explain the curve in a CSV file, as `explain_curve` does.

    Raises InputError for more than one quantity.
    """
    if len(quantities) != 1:
        raise InputError("--explain takes one quantity: give --column and --quantity once")
    measured = read_measurement(machine, data, columns, quantities)
    return explain_curve(
        machine, model, measured, bounds, quantities[0], rebuild, seed, progress, priors
    )


def describe_effects(machine: Machine, effects: Sequence[SensorEffect]) -> str:
    """Return effects in words, quantities by what they mean and their symbols; empty without
    effects.
    """
    named = {quantity.key: name_quantity(quantity) for quantity in machine.results}
    words = []
    for effect in effects:
        if isinstance(effect, LeakedForce):
            words.append(f"share of {named[effect.key]}")
        elif isinstance(effect, LeakedTorque):
            words.append(f"{named[effect.key]} at a lever")
        else:
            words.append(effect.name)
    return " + ".join(words)


def list_effects(machine: Machine, quantity: str, measured: Measurement) -> list[SensorEffect]:
    """Return the effects that can stand between a quantity of a machine and a sensor."""
    target, speed = find_measured(machine, quantity), abs(float(machine.data[machine.speed]))
    span = float(np.ptp(measured.values[measured.used]))
    is_force = units.display_unit(target.key) == FORCE
    effects: list[SensorEffect] = []
    for result in machine.results:
        unit = units.display_unit(result.key)
        if result.name != target.name and unit == units.display_unit(target.key):
            effects.append(LeakedForce(result.key))
        elif is_force and unit == TORQUE:
            effects.append(LeakedTorque(result.key))
    if is_force:
        effects.append(Imbalance(span / speed**2))
    if machine.acceleration is not None or (target.total and is_force):
        effects.append(SpeedHarmonics())
    phi = measured.phi[measured.used]
    records = find_records(phi)
    spans = tuple(
        (float(each[0]), float(each[-1]))
        for each in np.split(phi, np.flatnonzero(np.diff(records)) + 1)
    )
    drifts = [ZeroDrift(degree, spans, span, units.display_unit(target.key)) for degree in DRIFTS]
    return [*effects, ElasticMount(speed), Gain(), ElectricCoupling(speed), *drifts]


def _is_stated(effect: SensorEffect, stated: Sequence[StatedEffect]) -> bool:
    """Return whether the machine file states an effect; it can state one lever only."""
    names = {each.effect.name for each in stated}
    has_lever = any(isinstance(each.effect, LeakedTorque) for each in stated)
    return effect.name in names or (has_lever and isinstance(effect, LeakedTorque))


def _with_nuisances(
    machine: Machine, measured: Measurement, bounds: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    values = measured.values[measured.used]
    largest = float(np.ptp(values)) + abs(float(values.mean()))
    extended = dict(bounds)
    if PHASE not in bounds:
        extended[PHASE] = (0.0, float(np.degrees(machine.turn)))
    if not any(is_offset(name) for name in bounds):
        extended["offset"] = (-largest, largest)
    return extended


def _screen_effects(
    machine: Machine,
    chosen: Chosen,
    measured: Measurement,
    quantity: str,
    effects: Sequence[SensorEffect],
) -> Iterator[SensorEffect]:
    """Yield the forces and levers that a scan of the phase favours most, and all other effects."""
    sums: dict[type, list[tuple[float, int]]] = {LeakedForce: [], LeakedTorque: []}
    for i, effect in enumerate(effects):
        if type(effect) in sums:
            curve = SensorCurve(machine, chosen, measured, quantity, [effect]).with_points(
                MOST_POINTS
            )
            sums[type(effect)].append((find_phases(curve, curve.machine_values(), 1)[0][1], i))
    limits = ((LeakedForce, ENCLOSURES), (LeakedTorque, LEVERS))
    selected = {i for kind, limit in limits for _, i in sorted(sums[kind])[:limit]}
    for i, effect in enumerate(effects):
        if i in selected or type(effect) not in sums:
            yield effect


def _pair_effects(fits: Sequence[ExplainedFit]) -> list[tuple[SensorEffect, ...]]:
    """Return the most probable effect with each of another kind, in the order in which they act."""
    best = max(fits, key=lambda each: each.log_evidence).effects[0]
    added = [
        effect for (effect,) in (each.effects for each in fits) if type(effect) is not type(best)
    ]
    return [tuple(sorted((best, effect), key=lambda each: each.rank)) for effect in added]


def _assess_fit(effects: tuple[SensorEffect, ...], fit: Fit) -> ExplainedFit:
    slopes = fit.curve(fit.values)[1]
    lack = assess_lack_of_fit(fit.curve, fit.residuals, slopes)
    likelihood = RhoLikelihood.compute(
        fit.residuals, find_independent(slopes)[0], fit.curve.gaps[0]
    )
    return ExplainedFit(
        effects, fit, lack, compute_log_evidence(fit.curve, fit.residuals, slopes), likelihood
    )


def _find_better(
    fits: Sequence[ExplainedFit], compared: int
) -> tuple[ExplainedFit, list[ExplainedFit]]:
    """Return the preferred one of fits, the rigid machine first, and those that the data cannot
    tell from it.

    Only fits that are better than the rigid machine beyond chance are considered.
    """
    rigid, better = fits[0], []
    for each in fits[1:]:
        probability = compare_likelihoods(rigid.likelihood, each.likelihood).probability
        is_likely = correct_probability(probability, compared) < LEVEL
        if is_likely and _log10_ratio(each, rigid) > DECISIVE:
            better.append(each)
    preferred = max(better, key=lambda each: each.log_evidence, default=rigid)
    undecided = [
        each
        for each in better
        if each is not preferred and _log10_ratio(preferred, each) < DECISIVE
    ]
    return preferred, undecided


def correct_probability(probability: float, compared: int) -> float:
    """Return the probability that any of several tests is as improbable as one of them, by
    Bonferroni's bound.
    """
    return min(1.0, probability * max(compared, 1))


def _log10_ratio(each: ExplainedFit, other: ExplainedFit) -> float:
    return (each.log_evidence - other.log_evidence) / float(np.log(10))


def _describe_explanation(
    each: ExplainedFit, rigid: ExplainedFit, compared: int, with_intervals: bool
) -> Explanation:
    fit, curve = each.fit, each.curve
    test = None if each is rigid else compare_likelihoods(rigid.likelihood, each.likelihood)
    correlation = fit.correlation()
    names = curve.chosen.names
    parameters = []
    for effect in each.effects:
        for parameter in effect.parameters:
            index = names.index(name_parameter(effect, parameter.name))
            interval: list[float | None] | None = None
            if with_intervals:
                low, high = fit.band(index)
                crosses = parameter.scale == "reciprocal" and low <= 0 <= high
                ends = (low, high) if parameter.scale != "reciprocal" else (high, low)
                interval = [None, None] if crosses else [parameter.to_display(end) for end in ends]
            parameters.append(
                EffectParameter(
                    f"{effect.name}.{parameter.name}",
                    parameter.to_display(float(fit.values[index])),
                    parameter.unit,
                    parameter.to_display(parameter.lower),
                    parameter.to_display(parameter.upper),
                    parameter.scale,
                    interval,
                )
            )
    displayed = curve.chosen.to_display(fit.values)
    return Explanation(
        name=each.name,
        meaning="; ".join(effect.meaning for effect in each.effects) or MEANINGS[each.base],
        outcome=judge_fit(fit, each.lack),
        rms=fit.rms,
        noise=describe_noise(curve.noises[0], curve.unit),
        lack_of_fit=each.lack,
        F=None if test is None else test.F,
        probability=None if test is None else test.probability,
        probability_of_any=None
        if test is None
        else correct_probability(test.probability, compared),
        log10_bayes=_log10_ratio(each, rigid),
        parameters=parameters,
        inputs={name: value for name, value in displayed.items() if not name.startswith(EFFECT)},
        correlation=None if correlation is None else correlation.tolist(),
        starts=len(fit.sums),
        agreeing_starts=fit.agreeing,
        active_bounds=describe_active_bounds(fit),
    )


def _state_result(
    rows: Mapping[str, Explanation],
    preferred: str,
    undecided: Sequence[str],
    compared: int,
    words: Mapping[str, str],
) -> str:
    """Return the sentences on the preferred explanation; `words` are those of explanations by their
    names.
    """
    base = next(name for name in SUBJECTS if name in rows)
    rigid, best, subject = rows[base], rows[preferred], SUBJECTS[base]
    sentences = []
    if preferred == base:
        lowest = min(
            row.probability_of_any for row in rows.values() if row.probability_of_any is not None
        )
        end = {
            "explained": "explains the curve",
            "not explained": "does not explain the curve, and no effect is better",
            "not settled": "is not settled as an explanation, and no effect is better",
        }[rigid.outcome]
        sentences.append(
            f"T{subject[1:]} {end}: by chance, the best of {compared} effects improves it as much "
            f"with a probability "
            f"{_describe_probability(lowest)}"
        )
    else:
        decades = best.log10_bayes
        # beyond a million the model itself is less certain
        odds = "more than a million times"
        if decades < MOST_DECADES:
            odds = f"{round(10**decades, 1 - int(decades)):g} times"
        verb = {
            "explained": "explains",
            "not explained": "comes nearest but does not explain",
            "not settled": "comes nearest to",
        }[best.outcome]
        sentences.append(
            f"{words[preferred][0].upper()}{words[preferred][1:]} {verb} the curve: {subject} is "
            f"{odds} less probable, and leaves "
            f"{rigid.rms / best.rms:.3g} times the "
            f"residual; by chance, the best of {compared} effects does as well with a probability "
            f"{_describe_probability(best.probability_of_any or 0.0)}"
        )
        values = [
            f"{p.name.rpartition('.')[2]} {p.value or np.inf:.4g} {p.unit}".removesuffix(" 1")
            for p in best.parameters
        ]
        sentences.append(f"Its parameters: {', '.join(values)}")
    if best.active_bounds:
        sentences.append(state_active_bounds(best.active_bounds))
    if undecided:
        names = [words[name] for name in (preferred, *undecided)]
        sentences.append(
            f"These data cannot decide between {', '.join(names[:-1])} and {names[-1]}"
        )
    return ". ".join(sentences)


def _describe_probability(probability: float) -> str:
    """Return a probability in words; below a millionth the model of the noise itself is less
    certain.
    """
    smallest = 10**-MOST_DECADES
    return f"of {probability:.2g}" if probability >= smallest else f"below {smallest:g}"
