"""What the verbs say on the side."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path


def tell(log: Path, notes: Sequence[str]) -> None:
    """Notes on a file, one a line, where they do not mix with results."""
    for note in notes:
        print(f"{log}: {note}", file=sys.stderr)
