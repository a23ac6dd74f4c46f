"""Printed numbers of papers about mechanisms of one's own."""
