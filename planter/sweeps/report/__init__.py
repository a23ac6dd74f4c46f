"""The folder of a sweep: its rows, its figures and its page."""
