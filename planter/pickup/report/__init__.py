"""Page, figures and files of a seedling pick-up."""
