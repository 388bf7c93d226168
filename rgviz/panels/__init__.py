"""The panels of one browser: map, lists, review and history on the left; commands and the inspector on the right."""

from rgviz.panels.panels import Panels

__all__ = ["Panels"]
