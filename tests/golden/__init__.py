"""Results of all commands as they were before the engine, and how today's are compared with them."""
