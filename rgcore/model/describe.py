"""Every edit as a table, made from the classes themselves: what ``docs/edits.md`` shows."""

from __future__ import annotations

import types
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta

from rgcore.model.edit import Edit
from rgcore.model.edits import EDITS

HEAD = """# Edits

Every correction of a map is one of these values. The browser, `rgviz edit` and Python make the same ones; each stands
in the journal as it stands here, can be undone, and is carried to the map of a new run.

    rgviz edit office.rg edits.jsonl        # one JSON object a line
    {"edit": "RenameRegion", "region": "r3", "name": "Lab"}

    from rgcore.model.edits import RenameRegion
    project.do(RenameRegion(region="r3", name="Lab"))

Metres and radians, map frame. A field with a default may be left out. Ids of what an edit makes are part of it
(`rgcore.model.fields.new_id` gives one); `rgcore.model.draft` makes edits from what a hand points at: it snaps to
walls, finds the regions on both sides, fits the box. An edit that the map refuses changes nothing and says why in a
sentence.

Made from the code by `python docs/make_edits.py`.
"""


def describe_edits() -> str:
    """The page, as Markdown."""
    parts: dict[str, list[str]] = {}
    for edit in EDITS.values():
        parts.setdefault(_subject(edit), []).append(_section(edit))
    return HEAD + "".join(f"\n## {subject}\n\n" + "\n".join(rows) for subject, rows in parts.items())


def _subject(edit: type[Edit]) -> str:
    stem = edit.__module__.rsplit(".", 1)[1].removeprefix("edits_")
    return {"edits": "Several at once", "review": "Review"}.get(stem, stem.capitalize())


def _section(edit: type[Edit]) -> str:
    hints = get_type_hints(edit, include_extras=True)
    rows = "".join(_row(f, hints[f.name]) for f in msgspec.structs.fields(edit))
    says = " ".join((edit.__doc__ or "").replace("``", "`").split())
    return f"### {edit.__name__}\n\n{says}\n\n| field | what it is | default |\n|---|---|---|\n{rows}"


def _row(field: Any, hint: Any) -> str:
    default = "" if field.required else f"`{msgspec.json.encode(field.default).decode()}`"
    return f"| `{field.encode_name}` | {_words(hint)} | {default} |\n"


def _words(hint: Any) -> str:
    """What the type of a field says of itself, less its "must be"."""
    if get_origin(hint) in (Union, types.UnionType):
        inner = next(a for a in get_args(hint) if a is not types.NoneType)
        return f"{_words(inner)}, or null"
    if get_origin(hint) is Annotated:
        bare, *metas = get_args(hint)
        says = next((m.description for m in metas if isinstance(m, Meta) and m.description), "")
        return says.removeprefix("must be ").removeprefix("must name ") or _words(bare)
    return "true or false" if hint is bool else str(hint)
