"""Lane kernels: any CasADi function as a C loop over lanes (angles, designs, or both) in vector instructions."""

from __future__ import annotations

from planter.kernels.loops import interface
from planter.kernels.loops.graph import Graph, NotPrintable
from planter.kernels.loops.source import file, function, prototype

__all__ = ["Graph", "NotPrintable", "file", "function", "interface", "prototype"]
