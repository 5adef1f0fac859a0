"""Flight envelopes: V_min and V_max, boundaries, grids, families, maps, and the thrust map."""
