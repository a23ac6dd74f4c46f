"""What may be claimed of the seedling pick-up: the relations that its derivation and its papers state (yu2023)."""

from __future__ import annotations

from enum import unique

from ...equations import Claim


@unique
class PickupClaim(Claim):
    """Relations of spline, carrier and tip, gear train, teeth."""

    # spline
    KNOT_INTERVAL = "length of a knot interval"
    KNOT_INTERVAL_BEFORE = "length of the knot interval before"
    SECOND_KNOT_INTERVAL_BEFORE = "length of the second knot interval before"
    KNOT_INTERVAL_AFTER = "length of the knot interval after"
    LAST_KNOT = "index of the last knot"
    FIRST_CURVE_KNOT = "index of the knot where the curve begins"
    LAST_CURVE_KNOT = "index of the knot where the curve ends"
    CURVE_POINT = "point of the curve"
    VALUE_POINT = "value point at a knot"
    CONTROL_BEFORE = "coefficient of the control point before"
    CONTROL_AT_KNOT = "coefficient of the control point at the knot"
    CONTROL_AFTER = "coefficient of the control point after"
    KNOT_ROW_RIGHT_SIDE = "right side of the row of a knot"
    KNOT_ROW = "row of a knot"

    # carrier, arm and tip
    DIRECTION_O_M1 = "direction of O-M1"
    DIRECTION_M1_O1 = "direction of M1-O1"
    DIRECTION_O1_S = "direction of O1-S"
    INTERIOR_ANGLE_O1 = "interior angle at O1"
    INTERIOR_ANGLE_O = "interior angle at O"
    CENTRE_DISTANCE_1 = "centre distance of stage 1"
    PLACE = "place of {}, {}"
    VELOCITY = "velocity of {}, {}"
    TIP_DISTANCE = "distance of the tip"
    TIP_DISTANCE_BY_ARM = "distance of the tip from the arm's angle"
    TIP_DISTANCE_INCREMENT = "increment of the tip's distance"
    ARM_ANGLE = "arm's angle from the tip's distance"
    ANGLE_AT_O = "angle at O from the tip's distance"
    DIRECTION_O_O1 = "direction of O-O1 from the tip's"
    ANGLE_AT_O_BY_DIRECTIONS = "angle at O from the directions"
    TIP_DIRECTION = "direction of the tip"
    TIP_DIRECTION_THIRD_QUADRANT = "direction of the tip, third quadrant"
    TIP_DIRECTION_OTHER_QUADRANTS = "direction of the tip, other quadrants"
    PLANET_ANGLE = "planet's angle from the arm's"
    PLANET_RATE = "rate of the planet's angle"
    EXTREME_ARM_ANGLE = "arm's angle, tip {}"
    EXTREME_ANGLE_AT_O = "angle at O, tip {}"
    EXTREME_DISTANCE = "distance, tip {}"
    BAR_L1 = "bar L1 from the extremes"
    BAR_L2 = "bar L2 from the extremes"
    NEEDLE_TURN = "turn of the needle from pick to push"

    # gear train
    MIDDLE_TURN = "turn of the intermediate gear"
    RATIO_1 = "ratio of stage 1"
    TOTAL_RATIO = "total ratio"
    TOTAL_RATIO_BY_STAGES = "total ratio through both stages"
    DWELL_RATIO = "reciprocal of the total ratio in the dwell"
    MIDDLE_PITCH_RADIUS = "pitch radius of the intermediate gear"
    SUN_PITCH_RADIUS = "pitch radius of the sun"
    PITCH_CURVE = "pitch curve of the {}, {}"
    CURVATURE_RADIUS = "radius of curvature of the {}"

    # teeth
    CENTRE_DISTANCE_2 = "centre distance of the helical pair"
    TRANSVERSE_PRESSURE_ANGLE = "transverse pressure angle of the helical pair"
    HELICAL_CONTACT_RATIO = "contact ratio of the helical pair"
    CONTACT_RATIO = "contact ratio of the non-circular pair"
    SUN_PATH_OF_ACTION = "path of action to the sun's addendum"
    MIDDLE_PATH_OF_ACTION = "path of action to the intermediate gear's addendum"
    ADDENDUM_SLOPE = "slope of the contact ratio per addendum coefficient"
    MODULE_SLOPE = "slope of the contact ratio per module"
    GROWS_WITH_ADDENDUM = "contact ratio grows with the addendum"
    FALLS_WITH_MODULE = "contact ratio falls with the module"
