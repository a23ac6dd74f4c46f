"""Loops in single assignments: blocks that follow each other with equal operations, as equal bodies
have them.

From block to block the arguments of an operation advance by a constant number of assignments: by
a block, where they are computed in the loop; by nothing, where all blocks share them; or by any
other number through what was computed before the loop.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from planter.kernels.lane_graph import ArrayElement, LaneGraph

FEWEST = 4
"""Blocks that a loop has at least."""
GAIN = 24
"""Assignments that a loop spares at least."""
LONGEST = 400
"""Assignments that a block has at most."""
DEPTH = 3
"""Blocks that an argument lies back at most."""


@dataclass(frozen=True)
class Loop:
    """`count` blocks of `period` assignments from the number `first` on."""

    first: int
    period: int
    count: int

    @property
    def end(self) -> int:
        return self.first + self.period * self.count

    @property
    def gain(self) -> int:
        return self.period * (self.count - 1)


@dataclass(frozen=True)
class _Row:
    """An assignment: what it does, the assignments of its arguments, the index of its element."""

    key: tuple[object, ...]
    arguments: tuple[int, ...]
    index: int


class LoopFinder:
    """Assignments of a graph by number, with the `loops` among them, which do not overlap."""

    def __init__(self, graph: LaneGraph) -> None:
        self.places = {x.name: number for number, x in enumerate(graph.assignments)}
        self._rows = [*self._encode(graph)]
        self.loops = [*self._find_loops()]

    def _encode(self, graph: LaneGraph) -> Iterator[_Row]:
        for assignment in graph.assignments:
            source, names = assignment.source, assignment.arguments
            arguments = tuple(self.places[name] for name in names if name in self.places)
            constants = tuple(None if name in self.places else name for name in names)
            if isinstance(source, ArrayElement):
                yield _Row((source.name,), (), source.index)
            else:
                yield _Row((source.text, constants), arguments, 0)

    def _find_loops(self) -> Iterator[Loop]:
        number = 0
        while number < len(self._rows):
            longest = min(LONGEST, (len(self._rows) - number) // FEWEST)
            loops = [self._extend(number, period) for period in range(1, longest + 1)]
            best = max(loops, key=lambda loop: loop.gain, default=Loop(number, 1, 1))
            is_worth = best.count >= FEWEST and best.gain >= GAIN
            if is_worth:
                yield best
            number = best.end if is_worth else number + 1

    def _extend(self, first: int, period: int) -> Loop:
        """Return the longest loop from an assignment on."""
        rows, count = self._rows, 1
        if any(rows[first].key != rows[first + k * period].key for k in range(1, FEWEST)):
            return Loop(first, period, 1)
        while first + (count + 1) * period <= len(rows) and all(
            self._continues(first, period, count, offset) for offset in range(period)
        ):
            count += 1
        return Loop(first, period, count)

    def _continues(self, first: int, period: int, count: int, offset: int) -> bool:
        """Return whether an assignment of a block is that of the blocks before it, moved on."""
        start = first + offset
        begin, second, last, this = (
            self._rows[start + block * period] for block in (0, 1, count - 1, count)
        )
        if this.key != last.key or this.index - last.index != second.index - begin.index:
            return False
        arguments = zip(
            begin.arguments, second.arguments, last.arguments, this.arguments, strict=True
        )
        for base, follower, before, now in arguments:
            if now - before != follower - base:
                return False
            is_inside = now - before == period and base >= first - DEPTH * period
            if not is_inside and max(base, now) >= first:
                return False
        return True
