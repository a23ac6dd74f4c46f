"""`python -m planter` is the `planter` command."""

from planter.cli import main

main()
