"""Files, figures and the page of a set of toothed gears."""
