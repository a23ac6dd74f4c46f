"""Files for manufacturing from exact outlines: arcs within a tolerance, drawings, solids, meshes,
tables.
"""
