"""Page, figures and files of a clutch's results."""
