"""What a mechanism, a pitch curve or a target consists of, in one place: `from derive import ...`.

Its import finds the targets, so that from then on the names that they need are refused.
"""

from __future__ import annotations

from .audit.paper import Paper
from .audit.user_mechanism.trial import trial
from .chain import Chain, ChainError, Solve, ordered
from .emit.expression import Dialect, Printer
from .emit.folder import Target, built_in
from .emit.text import Emitted
from .equations import Balance, Equation, loop, what
from .formulas import Formulas
from .functions import clip, switch, wrap
from .mechanics.bodies import Body, Part, about_pin
from .mechanics.contacts import GearContact, SharedContact, SlidingContact, tangent_angle
from .mechanics.driven_motion import Sides
from .mechanics.frames import (
    Axis,
    Frame,
    FrameError,
    Motion,
    Point,
    Vec,
    X,
    Y,
    Z,
    displacement,
    unit,
    zero,
)
from .mechanics.gearing.pairs import GearTable, RollingPair, gear_pair, read_gear_pair
from .mechanics.gearing.pitch_curve import Condition, PitchCurve, Shape, register
from .mechanics.impact import Impact, ImpactLaw, creeping, dahl
from .mechanics.kinematics import Followed, FollowerLaw, GearStage
from .mechanics.mechanism import Mechanism
from .mechanics.release import (
    ElasticTeeth,
    FrameMount,
    LiftingFollower,
    LoosePin,
    Release,
    ReleasedMechanism,
)
from .model import Call, ClosedForm, Event, Lane, Let, RuntimeFunction, Shared, System, needed
from .quantity import OpenVector, Quantities, Quantity, Vector, quantities
from .tables import read_table

built_in()

__all__ = [
    "Axis",
    "Balance",
    "Body",
    "Call",
    "Chain",
    "ChainError",
    "ClosedForm",
    "Condition",
    "Dialect",
    "ElasticTeeth",
    "Emitted",
    "Equation",
    "Event",
    "Followed",
    "FollowerLaw",
    "Formulas",
    "Frame",
    "FrameError",
    "FrameMount",
    "GearContact",
    "GearStage",
    "GearTable",
    "Impact",
    "ImpactLaw",
    "Lane",
    "Let",
    "LiftingFollower",
    "LoosePin",
    "Mechanism",
    "Motion",
    "OpenVector",
    "Paper",
    "Part",
    "PitchCurve",
    "Point",
    "Printer",
    "Quantities",
    "Quantity",
    "Release",
    "ReleasedMechanism",
    "RollingPair",
    "RuntimeFunction",
    "Shape",
    "Shared",
    "SharedContact",
    "Sides",
    "SlidingContact",
    "Solve",
    "System",
    "Target",
    "Vec",
    "Vector",
    "X",
    "Y",
    "Z",
    "about_pin",
    "clip",
    "creeping",
    "dahl",
    "displacement",
    "gear_pair",
    "loop",
    "needed",
    "ordered",
    "quantities",
    "read_gear_pair",
    "read_table",
    "register",
    "switch",
    "tangent_angle",
    "trial",
    "unit",
    "what",
    "wrap",
    "zero",
]
