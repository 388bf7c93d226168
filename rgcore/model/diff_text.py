"""A diff for people (text), for pull requests (Markdown) and for programs (JSON)."""

from __future__ import annotations

from typing import Any

import msgspec

from rgcore.model.diff import Diff
from rgcore.model.difference import Difference

TITLES = {"regions": "Regions", "gateways": "Gateways", "lines": "Walls", "objects": "Objects"}
_MARK = {"green": "+", "red": "-", "amber": "~"}


def as_text(diff: Diff) -> str:
    """Some lines for a terminal: a heading a kind, a line a difference with its place."""
    out = [f"frames: {diff.frame}"]
    for kind, title in TITLES.items():
        some = [d for d in diff.differences if d.kind == kind]
        if some:
            out.append(f"{title}: {_counts(diff, some, kind)}")
            out += [f"  {_MARK[d.colour]} {d.what} {d.text}  at ({d.place[0]:.2f}, {d.place[1]:.2f})" for d in some]
    if not diff:
        out.append("no difference")
    return "\n".join(out)


def as_markdown(diff: Diff) -> str:
    """The same as Markdown, a table a kind."""
    out = ["# Map diff", "", f"Frames: {diff.frame}.", ""]
    for kind, title in TITLES.items():
        some = [d for d in diff.differences if d.kind == kind]
        if some:
            out += [f"## {title}: {_counts(diff, some, kind)}", "", "| | what | which | at |", "|---|---|---|---|"]
            out += [
                f"| {_MARK[d.colour]} | {d.what} | {_plain(d.text)} | {d.place[0]:.2f}, {d.place[1]:.2f} |"
                for d in some
            ]
            out.append("")
    if not diff:
        out.append("No difference.")
    return "\n".join(out).rstrip() + "\n"


def as_json(diff: Diff) -> str:
    """The same as JSON, with the colour of each difference."""
    rows = [{**_row(d), "colour": d.colour} for d in diff.differences]
    tree: dict[str, Any] = {**msgspec.to_builtins(diff), "differences": rows}
    return msgspec.json.format(msgspec.json.encode(tree, order="sorted"), indent=1).decode()


def _row(d: Difference) -> dict[str, Any]:
    row: dict[str, Any] = msgspec.to_builtins(d)
    return row


def _counts(diff: Diff, some: list[Difference], kind: str) -> str:
    counts = [f"{diff.count(kind, what)} {what}" for what in dict.fromkeys(d.what for d in some)]
    if kind == "lines":
        counts = [c for c in counts if not c.endswith(("added", "removed"))]
        counts = [f"{diff.walls_added:.1f} m added", f"{diff.walls_removed:.1f} m removed", *counts]
    return ", ".join(counts)


def _plain(text: str) -> str:
    """Text that does not break a table or turn into markup."""
    for c in "\\`*_|<>[]#":
        text = text.replace(c, f"\\{c}")
    return text
