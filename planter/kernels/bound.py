"""A loop over lanes on arrays that stay: prepared once, then a call costs a microsecond or two beside the loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from planter.kernels import finite
from planter.kernels.backends import Lanes
from planter.kernels.work import Array


def in_lanes(way: Lanes, inputs: Sequence[Array], outputs: Sequence[Array], count: int) -> Callable[[], bool]:
    """A call that writes the outputs and says whether all numbers are finite; with others, it may write nothing.

    Inputs are laid out as the loop takes them, outputs (height, width lanes) row by row.
    """
    memory = [
        output if elements.shape == output.shape else elements
        for elements, output in zip(way.memory(count), outputs, strict=True)
    ]
    matrices = [index for index, output in enumerate(outputs) if memory[index] is not output]
    loop = way.prepared(inputs, memory, count)
    strange_input, strange_output = finite.watch(inputs), finite.watch(memory)

    def call() -> bool:
        if strange_input():
            return False
        loop()
        return not strange_output()

    def call_for_matrices() -> bool:
        found = call()
        for index in matrices:
            outputs[index][:] = way.results(memory)[index]
        return found

    return call_for_matrices if matrices else call
