"""Level sets of r and R: areas, basins, and how they split."""
