"""The studio: an interactive page in the browser, where sliders update drawing, curves and results
immediately.
"""
