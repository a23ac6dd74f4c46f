"""From exact outlines to what a workshop takes: arcs within a tolerance, drawings, solids, meshes, tables."""
