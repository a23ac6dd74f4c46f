"""Inputs of a planting device fitted to a measured curve: of the support force, or of another total over a turn.

`reading` takes the file in, `curve` computes the same quantity with exact derivatives, `fit` finds the inputs and says
what the data determine, `calibration` does it for both models.
"""
