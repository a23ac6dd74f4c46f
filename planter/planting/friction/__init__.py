"""True friction of a planting device's teeth: along the flanks where they touch, against the sliding."""
