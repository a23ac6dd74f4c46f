"""Report of a sweep: rows, figures and page."""
