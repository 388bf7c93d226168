"""The map as JSON: all that it holds and what follows from it, one record a line, the same bytes for the same map.

``rgmap.schema.json`` beside this file describes it (JSON Schema 2020-12). :func:`read_json` reads it back without loss.
"""

from __future__ import annotations

import json
from importlib import resources
from math import hypot
from pathlib import Path
from typing import Any

import msgspec

from rgcore.errors import InputError
from rgcore.exports.options import Exported, Options
from rgcore.model.base import natural
from rgcore.model.records import Backdrop, Gateway, Ignored, Line, MapObject, Note, Region, RGMap, Source, Stats
from rgcore.slam.trajectory import Trajectory

FORMAT, VERSION = "rgmap", "1.0"
DECIMALS = 6
"""Micrometres and microradians: far below anything measured, and short enough to read."""

_COUNTED: dict[str, type] = {"lines": Line, "regions": Region, "gateways": Gateway, "objects": MapObject}
_KINDS: dict[str, type] = {**_COUNTED, "notes": Note, "ignored": Ignored, "backdrops": Backdrop}


class _Document(msgspec.Struct):
    """What is read back; everything else in a file follows from it."""

    source: Source
    stats: Stats
    lines: list[Line]
    regions: list[Region]
    gateways: list[Gateway]
    objects: list[MapObject]
    notes: list[Note] = []
    ignored: list[Ignored] = []
    backdrops: list[Backdrop] = []


def schema() -> dict[str, Any]:
    """The JSON Schema of the format."""
    text = resources.files(__package__).joinpath("rgmap.schema.json").read_text(encoding="utf-8")
    out: dict[str, Any] = json.loads(text)
    return out


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The map as JSON."""
    tree: dict[str, Any] = _tree(map)
    parts = []
    for key in sorted(tree):
        value = tree[key]
        if key in _KINDS and value:
            rows = ",\n".join(_line(row) for row in value)
            parts.append(f'"{key}": [\n{rows}\n]')
        else:
            parts.append(f'"{key}": {_line(value)}')
    lost = ("the files of floor plans: their names, checksums and places are kept",) if map.backdrops else ()
    return Exported(("{\n" + ",\n".join(parts) + "\n}\n").encode(), lost=lost)


def read_json(source: bytes | str | Path) -> RGMap:
    """The map of a file, or of its bytes, that :func:`render` wrote. Raises InputError, one line."""
    path = Path("map.json") if isinstance(source, bytes) else Path(source)
    try:
        data = source if isinstance(source, bytes) else path.read_bytes()
    except OSError as e:
        raise InputError(path, f"cannot be read: {e.strerror}") from e
    try:
        tree = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as e:
        raise InputError(path, f"not a JSON file: {e}") from e
    if not isinstance(tree, dict) or tree.get("format") != FORMAT:
        raise InputError(path, f'not an RG map: it lacks "format": "{FORMAT}"')
    major = str(tree.get("version")).partition(".")[0]
    if major != VERSION.partition(".")[0]:
        raise InputError(path, f"map version {tree.get('version')!s:.20}, this software reads {VERSION}; update it")
    try:
        document = msgspec.convert(tree, _Document)
    except msgspec.ValidationError as e:
        raise InputError(path, f"damaged map: {e}") from e
    return RGMap(
        source=document.source, stats=document.stats, **{k: _by_id(path, k, getattr(document, k)) for k in _KINDS}
    )


def _by_id(path: Path, kind: str, items: list[Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for item in items:
        if item.id in found:
            raise InputError(path, f"damaged map: two {kind} have the id {item.id}")
        found[item.id] = item
    return found


def _tree(map: RGMap) -> dict[str, Any]:
    rows = {kind: [_plain(v) for _, v in _sorted(getattr(map, kind))] for kind in _KINDS}
    for region in rows["regions"]:
        for kind, ids in _contents(map, region["id"]).items():
            region[kind] = sorted(ids, key=natural)
    for gateway in rows["gateways"]:
        gateway["width"] = _rounded(hypot(*(a - b for a, b in zip(*gateway["posts"], strict=True))))  # as written
    counts = {kind: len(rows[kind]) for kind in _COUNTED}
    return {
        "format": FORMAT,
        "version": VERSION,
        "frame": {"name": "map", "units": "m"},
        "source": msgspec.to_builtins(map.source),
        "stats": _plain(map.stats) | counts,
        **rows,
    }


def _contents(map: RGMap, region: str) -> dict[str, list[str]]:
    return {
        "lines": map.lines_of(region),
        "gateways": map.gateways_of(region),
        "objects": map.objects_of(region),
    }


def _sorted(items: dict[str, Any]) -> list[tuple[str, Any]]:
    return sorted(items.items(), key=lambda item: natural(item[0]))


def _plain(record: msgspec.Struct) -> dict[str, Any]:
    out: dict[str, Any] = _rounded(msgspec.to_builtins(record))
    return out


def _rounded(value: Any) -> Any:
    """The same with every float at the format's precision, and no negative zeros."""
    if isinstance(value, float):
        return round(value, DECIMALS) + 0.0
    if isinstance(value, dict):
        return {k: _rounded(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(v) for v in value]
    return value


def _line(value: Any) -> str:
    return json.dumps(value, sort_keys=True, ensure_ascii=False, allow_nan=False)
