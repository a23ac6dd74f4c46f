"""Report of a synthesis or a gear train: page, figures, files."""
