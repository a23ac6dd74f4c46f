"""Many rows of numbers, found a chunk at a time: on this machine's cores or on a cluster, kept as they come, gone on
with after a kill. What a row is, a machine's room says; this one knows no machine.
"""
