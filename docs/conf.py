"""How Sphinx builds this documentation: `make docs`, without a network, every warning an error."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from planter.version import __version__  # noqa: E402

project = "planter"
author = copyright = "The planter authors"
version = release = __version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "book.extension"]
html_theme = "pydata_sphinx_theme"
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "header_links_before_dropdown": 7,
}
html_sidebars = {
    "**": []
}  # only the gallery has pages below it, and its index lists them; code needs the width
html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["book.css"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
html_title = f"planter {version}"
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
highlight_language = "text"
default_role = "code"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
exclude_patterns = ["examples"]
