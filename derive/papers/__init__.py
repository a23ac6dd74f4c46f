"""Papers as data, each a module: ``PAPER``, its equations as they stand in print, and ``CASE``,
what tries them.
"""
