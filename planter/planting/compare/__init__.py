"""All pairs of gear families, optimised alike: the same wide box, masses and requirements."""
