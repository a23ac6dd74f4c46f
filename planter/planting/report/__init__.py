"""What a person gets to see and keep of a planting device: page, figures, files."""
