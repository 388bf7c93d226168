"""Where was the robot? Local registration and global correlation (LRGC)."""
