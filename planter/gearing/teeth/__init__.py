"""Rack teeth on pitch curves of any shape: exact outlines, their limits, and the proof that they mesh."""
