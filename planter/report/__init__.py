"""Output of a run: figures, files and an HTML page.

`style` and `search` draw figures, `files`, `folder` and `bundle` write files, and `html` builds
pages. Matplotlib is imported when the first figure is drawn, not before.
"""
