"""Every setting of a mapping, to be found by a word and set by a person; what may be written is judged here."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args, get_type_hints

import msgspec
from msgspec import Meta

from rgcore.config import Config, changed, load
from rgcore.model.folder import RunInfo

WITHOUT = ("localize",)
"""Stages whose settings do not change a map."""
SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}


@dataclass(frozen=True)
class Setting:
    """``bounds`` in words, e.g. "> 0, ≤ 1"; ``reason``: why the default is what it is."""

    name: str
    unit: str
    reason: str
    bounds: str
    default: Any


@cache
def settings() -> dict[str, Setting]:
    """All settings that change a map, by name, in the order of the stages."""
    out = {}
    default = Config()
    for stage in (s for s in default.__struct_fields__ if s not in WITHOUT):
        part = getattr(default, stage)
        hints = get_type_hints(type(part), include_extras=True)
        for field in part.__struct_fields__:
            meta = next((m for m in get_args(hints[field])[1:] if isinstance(m, Meta)), Meta())
            unit = str((meta.extra or {}).get("unit", ""))
            bounds = ", ".join(f"{sign} {v:g}" for k, sign in SIGNS.items() if (v := getattr(meta, k)) is not None)
            name = f"{stage}.{field}"
            out[name] = Setting(name, unit, meta.description or "", bounds, getattr(part, field))
    return out


def config_of(info: RunInfo) -> Config:
    """The settings of a run; the defaults where another version made it, with other settings."""
    try:
        return msgspec.convert(info.config, Config)
    except msgspec.ValidationError:
        return Config()


def search(text: str) -> list[Setting]:
    """Settings whose name, unit or reason holds every word; those with the words in their name first."""
    words = text.lower().split()
    found = [s for s in settings().values() if all(w in f"{s.name} {s.unit} {s.reason}".lower() for w in words)]
    return sorted(found, key=lambda s: not all(w in s.name for w in words))


def with_values(base: Config, values: Mapping[str, str]) -> Config:
    """``base`` with some settings as a person wrote them. Raises SettingError, which names setting and bounds."""
    own = [f"{name}={json.dumps(value)}" for name, value in changed(base).items()]
    return load(None, [*own, *(f"{name}={' '.join(text.split())}" for name, text in values.items())])


def value_of(config: Config, name: str) -> str:
    """A setting as a person reads and writes it."""
    stage, _, field = name.partition(".")
    return json.dumps(getattr(getattr(config, stage), field))
