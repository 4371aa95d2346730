"""One-channel rasters in tiles, and their connected components."""
