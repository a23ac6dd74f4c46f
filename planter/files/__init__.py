"""Files that a user hands in: text, tables, units, values with their origins, every failure one sentence."""
