"""What the clutch's commands return, key by key."""

from planter.clutch.results.engagement import ContactEngagement, ModalEngagement
from planter.clutch.results.field import FieldTest, Plan
from planter.clutch.results.rotor import Fit
from planter.clutch.results.shape import FastestSwitching, Geometry, Sizing

COMMANDS = {
    "clutch geometry": Geometry,
    "clutch design": Sizing,
    "clutch optimise": FastestSwitching,
    "clutch rotor": Fit,
    "clutch engage": ModalEngagement | ContactEngagement,
    "clutch field": FieldTest,
    "clutch plan": Plan,
}
