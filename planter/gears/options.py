"""Options of the commands that cut gears."""

from __future__ import annotations

import enum
from typing import Annotated

import typer


class Keep(enum.StrEnum):
    """Property of the gears that stays as designed: their size or their module."""

    size = "size"
    module = "module"


class CuttingProcessOption(enum.StrEnum):
    """Process by which the gears are cut."""

    hob = "hob"
    shaper = "shaper"
    wire = "wire"


ModuleOption = Annotated[
    float | None, typer.Option("--module", min=0.05, max=50, help="module [mm]", show_default=False)
]
Module1Option = Annotated[
    float | None,
    typer.Option("--module1", min=0.05, max=50, help="module of stage 1 [mm]", show_default=False),
]
Module2Option = Annotated[
    float | None,
    typer.Option("--module2", min=0.05, max=50, help="module of stage 2 [mm]", show_default=False),
]
TeethOption = Annotated[
    str | None,
    typer.Option(
        "--teeth",
        metavar="Z1,Z2",
        help="tooth counts of a gear of stage 1 and of stage 2 [default: the "
        "integer nearest to the pitch curve's length over pi m]",
        show_default=False,
    ),
]
KeepOption = Annotated[
    Keep | None,
    typer.Option(
        help="retain the designed size and adapt the module, or keep the module and scale the pair "
        "[default: the size with --teeth, else the module]",
        show_default=False,
    ),
]
PressureAngleOption = Annotated[
    float | None,
    typer.Option(
        min=10,
        max=35,
        help="pressure angle of the rack [deg] [default: the machine's, else 20]",
        show_default=False,
    ),
]
AddendumOption = Annotated[
    float | None,
    typer.Option(
        min=0.3,
        max=1.5,
        help="addendum of the rack in modules [default: the machine's, else 1]",
        show_default=False,
    ),
]
ClearanceOption = Annotated[float, typer.Option(min=0.02, max=0.6, help="clearance in modules")]
ShiftOption = Annotated[
    float | None,
    typer.Option(
        min=-1,
        max=1,
        help="profile shift of the first gear in modules, its mate's is the opposite [default: "
        "the machine's, else 0]",
        show_default=False,
    ),
]
TipRadiusOption = Annotated[
    float,
    typer.Option(
        min=0.01, max=1, help="tip radius of the rack in modules; a smaller one cuts a deeper root"
    ),
]
BacklashOption = Annotated[
    float,
    typer.Option(
        "--backlash-mm", min=0, max=10, help="circumferential backlash, shared by both gears"
    ),
]
CentreErrorOption = Annotated[
    float,
    typer.Option(
        "--centre-error-mm",
        min=0,
        max=5,
        help="also report lost motion and contact ratio for axes farther apart by this",
    ),
]
ProcessOption = Annotated[
    CuttingProcessOption,
    typer.Option(help="manufacturing process; a hob cannot cut concave pitch curves"),
]
UndercutOption = Annotated[bool, typer.Option("--allow-undercut", help="allow undercut flanks")]
ToleranceOption = Annotated[
    float, typer.Option("--tolerance-um", min=0.05, max=100, help="tolerance of the arcs")
]
BoreOption = Annotated[
    float | None,
    typer.Option("--bore-mm", min=0.5, max=1000, help="bore of every gear", show_default=False),
]
KeywayOption = Annotated[
    str | None,
    typer.Option(
        "--keyway-mm",
        metavar="WIDTH,DEPTH|none",
        help="keyway in the bore [default: DIN 6885-1's]",
        show_default=False,
    ),
]
WidthOption = Annotated[
    float, typer.Option("--width-mm", min=0.1, max=1000, help="width of the gears")
]
StepOption = Annotated[
    bool, typer.Option("--step", help="also solids in STEP (needs planter[step])")
]
StlOption = Annotated[bool, typer.Option("--stl", help="also solids in STL")]
