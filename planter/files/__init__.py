"""Files of users: text, tables, units, values with their origins, every failure one sentence."""
