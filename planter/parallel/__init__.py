"""Parallel jobs of one task: in worker processes of this computer, or on a Dask cluster."""
