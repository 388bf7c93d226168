"""Tools: what the hand holds. Each is a plain value; clicks, moves and keys turn it into the next one (``tool.py``)."""
