"""Mapping a log again from the browser, what becomes of the edits then, and what is different between two runs."""
