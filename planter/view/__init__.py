"""A mechanism in motion: one drawing for reports, notebooks and the studio."""
