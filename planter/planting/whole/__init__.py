"""Designs with whole teeth of standard modules: pitch curves of given lengths as equations of the optimisation."""
