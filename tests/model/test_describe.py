"""The page about the edits says what the code does."""

from __future__ import annotations

from pathlib import Path

from rgcore.model.describe import describe_edits
from rgcore.model.edits import EDITS

PAGE = Path(__file__).parents[2] / "docs" / "edits.md"


def test_the_page_is_that_of_the_code() -> None:
    assert PAGE.read_text(encoding="utf-8") == describe_edits(), "run `python docs/make_edits.py`"


def test_every_edit_and_field_is_told_of() -> None:
    text = describe_edits()
    for name, edit in EDITS.items():
        section = text.split(f"### {name}\n")[1].split("###")[0]
        assert len(section.splitlines()[1]) > 15, "what it does"
        assert all(f"| `{f}` |" in section for f in edit.__struct_encode_fields__)
        assert "| typing" not in section
        assert "|  |  |" not in section
