"""A mechanism of one's own: the functions that were generated of its statement, over a turn."""
