"""What a person gets to see and keep of a clutch: page, figures, files."""
