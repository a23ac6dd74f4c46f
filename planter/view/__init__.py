"""Animated drawings of a mechanism for reports, notebooks and the studio."""
