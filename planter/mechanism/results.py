"""Results of the commands for mechanisms of one's own, as their JSON has them."""

from __future__ import annotations

from dataclasses import dataclass

from planter.engine.sensitivity import Direction
from planter.engine.summary import Summary
from planter.optimise.proof.results import GlobalBound
from planter.records import Record


@dataclass(frozen=True)
class Quantity(Record):
    """A quantity over a turn: extremes with their angles [deg], mean, root mean square.

    Mean and root mean square are null if the quantity does not end the turn as it began it. `axes` names the frame by
    whose axes a joint's component is told, if they are not the world's.
    """

    unit: str
    min: float
    max: float
    mean: float | None
    rms: float | None
    min_deg: float
    max_deg: float
    axes: str | None = None


@dataclass(frozen=True)
class Law(Record):
    """A law of mechanics, and the largest amount by which the results break it."""

    law: str
    violation: float
    unit: str


@dataclass(frozen=True, kw_only=True)
class Warned(Record):
    """Something that a user should know, with the angle where it begins if it has one."""

    name: str
    angle_deg: float | None = None
    message: str


@dataclass(frozen=True)
class Held(Record):
    """A limit, in its unit, with what it is on, whether that is at the limit, and whether it satisfies it.

    `value` is null if the condition of the limit never holds, which satisfies it, and if it is an average of what does
    not repeat, which does not.
    """

    limit_on: str
    value: float | None
    limit: float
    active: bool
    met: bool


@dataclass(frozen=True)
class AngleValues(Record):
    """All quantities at an angle of the drive [deg], by key."""

    angle_deg: float
    quantities: dict[str, float]


@dataclass(frozen=True)
class Turn(Record):
    """A turn of a mechanism; works [J] by what does them, null if their power does not repeat.

    `repeats_after_turns` is 1 if the turn ends in the state in which it began, null if no number of turns is known
    after which it does; `not_repeating` has the largest difference, a turn later, of each quantity that does not
    repeat, in its unit, or null if the next turn cannot be computed. Angles are compared modulo 360 deg. `holds` are
    the limits of the file, if it has any, and `met` says whether all of them are satisfied. `at` are the angles that
    were asked for. `designer` has true extremes; it is missing where there is none, and a warning says why.
    """

    machine: str
    samples: int
    quantities: dict[str, Quantity]
    work: dict[str, float | None]
    laws: list[Law]
    warnings: list[Warned]
    repeats_after_turns: int | None
    not_repeating: dict[str, float | None]
    holds: list[Held] | None = None
    met: bool | None = None
    at: list[AngleValues] | None = None
    designer: Summary | None = None


@dataclass(frozen=True, kw_only=True)
class MachineValidation(Record):
    """`planter validate` of a machine that the engine takes: its file, limits and cycle.

    `design` are the values with bounds; `holds` and `met` as in a turn.
    """

    machine: str
    valid: bool
    design: list[str]
    holds: list[Held] | None = None
    met: bool | None = None
    warnings: list[Warned]


@dataclass(frozen=True)
class Course(Record):
    """A quantity over a time; `axes` as in a turn."""

    unit: str
    min: float
    max: float
    last: float
    axes: str | None = None


@dataclass(frozen=True)
class Energy(Record):
    """Energy of weights, springs and motion; given loads and dampers move it."""

    start_J: float
    least_J: float
    most_J: float


@dataclass(frozen=True)
class ChangedStart(Record):
    """A coordinate or a rate that does not start as stated, because the constraints do not allow it."""

    quantity: str
    unit: str
    stated: float
    used: float


@dataclass(frozen=True)
class Motion(Record):
    """A free motion; eigenvalues are pairs of real and imaginary part, at the state of rest.

    `changed_start` has what starts elsewhere than stated: the nearest start, by inertia, that keeps the constraints.
    `dependent_constraints` follow from one another, `redundant_constraints` of them are too many;
    `undetermined_actions` are reactions of over-constrained joints.
    """

    machine: str
    until_s: float
    quantities: dict[str, Course]
    energy: Energy
    redundant_constraints: int
    dependent_constraints: list[str]
    undetermined_actions: list[str]
    changed_start: list[ChangedStart]
    equilibrium: dict[str, float] | None = None
    eigenvalues_per_s: list[tuple[float, float]] | None = None


@dataclass(frozen=True)
class ActiveLimit(Record):
    """A limit or requirement that holds an optimum: what the objective loses per `unit` of it."""

    limit_on: str
    multiplier: float
    unit: str


@dataclass(frozen=True)
class Proof(Record):
    """How sure an optimum is: below 1e-6 the residual of the optimality conditions is that of a local minimum."""

    kkt_residual: float
    active_bounds: list[str]
    active_limits: list[ActiveLimit]
    starts: int
    agreeing_starts: int
    spread: float


@dataclass(frozen=True)
class Evaluations(Record):
    """How often the objective was evaluated: its value, its gradient, its Hessian."""

    objective: int
    gradient: int
    hessian: int


@dataclass(frozen=True)
class FrontDesign(Record):
    """A design of which neither range nor variance can be made smaller without the other growing, in results' units."""

    range: float
    variance: float
    design: dict[str, float]


@dataclass(frozen=True)
class Optimum(Record):
    """The least sum of measures of a turn within bounds and limits.

    The quantities in `least` depend on `effective_parameters` combinations of the design at the optimum; along the
    directions in `insensitive`, in parts of the bounds, they do not change, so that the design is not determined.
    """

    machine: str
    method: str
    least: str
    objective: float
    start_objective: float
    design: dict[str, float]
    start_design: dict[str, float]
    holds: list[Held]
    met: bool
    certificate: Proof
    evaluations: Evaluations
    samples: int
    seconds: float
    effective_parameters: int
    insensitive: list[Direction]
    proof: GlobalBound | None = None
    front: list[FrontDesign] | None = None


COMMANDS = {"move": Motion, "optimise least": Optimum}
"""What the room's commands return."""
