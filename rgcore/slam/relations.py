"""How accurate is a trajectory, judged by known relative poses (Kuemmerle et al. 2009).

A relation says where one pose of the robot truly lies, seen from another. Unlike an error of absolute poses, it does
not punish one early turn over and over. Reads the benchmark's own files: lines ``t1 t2 x y z roll pitch yaw``, or a
graph with lines ``EDGE2 i j x y theta``.

Reference: Kuemmerle et al.: On measuring the accuracy of SLAM algorithms, Autonomous Robots 27(4), 2009.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rgcore.errors import InputError
from rgcore.evidence import Evidence
from rgcore.geometry import se2
from rgcore.slam.trajectory import Trajectory

_SAME_STAMP = 0.02  # s: a relation's time is that of a scan
_SAME_ODOMETRY = 0.05  # s: the same of a row of odometry
_FAR_STAMP, _FAR_ROWS = 3.0, 15  # s, rows: odometry bridges no longer way than this from the nearest scan


@dataclass(frozen=True, eq=False)
class Relations(Evidence):
    """K known relative poses.

    pair     (K, 2) the two poses: times [s], rows of the odometry or, where ``by_scan``, numbers of scans
    true     (K, 3) the second, seen from the first
    """

    pair: np.ndarray
    true: np.ndarray
    by_scan: bool


@dataclass(frozen=True, eq=False)
class Odometry(Evidence):
    """Raw odometry between the scans: ``stamps`` (N,) s and ``poses`` (N, 3)."""

    stamps: np.ndarray
    poses: np.ndarray


@dataclass(frozen=True)
class RelationError:
    """Errors over the ``matched`` of all relations: translation [m] and absolute rotation [rad]."""

    relations: int
    matched: int
    trans_mean: float
    trans_std: float
    trans_median: float
    trans_max: float
    rot_mean: float
    rot_std: float
    rot_max: float


def read_relations(path: str | Path, loops_only: bool = False) -> Relations:
    """Relations from a file. ``loops_only``: of a graph, only those after ``#LOOP EDGES``. Raises InputError."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise InputError(path, f"cannot read the relations: {getattr(e, 'strerror', None) or 'not a text file'}") from e
    first = 1
    if loops_only and "#LOOP EDGES" in text:
        first += text[: text.index("#LOOP EDGES")].count("\n")
        text = text[text.index("#LOOP EDGES") :]
    graph = "EDGE2" in text
    rows = []
    for number, line in enumerate(text.splitlines(), first):
        words = line.split()
        if not words or words[0].startswith("#") or (graph and words[0] != "EDGE2"):
            continue
        try:
            v = [float(w) for w in words[1:6] if graph] or [float(words[k]) for k in (0, 1, 2, 3, 7)]
        except (ValueError, IndexError):
            raise InputError(
                path, "not a relation; expected `t1 t2 x y z roll pitch yaw` or `EDGE2 i j x y theta`", number
            ) from None
        rows.append(v)
    if not rows:
        raise InputError(
            path, "holds no relations; expected lines `t1 t2 x y z roll pitch yaw` or `EDGE2 i j x y theta`"
        )
    table = np.array(rows)
    return Relations(table[:, :2], table[:, 2:], graph)


def read_odometry(path: str | Path) -> Odometry:
    """Raw odometry from CSV columns time, (any), x, y, theta. Raises InputError."""
    says = "cannot read odometry; expected CSV columns time, any, x, y, theta"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a file without rows, which is told below
            table = np.loadtxt(path, delimiter=",", usecols=(0, 2, 3, 4), ndmin=2)
    except (OSError, ValueError, IndexError) as e:
        raise InputError(path, says) from e
    if not len(table):
        raise InputError(path, says)
    return Odometry(table[:, 0], table[:, 1:])


def relation_error(
    trajectory: Trajectory,
    relations: Relations,
    odometry: Odometry | None = None,
    rows: tuple[int, int] | None = None,
    forward: float = 0.0,
) -> RelationError:
    """Errors of the laser's poses over the relations whose two ends are known.

    odometry  bridges from the nearest scan to a pose between scans; without it a scan within 0.02 s is needed
    rows      (first, step): the relations name rows of the odometry; scan k is row max(0, first + k * step)
    forward   m, how far the relations' frame lies ahead of the laser's
    """
    poses = trajectory.map_from_laser
    if relations.by_scan:
        scans = relations.pair.astype(np.int64)
        known = (scans >= 0).all(1) & (scans < len(poses)).all(1)
        ends = [poses[np.clip(scans[:, k], 0, len(poses) - 1)] for k in (0, 1)]
    else:
        stamps = (
            trajectory.stamps
            if rows is None
            else np.maximum(0, rows[0] + rows[1] * np.arange(len(poses))).astype(float)
        )
        found = [_poses_at(stamps, poses, relations.pair[:, k], odometry, rows is not None) for k in (0, 1)]
        known = found[0][1] & found[1][1]
        ends = [f[0] for f in found]
    lever = np.array([forward, 0.0, 0.0])
    first, second = (se2.compose(e[known], lever) for e in ends)
    off = se2.relative(first, second) - relations.true[known]
    if not len(off):
        nan = float("nan")
        return RelationError(len(relations), 0, nan, nan, nan, nan, nan, nan, nan)
    trans, rot = np.hypot(off[:, 0], off[:, 1]), np.abs(se2.wrap(off[:, 2]))
    trans_figures = (float(f(trans)) for f in (np.mean, np.std, np.median, np.max))
    return RelationError(len(relations), len(off), *trans_figures, *(float(f(rot)) for f in (np.mean, np.std, np.max)))


def _poses_at(
    stamps: np.ndarray, poses: np.ndarray, wanted: np.ndarray, odometry: Odometry | None, by_row: bool
) -> tuple[np.ndarray, np.ndarray]:
    """(K, 3) poses at the wanted times or rows, and (K,) whether they are known."""
    order = np.argsort(stamps, kind="stable")
    stamps, poses = stamps[order], poses[order]
    scan, gap = _nearest(stamps, wanted)
    if odometry is None:
        return poses[scan], gap < _SAME_STAMP
    if by_row:
        since = se2.relative(odometry.poses[stamps[scan].astype(np.int64)], odometry.poses[wanted.astype(np.int64)])
        return se2.compose(poses[scan], since), gap < _FAR_ROWS
    order = np.argsort(odometry.stamps, kind="stable")
    raw, raw_poses = odometry.stamps[order], odometry.poses[order]
    (a, gap_a), (b, gap_b) = _nearest(raw, stamps[scan]), _nearest(raw, wanted)
    known = (gap_a < _SAME_ODOMETRY) & (gap_b < _SAME_ODOMETRY) & (gap < _FAR_STAMP)
    return se2.compose(poses[scan], se2.relative(raw_poses[a], raw_poses[b])), known


def _nearest(sorted_values: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) index of the nearest of the sorted values, and (K,) its distance."""
    if len(sorted_values) == 1:
        return np.zeros(len(wanted), np.int64), np.abs(sorted_values[0] - wanted)
    i = np.clip(np.searchsorted(sorted_values, wanted), 1, len(sorted_values) - 1)
    i = i - (np.abs(sorted_values[i - 1] - wanted) <= np.abs(sorted_values[i] - wanted))
    return i, np.abs(sorted_values[i] - wanted)
