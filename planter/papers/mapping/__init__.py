"""Gear trains by kinematic mapping: from poses to dyads, linkages, an angle curve and two pairs of
pitch curves.
"""
