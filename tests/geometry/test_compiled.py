"""Kernels on disk: found again by the next process, compiled anew after any change of any kernel's source."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CODE = """from rgcore.geometry.compiled import kernel
from part import part
@kernel
def whole(x):
    return part(x)
"""
PART = "from rgcore.geometry.compiled import inner\n@inner\ndef part(x):\n    return x + {}\n"


def answer(folder: Path) -> str:
    path = os.pathsep.join((str(folder / "rgcore" / "scans"), str(folder)))
    done = subprocess.run(
        [sys.executable, "-c", "import whole; print(whole.whole(1), sum(whole.whole.stats.cache_hits.values()))"],
        env={**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(folder / "cache")},
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,
    )
    return done.stdout.strip()


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    room = tmp_path / "rgcore" / "geometry"
    room.mkdir(parents=True)
    (tmp_path / "rgcore" / "__init__.py").touch()
    (room / "__init__.py").touch()
    (room / "compiled.py").write_bytes((ROOT / "rgcore/geometry/compiled.py").read_bytes())
    scans = tmp_path / "rgcore" / "scans"
    scans.mkdir()
    (scans / "whole.py").write_text(CODE, encoding="utf-8")
    (scans / "part.py").write_text(PART.format(1), encoding="utf-8")
    return tmp_path


def test_a_changed_inner_function_in_another_file_counts_at_once(copy: Path) -> None:
    assert answer(copy) == "2 0"
    assert answer(copy) == "2 1", "the second process compiled again"
    (copy / "rgcore/scans/part.py").write_text(PART.format(10), encoding="utf-8")
    assert answer(copy) == "11 0", "the second process ran the old code"
