"""What may be claimed of the clutch: the relations that its derivation and its papers state (shi2021)."""

from __future__ import annotations

from enum import unique

from ...equations import Claim


@unique
class ClutchClaim(Claim):
    """Relations of polygon, teeth, taper, linkage, engagement and slip."""

    # polygon in the hexagon
    C_FROM_A_X = "vertex C from vertex A, x"
    C_FROM_A_Y = "vertex C from vertex A, y"
    C_FROM_B_X = "vertex C from vertex B, X"
    C_FROM_B_Y = "vertex C from vertex B, Y"
    C_TURNED_X = "coordinates of C in the turned frame, X"
    C_TURNED_Y = "coordinates of C in the turned frame, Y"
    DIRECTION_BC = "direction of BC from that of AC"
    SIDE_OF_A = "side that A slides on"
    SIDE_OF_B = "side that B slides on"
    A_SLIDING = "vertex A while A and B slide"
    PATH_X = "path of C, x"
    PATH_Y = "path of C, y"
    PATH_SINE = "coefficient of the sine in the path of C"
    PATH_COSINE = "coefficient of the cosine in the path of C"
    HEXAGON_SIDE = "side of the hexagon that fits the polygon's width"
    ELLIPSE_CENTRE_X = "centre of the ellipse, x"
    ELLIPSE_CENTRE_Y = "centre of the ellipse, y"
    FOCUS_X = "focus of the ellipse, x"
    FOCI_LINE = "line of the foci"
    SEMI_MAJOR_AXIS = "semi-major axis of the ellipse"
    SEMI_MINOR_AXIS = "semi-minor axis of the ellipse"
    PATH_CURVATURE = "curvature of the path where it leaves the side"
    THIRD_OVERLAP = "overlap with the third pair of sides"
    TIP_PATH_CURVATURE = "curvature of the tip path where it leaves the flat"
    FILLET = "fillet that the tooth tips clear"

    # teeth
    TIP_DISTANCE = "tooth tips go round the shaft"
    ROOT_DISTANCE = "tooth roots clear the shaft's corners"
    FACE_ANGLE = "angle between the faces of a tooth"
    LEAST_TIP_FACE_ANGLE = "angle between the faces at the least tip distance"

    # travel and taper
    OUTLINE_RADIUS = "largest outline radius of the body"
    LEAST_TRAVEL = "least travel of the sleeve"
    TRAVEL = "travel of the sleeve"
    SLEEVE_SLIDES = "sleeve slides along the taper"
    SLEEVE_ACROSS = "sleeve on the taper, force across it"
    SLEEVE_FRICTION = "friction of body and sleeve"
    AXIAL_ANGLE = "axial angle from the outline radii"
    WALL = "material between tooth roots and outline"
    LEAST_AXIAL_ANGLE = "least axial angle for a travel"
    LARGEST_AXIAL_ANGLE = "largest axial angle at which the sleeve slides"

    # control linkage
    CRANK_GEAR = "rotation of the crank gear with the link"
    CRANK_GEAR_ON_LINK = "rotation of the crank gear relative to the link"
    CRANK_BY_TEETH = "rotation of the crank gear for a number of teeth"
    CRANK_BY_TRAVEL = "rotation of the crank for the travel of the sleeve"
    SWITCHING_TIME = "time to switch"

    # engagement
    BODY_FORCE = "force on the engaging body"
    SHAFT_FORCE = "force on the output shaft"
    CONTACT_SPEED = "speed of the contact point at the start"
    COMMON_SPEED = "speed of body and shaft at the start, when they move together"
    MODAL_DEFLECTION = "deflection of the shaft in its mode"
    SHAFT_DEFLECTION = "deflection of the shaft over time"
    CONTACT_DEFLECTION = "deflection at the contact over time"
    SHAFT_SECTION = "section of the shaft"
    SECOND_MOMENT = "second moment of the shaft"
    MODAL_MASS = "modal mass of the shaft"
    MODAL_STIFFNESS = "modal stiffness of the shaft"
    OVERHANG_MASS = "mass of the overhanging shaft"
    CONTACT_FREQUENCY = "circular frequency in contact"
    DRIVING_ACCELERATION = "acceleration by the driving force"
    CONTACT_ACCELERATION = "acceleration of the shaft at the contact"
    SHAFT_ACCELERATION = "acceleration of the shaft"
    FOURTH_DERIVATIVE = "fourth derivative of the deflection"
    MODAL_DELTA = "Dirac's delta in the mode"
    CONTACT_LOAD = "contact load over time"
    LARGEST_LOAD = "largest contact load"

    # slip
    TOOTH_ACROSS = "forces on the tooth across the surface"
    TOOTH_ALONG = "forces on the tooth along the surface"
    SLIP_ACCELERATION = "acceleration of the slip"
    SLIP_LOAD = "load at which the tooth slips"
    TOOTH_AT_REST = "forces on the tooth without slip"
