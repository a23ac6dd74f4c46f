"""What a person gets to see and keep of a seedling pick-up: page, figures, files."""
