"""The stage cache: results by the key of what made them. Whatever is wrong with it, the stage is computed."""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import json
import os
import threading
import time
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np

import rgcore

T = TypeVar("T")

KEEP = 6
"""Results kept of each stage: enough to go back and forth between settings, not enough to fill a disk."""

_ROOMS = ("geometry", "scans", "slam", "lines", "places")


class Cache:
    """Results in a folder, one ``.npz`` each; ``Cache(None)`` keeps nothing."""

    def __init__(self, folder: str | Path | None) -> None:
        self.folder = Path(folder) if folder is not None else None

    def key(self, stage: str, *inputs: object) -> str:
        """SHA-256 (hex) over software, stage and inputs: settings structs, keys of other results, plain values."""
        h = hashlib.sha256(software().encode())
        for part in (stage, *inputs):
            data = msgspec.json.encode(part, order="deterministic")
            h.update(f"\0{type(part).__name__}\0{len(data)}\0".encode() + data)
        return h.hexdigest()

    def get(self, stage: str, key: str, compute: Callable[[], T]) -> T:
        """The kept result of ``key``, or that of ``compute``, which is then kept where possible."""
        if self.folder is None:
            return compute()
        file = self.folder / f"{stage}-{key[:32]}.npz"
        with contextlib.suppress(Exception):  # absent, torn, foreign, of another version: whatever it is, compute
            value: T = _load(file, key)
            os.utime(file)
            return value
        value = compute()
        with contextlib.suppress(OSError):  # full or read-only disk: go on without
            _store(file, key, value)
            _forget_old(self.folder, stage)
        return value


@lru_cache(maxsize=1)
def software() -> str:
    """Version of the software with a digest of the stages' source and weights: changed code never meets old results."""
    root = Path(rgcore.__file__).parent
    h = hashlib.sha256()
    rooms = (f for room in _ROOMS for f in (root / room).rglob("*") if f.suffix in (".py", ".npz"))
    for file in sorted([root / "evidence.py", root / "cache.py", *rooms]):
        h.update(file.read_bytes())
    return f"{rgcore.__version__}+{h.hexdigest()[:16]}"


def _store(file: Path, key: str, value: Any) -> None:
    arrays: list[np.ndarray] = []
    tree = json.dumps({"key": key, "value": _taken_apart(value, arrays)}).encode()
    named = {f"a{i}": a for i, a in enumerate(arrays)}
    file.parent.mkdir(parents=True, exist_ok=True)
    new = file.with_name(f".{file.stem}.{os.getpid()}.{threading.get_ident()}.tmp")
    try:
        with open(new, "wb") as f:
            np.savez_compressed(f, tree=np.frombuffer(tree, np.uint8), **named)  # type: ignore[arg-type]
        os.replace(new, file)
    finally:
        new.unlink(missing_ok=True)


def _load(file: Path, key: str) -> Any:
    with np.load(file, allow_pickle=False) as data:
        tree = json.loads(data["tree"].tobytes())
        if tree["key"] != key:
            raise ValueError("another result")
        return _put_together(tree["value"], data)


def _taken_apart(value: Any, arrays: list[np.ndarray]) -> Any:
    """``value`` as JSON, its arrays put into ``arrays``; {"kind": content} for all that JSON has no word for."""
    if value is None or isinstance(value, bool | int | float | str):
        return value.item() if isinstance(value, np.generic) else value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        if value.dtype.hasobject:
            raise TypeError("an array of Python objects cannot be cached")
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if isinstance(value, msgspec.Struct):
        return {"struct": _name(type(value)), "value": msgspec.to_builtins(value, enc_hook=lambda x: x.tolist())}
    if is_dataclass(value) and not isinstance(value, type):
        content = {f.name: _taken_apart(getattr(value, f.name), arrays) for f in fields(value)}
        return {"dataclass": _name(type(value)), "value": content}
    if isinstance(value, tuple | list):
        return {type(value).__name__: [_taken_apart(v, arrays) for v in value]}
    raise TypeError(f"a {type(value).__name__} cannot be cached")


def _put_together(tree: Any, arrays: Any) -> Any:
    if not isinstance(tree, dict):
        return tree
    kind, content = next(iter(tree.items()))
    if kind == "array":
        return arrays[f"a{content}"]
    if kind == "struct":
        return msgspec.convert(tree["value"], _type(content, msgspec.Struct))
    if kind == "dataclass":
        made = {k: _put_together(v, arrays) for k, v in tree["value"].items()}
        return _type(content, object)(**made)
    items = [_put_together(v, arrays) for v in content]
    return tuple(items) if kind == "tuple" else items


def _name(type_: type) -> str:
    return f"{type_.__module__}:{type_.__qualname__}"


def _type(name: str, base: type) -> Any:
    """A record or evidence type of rgcore by its name; nothing else can be named by a cache file."""
    module, _, attribute = name.partition(":")
    if not module.startswith("rgcore."):
        raise ValueError(name)
    found = getattr(importlib.import_module(module), attribute)
    if not (isinstance(found, type) and issubclass(found, base) and (is_dataclass(found) or base is msgspec.Struct)):
        raise ValueError(name)
    return found


def _forget_old(folder: Path, stage: str) -> None:
    files = sorted(folder.glob(f"{stage}-*.npz"), key=lambda f: f.stat().st_mtime, reverse=True)
    killed = [f for f in folder.glob(".*.tmp") if f.stat().st_mtime < time.time() - 3600]  # writers that never finished
    for file in [*files[KEEP:], *killed]:
        file.unlink(missing_ok=True)
