"""Designs of one kind of machine side by side: values, results, requirements and curves, and their
differences.
"""
