"""What may be claimed of the planting device beside balances: what its derivation and its papers state (wang2017)."""

from __future__ import annotations

from enum import unique

from ...equations import Claim


@unique
class PlantingClaim(Claim):
    """Relations of cam and roller, of the swinging half, and of the teeth at P or Q."""

    # cam and roller
    CAM_PRESSURE_ANGLE = "pressure angle of the cam"
    CAM_FORCE = "force of the cam on the roller, {}'"
    CAM_MOMENT = "moment of the cam force about the planet's axis"

    # swinging half
    PLACE = "place of {}, {}'"
    HINGE_DISTANCE = "distance of {} from the hinge"
    HINGE_ANGLE_CLOSED = "angle of the line from the hinge to {}, closed"
    HINGE_ANGLE = "angle of the line from the hinge to {}"

    # teeth
    NORMAL_DIRECTION = "direction of the normal force at {}"
    FRICTION_DIRECTION = "direction of friction at {}"
    NORMAL_FORCE = "normal force at {}"
    FRICTION_FORCE = "friction force at {}"
    TOOTH_FORCE = "tooth force at {}, {}"
