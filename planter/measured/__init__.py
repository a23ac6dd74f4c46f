"""Inputs of a machine fitted to a measured curve of any of its quantities over a turn.

`reading` takes the file in, `curve` computes the same quantity with exact derivatives, `fit` finds
the inputs and says what the data determine, `calibration` does it for each model of a machine.
"""
