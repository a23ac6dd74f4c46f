"""What is claimed of a printed equation where it is repaired."""

from __future__ import annotations

from ...equations import Claim


class Repaired(Claim):
    """An equation as the motion has it, whatever its print says."""

    HOLDS = "({}) as the motion has it"
