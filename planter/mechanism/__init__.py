"""User-defined mechanisms: their generated functions over a cycle or in free motion."""
