"""What every symbol, file key, result key and column means: one dictionary, made of what says so already.

`symbols` reads what was generated, `inputs` the classes of files, `outputs` the schemas of results; `dictionary` puts
them together with what rooms say of their CSV files, the verdicts on equations and the figures that draw them.
"""
