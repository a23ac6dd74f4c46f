"""Cams for rollers as parts: contour, limits, drawings and solids, whatever mechanism they move."""
