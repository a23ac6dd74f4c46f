"""The studio: an interactive page in the browser where drawing, curves and results follow sliders at once."""
