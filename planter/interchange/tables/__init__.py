"""Motions and forces over time as files of other programs, each with a dictionary of its columns; a format a file."""
