"""What an item says of itself besides its shape, as flat names and values, for formats with properties or columns."""

from __future__ import annotations

from typing import Any

from rgcore.model.records import Gateway, Line, MapObject, Note, Region

KINDS = ("region", "gateway", "line", "object", "note")
"""The kinds of items, in the order in which formats list them."""

Item = Region | Gateway | Line | MapObject | Note
Value = str | float | int | bool

_JOIN = " "


def flat(item: Item) -> dict[str, Value]:
    """Names and values, without None; lists are joined by spaces, class scores stand as ``score_TOMA``."""
    out = _own(item)
    p = item.provenance
    out["provenance"] = p.source
    out |= {k: v for k, v in (("by", p.by), ("at", p.at)) if v is not None}
    return {k: v for k, v in out.items() if v is not None}


def printable(text: str) -> str:
    """Text without the characters that XML cannot hold."""
    return "".join(c for c in text if c >= " " and not "\ud800" <= c <= "\udfff" and c not in "\ufffe\uffff")


def _own(item: Item) -> dict[str, Any]:
    if isinstance(item, Region):
        scores = {f"score_{k}": v for k, v in sorted(item.class_scores.items())}
        about = {"name": item.name, "class": item.class_, "accuracy": item.accuracy, "scans": item.scans}
        axes = {f"axis_{n}": a for n, a in enumerate(item.axes, 1)}
        (x, y), (length, width) = item.box.center, item.box.size
        box = {"box_x": x, "box_y": y, "box_length": length, "box_width": width, "box_yaw": item.box.yaw}
        return {**about, **axes, **box, **scores}
    if isinstance(item, Gateway):
        return {
            "name": item.name,
            "class": item.class_,
            "confidence": item.confidence,
            "regions": _JOIN.join(item.regions),
            "width": round(item.width, 6),
            "passed": item.passed,
        }
    if isinstance(item, Line):
        about = {"regions": _JOIN.join(item.regions), "support": item.support, "residual": item.residual}
        return {**about, "clutter": item.clutter}
    if isinstance(item, Note):
        return {"text": item.text, "item": item.item}
    x, y, z = item.center
    length, width, height = item.size
    return {
        "label": item.label,
        "confidence": item.confidence,
        "region": item.region,
        "x": x,
        "y": y,
        "z": z,
        "length": length,
        "width": width,
        "height": height,
        "yaw": item.yaw,
        "lines": _JOIN.join(item.lines),
    }
