"""The formats by name: each makes files of a motion."""

from __future__ import annotations

from collections.abc import Callable

from planter.interchange.tables import adams, plain, simulink, solidworks
from planter.interchange.tables.motion import Motion

FORMATS: dict[str, Callable[[Motion], dict[str, bytes]]] = {
    "adams": adams.files, "solidworks": solidworks.files, "simulink": simulink.files, "csv": plain.files,
}  # fmt: skip
"""Names and contents of files, made of a motion."""
