"""Audit of papers: committed verdicts on equations and laws, recomputed numbers, and the
consequences.
"""
