"""What the clutch's commands return, key by key."""

from planter.clutch.results.engagement import ContactEngagement, ModalEngagement
from planter.clutch.results.field import FieldPlan, FieldTest
from planter.clutch.results.shape import ClutchGeometry, FastestSwitching, PolygonFit, Sizing

COMMANDS = {
    "clutch geometry": ClutchGeometry,
    "clutch design": Sizing,
    "clutch optimise": FastestSwitching,
    "clutch rotor": PolygonFit,
    "clutch engage": ModalEngagement | ContactEngagement,
    "clutch field": FieldTest,
    "clutch plan": FieldPlan,
}
