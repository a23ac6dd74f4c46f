"""The engine: machines as values and functions, their responses with derivatives, measures, and
rows of machines.
"""
