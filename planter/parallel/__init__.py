"""Jobs of one task in parallel: by processes of this computer, or by the workers of a Dask cluster."""
