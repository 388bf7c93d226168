"""A report of a map: one page that tells how compact and how true it is, written so that it could go into a paper.

It is of the corrected map. Table I and figure 6 are those of the paper; all that the page shows lies in it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rgcore.exports import report_page as page
from rgcore.exports import svg
from rgcore.exports.options import Options
from rgcore.geometry import se2
from rgcore.geometry.polygons import locate, polygon
from rgcore.geometry.raycast import cast
from rgcore.model.base import natural
from rgcore.model.folder import KeptSegments
from rgcore.model.project import Project
from rgcore.model.records import Region, RGMap

LARGEST = 3
"""Regions that are shown before and after."""
ENOUGH = 20
"""Scans: fewer taken in a region are not enough evidence of how true it is (one glimpse agrees with itself)."""
CELL = 0.05
"""m, of the occupancy grid that the map is compared with"""
AGAIN = "This run was made by an older version, which kept no segments; map the log again for what is missing here."


class Fit(NamedTuple):
    """How echoes agree with the lines; all nan where there are no echoes. Shares are of all echoes."""

    echoes: int
    median: float
    within_5: float
    within_10: float
    missed: float


def report(project: Project) -> str:
    """The page as HTML. Raises ProjectError where a file of the run is damaged."""
    return page.page(f"{project.name} · RG map", _body(project))


def _body(project: Project) -> Iterator[str]:
    m, kept = project.map, project.segments
    regions = sorted(m.regions.values(), key=lambda r: natural(r.id))
    shapes = [polygon(r.boundary, r.holes) for r in regions]
    where = locate(shapes, project.trajectory.map_from_base[:, :2])
    difference, scan_of_echo = differences(project, kept)
    yield from _head(project, fit(difference, m))
    drawing = svg.render(m, project.trajectory, Options()).data.decode()
    edits = len(project.history.done)
    corrected = f" The map holds {edits} correction{'s'[: edits != 1]} made by hand." if edits else ""
    yield page.figure(drawing, f"Figure 1. RG map of {project.name}.{corrected}", "sheet")
    yield page.heading("Compactness")
    yield page.paragraph(
        "A segment is a straight piece of a single scan; lines are what all segments merge to. A region counts the "
        "scans taken in it, their readings and segments, and the lines that are part of its description, also those "
        "seen through its gateways: a line may count in several regions."
    )
    yield _table_1(m, regions, where, kept)
    yield from _before_after(m, regions, shapes, where, kept)
    yield from _bytes(m, kept)
    yield page.heading("Accuracy")
    yield _accuracy(m, regions, where, difference, scan_of_echo)
    yield from _adaptation(project)
    yield from _trajectory(project)
    yield from _making(project)


def _head(project: Project, fit: Fit) -> Iterator[str]:
    m, info = project.map, project.run_info
    yield page.heading(project.name, 1)
    yield page.paragraph(f"RG map of the log {info.log}, made by {info.software}", pale=True)
    yield page.cards(
        [
            (f"{m.stats.scans:,}", "scans"),
            (f"{m.stats.segments:,} → {len(m.lines):,}", "segments of scans to lines of the map"),
            (f"{_factor(m.stats.segments, len(m.lines))}×", "fewer lines"),
            (_mm(m.stats.accuracy), f"acc(R), penalty {_metres(m.stats.accuracy_penalty)}"),
            (_percent(fit.within_10), "of the readings within 10 cm"),
            (f"{len(m.regions)} · {len(m.gateways)}", "regions · gateways"),
        ]
    )


def _table_1(m: RGMap, regions: list[Region], where: np.ndarray, kept: KeptSegments | None) -> str:
    def row(name: str, scans: int, points: object, segments: int | None, lines: int) -> tuple[object, ...]:
        return (name, scans, points, "-" if segments is None else segments, lines, _factor(segments, lines))

    rows: list[tuple[object, ...]] = [
        (*row("building", m.stats.scans, m.stats.points, m.stats.segments, len(m.lines)), "", "", "", "")
    ]
    for i, r in enumerate(regions):
        points: object = "-"
        segments = None
        if kept is not None:
            points, segments = int(kept.readings[where == i].sum()), int((where[kept.scan] == i).sum())
        axes = [f"{round(math.degrees(a)) % 180}°" for a in r.axes] + ["", ""]
        about = (r.class_, axes[0], axes[1], _mm(r.accuracy))
        rows.append((*row(_named(r), r.scans, points, segments, len(m.lines_of(r.id))), *about))
    rows[0] = (*rows[0][:-1], _mm(m.stats.accuracy))
    heads = (
        "",
        "# scans",
        "# points",
        "# lines of scans",
        "# RG lines",
        "factor",
        "class",
        "axis 1",
        "axis 2",
        "acc(R)",
    )
    return page.table("table1", "Table I. Reduction of complexity, class, main axes and accuracy.", heads, rows, sums=1)


def _before_after(
    m: RGMap, regions: list[Region], shapes: list, where: np.ndarray, kept: KeptSegments | None
) -> Iterator[str]:
    if kept is None:
        yield page.paragraph(AGAIN, pale=True)
        return
    lines = np.array([(v.start, v.end) for v in m.lines.values()]).reshape(-1, 2, 2)
    if not len(lines):
        return
    ends = kept.ends.astype(float)
    low, high = lines.min((0, 1)) - 0.5, lines.max((0, 1)) + 0.5
    inside = ((ends > low) & (ends < high)).all((1, 2))
    yield page.figure(
        page.strokes(ends[inside], low, high, "before", f"{m.stats.segments:,} segments of {m.stats.scans:,} scans")
        + page.strokes(lines, low, high, "after", f"{len(lines):,} lines"),
        "Figure 2. Before and after. All segments of all scans at the poses found, and the lines that they merge to.",
        "pair",
    )
    count = np.array([(where[kept.scan] == i).sum() for i in range(len(regions))])
    for number, i in enumerate(np.argsort(-count, kind="stable")[:LARGEST]):
        r, seen = regions[i], where[kept.scan] == i
        own = np.array([(m.lines[k].start, m.lines[k].end) for k in m.lines_of(r.id)]).reshape(-1, 2, 2)
        if not len(own) or not seen.any():
            continue
        ring = np.array(r.boundary)
        low, high = ring.min(0) - 1.0, ring.max(0) + 1.0
        near, inner = _touching(ends, low, high) & seen, _touching(own, low, high)
        yield page.figure(
            page.strokes(
                _clipped(ends[near], low, high), low, high, "before", f"{near.sum():,} segments, {r.scans} scans"
            )
            + page.strokes(_clipped(own[inner], low, high), low, high, "after", f"{inner.sum()} lines"),
            f"Figure {3 + number}. {_named(r)}. Segments of the scans taken in it, and its lines; {r.class_}.",
            "pair",
        )


def _touching(ends: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(K,) whether pieces (K, 2, 2) may reach into a box."""
    return ((ends.max(1) > low) & (ends.min(1) < high)).all(1)


def _clipped(ends: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The pieces with what lies outside of a box cut off (Liang & Barsky 1984); those outside vanish."""
    a, d = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.stack([(low - a) / d, (high - a) / d])
    t = np.where(d == 0.0, np.array([-np.inf, np.inf])[:, None, None], t)
    first, last = np.maximum(t.min(0).max(1), 0.0), np.minimum(t.max(0).min(1), 1.0)
    keep = first < last
    out = a[keep, None] + np.stack([first, last], 1)[keep, :, None] * d[keep, None]
    return np.asarray(out)


def _bytes(m: RGMap, kept: KeptSegments | None) -> Iterator[str]:
    points = np.array([p for v in m.lines.values() for p in (v.start, v.end)]).reshape(-1, 2)
    if not len(points):
        return
    cells = int(np.prod(np.ceil((points.max(0) - points.min(0)) / CELL) + 1))
    lines = 16 * len(m.lines)
    rows = [("lines of the map, four 4-byte numbers each", lines)]
    if kept is not None:
        rows.append(("lines of all scans, four 4-byte numbers each", 16 * m.stats.segments))
    rows.append((f"occupancy grid of {100 * CELL:g} cm over its extent, 2 bits a cell, packed", cells // 4))
    if kept is not None:
        rows.append(("the bare scans, 2 bytes a reading, compressed (the log without its text)", kept.deflated))
    yield page.table(
        "bytes",
        "Table II. Size of the map against other representations.",
        ("representation", "bytes", "times the map"),
        [(what, f"{size:,}", f"{size / lines:.1f}") for what, size in rows],
        sums=1,
    )


def differences(project: Project, kept: KeptSegments | None) -> tuple[np.ndarray, np.ndarray]:
    """(K,) [m] predicted less measured range of the readings of the scans that a run keeps, and the scan (K,) of each.

    The lines of the corrected map are projected back into the scans; inf where a beam meets none.
    """
    if kept is None:
        return np.zeros(0), np.zeros(0, np.int64)
    lines = np.array([(v.start, v.end) for v in project.map.lines.values()]).reshape(-1, 2, 2)
    reach = float(project.run_info.config.get("accuracy", {}).get("max_range", 12.0))
    poses = project.trajectory.map_from_laser[kept.sample]
    predicted = cast(lines, poses, kept.bearings, reach + 1.0)[0]
    row, beam = np.nonzero((kept.ranges > 0) & (kept.ranges < reach))
    return predicted[row, beam] - kept.ranges[row, beam], kept.sample[row]


def fit(difference: np.ndarray, m: RGMap) -> Fit:
    if not len(difference):
        return Fit(0, math.nan, math.nan, math.nan, math.nan)
    off = np.abs(difference)
    found = off <= (m.stats.accuracy_penalty or 1.0)
    median = float(np.median(off[found])) if found.any() else math.nan
    return Fit(len(off), median, *(float(x.mean()) for x in (off <= 0.05, off <= 0.1, ~found)))


def fits(project: Project) -> tuple[Fit | None, dict[str, Fit | None]]:
    """How readings agree with the corrected map, for the building and by region; None: not enough evidence.

    That are fewer than ``ENOUGH`` scans taken there. Raises ProjectError where a file of the run is damaged.
    """
    m = project.map
    difference, scan = differences(project, project.segments)
    regions = list(m.regions.values())
    where = locate([polygon(r.boundary, r.holes) for r in regions], project.trajectory.map_from_base[:, :2])
    own = {r.id: _known(fit(difference[where[scan] == i], m), int((where == i).sum())) for i, r in enumerate(regions)}
    return _known(fit(difference, m), m.stats.scans), own


def _known(found: Fit, scans: int) -> Fit | None:
    return found if scans >= ENOUGH and found.echoes else None


def _accuracy(
    m: RGMap, regions: list[Region], where: np.ndarray, difference: np.ndarray, scan_of_echo: np.ndarray
) -> str:
    def row(name: str, accuracy: float | None, fit: Fit) -> tuple[object, ...]:
        median = "-" if math.isnan(fit.median) else f"{1000 * fit.median:.0f} mm"
        shares = map(_percent, (fit.within_5, fit.within_10, fit.missed))
        return (name, _mm(accuracy), f"{fit.echoes:,}", median, *shares)

    rows = [row("building", m.stats.accuracy, fit(difference, m))]
    here = where[scan_of_echo]
    for i, r in enumerate(regions):
        enough = int((where == i).sum()) >= ENOUGH
        rows.append(row(_named(r), r.accuracy if enough else None, fit(difference[(here == i) & enough], m)))
    p = _metres(m.stats.accuracy_penalty)
    caption = (
        f"Table III. Accuracy by back-projection. acc(R): root mean square over scans, each reading that no line "
        f"predicts within {p} costs {p}, over all readings of the run. Median and shares are those of the map as it "
        "stands here, with its corrections, over the readings of a sample of the scans; "
        f"regions with fewer than {ENOUGH} scans are no evidence."
    )
    heads = ("", "acc(R)", "readings", "median", "within 5 cm", "within 10 cm", "missed")
    return page.table("accuracy", caption, heads, rows, sums=1)


def _adaptation(project: Project) -> Iterator[str]:
    fitted = project.adaptation
    if fitted is None:
        return
    yield page.heading("Adaptation")
    yield page.paragraph(
        "Each region takes the parameters of merging with which the finished map predicts its scans best at a price of "
        f"{fitted.price:g} readings a line, chosen by projecting the lines that a setting gives back into scans. "
        f"Regions whose acc(R) exceeds {_mm(fitted.goal)} pay less for a line where that brings them there."
    )
    points = [(float(x), 1000.0 * y) for x, y in zip(fitted.map.lines, fitted.map.accuracy, strict=True)]
    marks = [(*points[0], "mark", "as configured"), (*points[fitted.map.chosen], "best", "best single setting")]
    if fitted.map.chosen == 0:
        marks = [(*points[0], "best", "as configured: the best single setting")]
    yield page.figure(
        page.scatter(points, marks, "lines of the map", "error of the readings in mm"),
        f"Figure {3 + LARGEST}. Compactness against accuracy. Finished maps of a sample of the scans, every "
        "setting that was tried taken for all regions alike; the curve joins those that none beats on both axes.",
        "plot",
    )
    names = {f"r{i + 1}": c for i, c in enumerate(fitted.regions[:-1])}
    rows = []
    for r in sorted(project.base.regions.values(), key=lambda r: natural(r.id)):
        if c := names.get(r.id):
            t = fitted.tried[c.chosen]
            name = _named(project.map.regions.get(r.id, r))
            distance, gap = (f"{100 * t[k]:.1f} cm" for k in ("distance", "gap"))
            rows.append((name, distance, gap, f"{t['ratio']:g}", f"{t.get('price', fitted.price):g}", c.scans))
    heads = ("", "distance", "gap γ", "ratio ρ", "readings a line", "scans that see it")
    yield page.table("adapted", "Table IV. Parameters that each region takes.", heads, rows)


def _trajectory(project: Project) -> Iterator[str]:
    t, info = project.trajectory, project.run_info
    step = np.diff(t.map_from_base, axis=0)
    way = float(np.hypot(step[:, 0], step[:, 1]).sum()) if len(step) else 0.0
    turned = float(np.abs(se2.wrap(step[:, 2])).sum()) if len(step) else 0.0
    stamps = t.stamps[np.isfinite(t.stamps)]
    duration = float(stamps.max() - stamps.min()) if len(stamps) else 0.0
    rows = [
        ("scans", f"{info.scans:,} of {info.beams} beams"),
        ("way driven", f"{way:.1f} m"),
        ("turned", f"{turned / (2 * math.pi):.1f} turns"),
        ("time from first to last stamp", f"{duration:.0f} s"),
        ("odometry", "raw odometry of the log" if info.has_odometry else "none in the log"),
        ("scans that could not be joined to the one before", len(t.breaks)),
    ]
    yield page.heading("Trajectory")
    yield page.table("trajectory", "Table V. The robot's way.", ("", ""), rows)
    for note in info.notes:
        yield page.paragraph(note, pale=True)


def _making(project: Project) -> Iterator[str]:
    info = project.run_info
    yield page.heading("How it was made")
    rows: list[tuple[object, ...]] = [("software", info.software), ("log", f"{info.log} ({info.format})")]
    rows.append(("SHA-256 of the log", info.sha256))
    rows += [(f"setting {name}", value) for name, value in sorted(info.settings.items())]
    if not info.settings:
        rows.append(("settings", "the defaults"))
    rows.append(("time", " · ".join(f"{k} {v:.1f} s" for k, v in info.seconds.items())))
    yield page.table(
        "making", "Table VI. Software, log and settings that differ from the defaults.", ("", ""), rows, text=2
    )


def _named(r: Region) -> str:
    return f"{r.name} ({r.id})" if r.name else r.id


def _factor(segments: int | None, lines: int) -> str:
    return "-" if not segments or lines == 0 else f"{segments / lines:.1f}"


def _mm(metres: float | None) -> str:
    return "-" if metres is None else f"{1000 * metres:.0f} mm"


def _metres(value: float | None) -> str:
    return "-" if value is None else f"{value:g} m"


def _percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100 * share:.1f} %"
