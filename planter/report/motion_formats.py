"""Formats of motions over time, from which the choices of the command, its help and the studio
follow.
"""

from __future__ import annotations

import enum


class MotionFormat(enum.StrEnum):
    """Formats by their names in commands, each with its purpose in words and the files that are
    written.

    `planter.exports.motion_tables` has the function of each.
    """

    purpose: str
    files: str

    def __new__(cls, name: str, purpose: str, files: str) -> MotionFormat:
        member = str.__new__(cls, name)
        member._value_, member.purpose, member.files = name, purpose, files
        return member

    csv = "csv", "as CSV", "motion.csv"
    adams = (
        "adams",
        "for Adams",
        "motion.cmd, which makes splines for AKISPL and CUBSPL (mm, N, N mm, deg, s)",
    )
    solidworks = (
        "solidworks",
        "for SolidWorks Motion",
        "a CSV file of time and value for each quantity, for motors and forces by data points",
    )
    simulink = "simulink", "for Simulink", "motion.mat for the block From File (SI, rad)"


def describe_motion_formats() -> str:
    """Return a sentence for each format."""
    return " ".join(f"{entry}: {entry.files}." for entry in MotionFormat)
