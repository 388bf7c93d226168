"""The first scans of the log that ships with rgviz, as a log of its own."""

from __future__ import annotations

import gzip
from pathlib import Path

from rgviz.demo import LOG


def short_log(path: Path, scans: int = 200) -> Path:
    with gzip.open(LOG, "rt", encoding="utf-8") as source:
        lines = []
        for line in source:
            lines.append(line)
            scans -= line.split(" ", 1)[0] in ("FLASER", "ROBOTLASER1", "RAWLASER1")
            if not scans:
                break
    path.write_text("".join(lines), encoding="utf-8")
    return path
