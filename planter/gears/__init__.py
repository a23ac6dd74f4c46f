"""Toothed gears as results: what is found of them, the files that a workshop takes, and a page."""
