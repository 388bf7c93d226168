"""rgcore: Region & Gateway mapping as a library. No browser, no printing, no global state."""

__version__ = "0.1.0"
