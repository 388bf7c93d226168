"""Where are the walls? Line distance, merging with moments, accuracy."""
