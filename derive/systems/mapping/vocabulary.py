"""What may be claimed of the design by kinematic mapping: what its derivation and its papers state (sun2019)."""

from __future__ import annotations

from enum import unique

from ...equations import Claim


@unique
class MappingClaim(Claim):
    """Relations from poses to dyads, and from the angle curve to gears."""

    # pose, mapping, circle
    HINGE_BY_POSE = "moving hinge in the fixed frame by the pose, {}"
    POSE_COORDINATE = "coordinate {} of a pose"
    MAPPING_PARAMETER = "mapping parameter {} of a pose"
    POSE_BY_MAPPING = "coordinate {} of a pose by the mapping parameters"
    HINGE_BY_MAPPING = "moving hinge in the fixed frame by the mapping parameters, {}"
    CIRCLE = "moving hinge on a circle about the fixed hinge"
    CIRCLE_COEFFICIENT = "coefficient {} of the circle"
    HINGE_BY_CIRCLE = "{} by the coefficients of the circle"
    ARM_LENGTH = "length of the arm"
    LINEAR_COEFFICIENT = "coefficient {} of the linear form"
    LINEAR_FORM = "circle as a linear form"

    # five poses
    MATRIX_ENTRY = "entry {} of the matrix"
    LINEAR_ROW = "row of the linear system"
    COEFFICIENT_CONDITION = "{} condition on the coefficients"
    ZERO_EIGENVALUES = "zero eigenvalues of the squared matrix"
    NULL_VECTOR = "vector in the null space, {}"
    CONIC_COEFFICIENT = "{} by the basis of the null space"
    NULL_SPACE_CONDITION = "{} condition on the null space"
    REAL_SOLUTIONS = "real solutions of the two conditions"

    # angle curve and ratios
    TIP_BY_ANGLES = "coordinate {} of the tip by the angles of carrier and arm"
    CURVE_ORDINATE = "ordinate of the angle curve"
    CURVE_ENDS = "ordinates of the first and last point"
    CURVE_SLOPE = "slope of the angle curve"
    TOTAL_RATIO = "total ratio by the speeds"
    TOTAL_RATIO_BY_SLOPE = "total ratio by the slope of the angle curve"
    SPLIT_PARAMETER = "split parameter"
    STAGE_RATIO = "ratio {} of a stage"

    # pitch curves
    PITCH_RADIUS = "pitch radius {}"
    POLAR_ANGLE = "polar angle of the {}"
    FIRST_FOLLOWER_TURN = "turn of the first follower"
    SECOND_FOLLOWER_TURN = "turn of the second follower"
