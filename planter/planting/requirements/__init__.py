"""What a planting device must do in the field: requirements of a machine file as numbers with exact derivatives.

`section` says which there are, `measures` finds where each stands at a design and what it is there, `record` sets them
against their limits.
"""
