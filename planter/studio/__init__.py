"""The studio: a page on this machine where a hand on a slider changes a machine and everything follows at once."""
