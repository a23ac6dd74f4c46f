"""The recorded results of many commands, and how those of today are compared with them."""
