"""What does a robot ask of the map? Where it is on it."""
