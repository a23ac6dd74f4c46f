"""What a person gets to see and keep: figures, files and a page for each run.

`figures` draws, `gearing` places pitch curves, `files` writes, `html` and `planting` make the page. Matplotlib is
imported when the first figure is drawn, not before.
"""
