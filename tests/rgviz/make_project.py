"""Projects of synthetic maps, for tests of the app: a run without the mapping."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
from office_map import office_map, points_of

from rgcore.config import Config
from rgcore.model.project import Project
from rgcore.model.records import RGMap
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


def make_project(path: Path, map_: RGMap | None = None) -> Path:
    """A closed project of this map; its log holds the points of the map as one scan a metre of the way."""
    map_ = map_ or office_map()
    Project.create(path, synthetic_run(map_)).close()
    return path


def synthetic_run(map_: RGMap) -> SimpleNamespace:
    """As much of a ``Run`` as a project keeps."""
    hall = next(r for r in map_.regions.values() if r.class_ == "CDMA")
    (x0, y), (x1, _) = hall.boundary[0], hall.boundary[1]
    poses = np.array([[x, y + 1.0, 0.0] for x in np.arange(x0, x1, 0.5)])
    ranges = np.full((len(poses), 181), np.nan)
    d = points_of(map_)[None] - poses[:, None, :2]
    for n, ray in enumerate(d):
        bearing = np.degrees(np.arctan2(ray[:, 1], ray[:, 0]))
        beam = np.round(bearing).astype(int) + 90
        far = np.hypot(*ray.T)
        for b in range(181):
            near = far[beam == b]
            ranges[n, b] = near.min() if len(near) else np.inf
    stamps = np.arange(len(poses), dtype=float)
    bearings = np.radians(np.arange(-90.0, 91.0))
    name = {"source": "office.log", "sha256": "0" * 64, "format": "carmen"}
    log = ScanLog(stamps, ranges, poses, bearings, np.zeros(3), 30.0, **name)  # type: ignore[arg-type]
    return SimpleNamespace(
        log=log,
        config=Config(),
        trajectory=Trajectory(stamps, poses, np.zeros(3)),
        map=map_,
        adaptation=None,
        segments=None,
        seconds={"slam": 1.0},
    )
