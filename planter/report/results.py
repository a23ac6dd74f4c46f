"""Result of `planter animate`."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record

MEGABYTE = 10**6


@dataclass(frozen=True)
class Animated(Record):
    """`planter animate`: the file that was written with its size, and what moves in it, over how
    many frames in which time.
    """

    file: str
    machine: str
    model: str
    frames: int
    seconds: float
    bytes: int

    def describe(self) -> str:
        """Return the sentence that the terminal prints."""
        size = (
            f"{self.bytes / 1e6:.1f} MB" if self.bytes >= MEGABYTE else f"{self.bytes // 1000} kB"
        )
        return (
            f"{self.file}: {self.machine}, {self.frames} frames in "
            f"{self.seconds:.3g} s, {size}, {self.model} model."
        )


COMMANDS = {"animate": Animated}
