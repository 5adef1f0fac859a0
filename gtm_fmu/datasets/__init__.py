"""Data sets of envelopes: cases, their results, the store on disk, computation by Dask."""
