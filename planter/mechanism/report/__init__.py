"""The files that commands for mechanisms of one's own leave in a folder."""
