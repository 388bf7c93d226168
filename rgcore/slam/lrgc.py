"""LRGC: local registration and global correlation (Gutmann & Konolige 2000)."""

from __future__ import annotations

from rgcore.config import Slam
from rgcore.progress import Watcher, silent
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


def lrgc(log: ScanLog, settings: Slam, watch: Watcher = silent) -> Trajectory:
    """Consistent poses of all scans of a log."""
    raise NotImplementedError
