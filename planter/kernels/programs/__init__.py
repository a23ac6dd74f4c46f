"""Functions that work one after another on named numbers: evaluated here, or as C and WebAssembly that stand alone."""
