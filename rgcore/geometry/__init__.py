"""The plane: poses, moments, segments, polygons, rasters. Knows nothing of robots."""
