"""The machines of the four papers, each a package: file, model, results, commands, printed numbers."""
