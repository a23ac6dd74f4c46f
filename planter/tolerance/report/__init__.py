"""Report of tolerances: figures and page."""
