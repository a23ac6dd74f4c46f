"""Proof of a global optimum: enclosures of an objective over boxes of designs, and branch and bound
on them.
"""
