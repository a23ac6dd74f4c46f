"""What a person gets to see and keep of a synthesis or a gear train: page, figures, files."""
