"""Meanings of all symbols, file keys, result keys and columns in one dictionary.

`dictionary` combines the generated models, the classes of files, the columns of CSV files, the
verdicts on equations and the figures that draw a column with the result keys of `outputs`, which
reads the schemas of commands.
"""
