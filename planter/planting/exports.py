"""What commands write of a planting device."""

from planter.view.exports import Export, RequiredOption

FORMATS = {"csv": "as CSV", "adams": "for Adams", "solidworks": "for SolidWorks Motion", "simulink": "for Simulink"}
"""Formats of `planter export motion`, and in words."""
EXPORTS = (
    Export("report", "page, figures and tables of the cycle", ("simulate",), modelled=True),
    Export("optimum", "report comparing this design with its optimum", ("optimise",), modelled=True),
    Export("gears", "teeth of both stages (DXF, SVG, flanks as CSV), their mesh solved and checked", ("gears",)),
    Export("cam", "the cam's contour (DXF) and what it bears", ("cam",),
           asks=(RequiredOption("--roller-mm", "radius of the roller / mm", 6.0),)),
    Export("drive", "the carrier on a motor", ("drive",),
           asks=(RequiredOption("--stall-Nm", "torque at rest / N m", 6.0),
                 RequiredOption("--idle-rpm", "speed without torque / rpm", 42.0),
                 RequiredOption("--flywheel-kgm2", "flywheel / kg m\N{SUPERSCRIPT TWO}", 0.1))),
    *(Export(f"motion-{key}", f"motions and forces over time {words}", ("export", "motion"), ("--format", key),
             modelled=True) for key, words in FORMATS.items()),
    Export("c", "motions, forces, objective and gradient in C99", ("export", "c"), modelled=True),
    Export("cuda", "the objective of many designs in CUDA C++", ("export", "cuda"), modelled=True),
    Export("unit", "unit for co-simulation (FMI 2.0)", ("export", "fmu"), modelled=True, file="machine.fmu"),
)  # fmt: skip
