"""Write docs/edits.md anew: the table of all edits."""

from pathlib import Path

from rgcore.model.describe import describe_edits

Path(__file__).with_name("edits.md").write_text(describe_edits(), encoding="utf-8")
