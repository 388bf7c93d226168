"""One file a format that the map is written to."""
