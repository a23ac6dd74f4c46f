"""How pages are made of the project's own records, and what this documentation adds to Sphinx (`extension`)."""
