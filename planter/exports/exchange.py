"""A mechanism that moves freely as a unit for model exchange (FMI 2.0): an importer integrates it.

States, inputs, parameters and outputs have the names of the statement; event indicators are the
values of its events. The C is that of `dynamics_c`, behind the template `exchange.c`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from planter.exports import dynamics_c
from planter.exports.c99 import read_template
from planter.exports.co_simulation import EXCHANGE, MAIN, Causality, UnitModel, Variable
from planter.exports.fmu import pack_unit
from planter.exports.results import UnitWritten
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.version import __version__

PERIOD, STEPS = 1.0, 500
"""Proposed end of a simulation [s], and its steps."""


def build_unit_model(model: DynamicsModel) -> UnitModel:
    """Return what the unit says of itself."""
    return UnitModel(
        name=dynamics_c.build_name(model),
        title=model.name,
        meaning=f"The free motion of {model.name}: states are coordinates and their rates.",
        tool=f"planter {__version__}",
        variables=tuple(_list_variables(model)),
        period=PERIOD,
        steps=STEPS,
        events=model.events,
    )


def _list_variables(model: DynamicsModel) -> Iterator[Variable]:
    """Yield the variables in the order of `exchange.c`."""
    for state in model.states:
        yield _convert(state, "output", state.value)
    for index, state in enumerate(model.states):
        unit = RATE_UNITS[state.unit]
        meaning = f"rate of {state.name}"
        yield Variable(f"der({state.name})", unit, meaning, "local", rate_of=index)
    for variable in model.inputs:
        yield _convert(variable, "input", variable.value)
    for variable in model.parameters:
        yield _convert(variable, "parameter", variable.value)
    for variable in model.outputs:
        yield _convert(variable, "output", None)


RATE_UNITS = {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2", "1": "1/s"}
"""Units of rates by those of states."""


def _convert(variable: DynamicsVariable, causality: Causality, start: float | None) -> Variable:
    low, high = (None if np.isinf(end) else end for end in (variable.low, variable.high))
    return Variable(variable.name, variable.unit, variable.meaning, causality, start, low, high)


def write_exchange_unit(model: DynamicsModel, file: Path) -> UnitWritten:
    """Write the unit with the libraries that can be built here. Raises as `fmu.write_unit`."""
    name = dynamics_c.build_name(model)
    fields = {"headline": model.name, "version": __version__, "name": name, "NAME": name.upper()}
    main = read_template("exchange.c").substitute(fields, events=model.events)
    texts = dynamics_c.build_c_files(model)
    del texts[f"{name}_main.c"]
    unit = build_unit_model(model)
    return pack_unit(EXCHANGE, unit, texts | {MAIN: main}, file, "2.0")
