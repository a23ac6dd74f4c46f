"""Benchmarks: the same task by each way to evaluate a cycle, in one process, interleaved, after all
have agreed.
"""
