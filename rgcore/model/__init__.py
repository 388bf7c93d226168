"""What is the map and who changed what? Records, edits, history, projects."""
