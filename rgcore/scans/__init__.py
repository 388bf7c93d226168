"""What did the laser see? Logs, their readers, the simulator, segments of single scans."""
