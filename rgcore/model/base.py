"""base.json: the map as the pipeline made it, one record a line (so that ``git diff`` reads well), without loss."""

from __future__ import annotations

import re
from typing import Any

import msgspec

from rgcore.model.history import KINDS
from rgcore.model.records import Backdrop, Gateway, Ignored, Line, MapObject, Note, Region, RGMap, Source, Stats

VERSION = 1


class _Base(msgspec.Struct, kw_only=True):
    version: int
    source: Source
    stats: Stats
    lines: list[Line]
    regions: list[Region]
    gateways: list[Gateway]
    objects: list[MapObject]
    notes: list[Note] = []
    ignored: list[Ignored] = []
    backdrops: list[Backdrop] = []


def natural(id: str) -> tuple[str, int, str]:
    """Sorting key of ids: l2 before l12, a person's after the pipeline's."""
    head, number = re.fullmatch(r"(\D*)(\d*).*", id, re.DOTALL).groups()  # type: ignore[union-attr]
    return head, int(number or 0), id


def encode_map(map: RGMap) -> bytes:
    """The map as JSON: keys sorted, records in the order of their ids. The same map gives the same bytes."""

    def part(name: str) -> str:
        value: Any = getattr(map, name)
        if name not in KINDS:
            return f'"{name}": {_json(value)}'
        rows = ",\n".join(_json(value[id]) for id in sorted(value, key=natural))
        return f'"{name}": [\n{rows}\n]' if rows else f'"{name}": []'

    parts = [part(name) for name in sorted(map.__struct_fields__)]
    return ("{\n" + ",\n".join([*parts, f'"version": {VERSION}']) + "\n}\n").encode()


def decode_map(data: bytes) -> RGMap:
    """The map that ``encode_map`` wrote. Raises msgspec.DecodeError or ValueError if the bytes are none."""
    b = msgspec.json.decode(data, type=_Base)
    if b.version > VERSION:
        raise ValueError(f"version {b.version} is newer than this rgviz reads ({VERSION})")
    kinds = {kind: {item.id: item for item in getattr(b, kind)} for kind in KINDS}
    return RGMap(source=b.source, stats=b.stats, **kinds)


def _json(value: Any) -> str:
    return msgspec.json.encode(value, order="sorted").decode()
