"""The folder of a machine's tolerances: its figures and its page."""
