"""Regions: the free space between the gateways."""

from __future__ import annotations

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry import polygons, se2
from rgcore.geometry.grid import Grid, clearance, components, dilate, draw_lines, erode, grow, reach
from rgcore.places.chords import find_chords
from rgcore.places.freespace import FreeSpace
from rgcore.places.gateways import KINDS, Hypotheses, judge, point
from rgcore.places.places import FoundGateway, FoundRegion, Places
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

MIN_PASSES, MAX_HIT_SHARE = 2, 0.25
"""A cell is free if that many beams went through it and at most this share of all its beams ended in it."""


NO_ROOM, ROOM = 1.2, 1.9
"""A gap in a wall with nothing wider near it than so many times its width only divides a hallway; and so does a
hallway's mouth unless something as wide as a room lies behind it."""


HALLWAY = 3.5
"""m: no hallway is wider."""

THIN, DOORWAY = 0.5, 1.7
"""m: the wall between two doors is at most so thick, and each of the doors at most so wide."""


def find_places(
    free: FreeSpace, log: ScanLog, trajectory: Trajectory, segments: Segments, settings: Settings
) -> Places:
    """Cut the free space at its gateways; what is left in one piece is a region."""
    open_, furniture = open_space(free, settings)
    found = judge(find_chords(open_, free.resolution, settings), free.resolution, settings)
    labels, cuts = cut(open_, found, free.resolution, settings)
    labels[furniture] = -1
    return _places(free.grid(labels), found[np.array(cuts, int)], trajectory, settings)


def open_space(free: FreeSpace, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """Masks (H, W) of the free space without the things that stand in it, and of the larger ones of those things.

    A gap beside a thing that stands free is no gateway, so both small clutter and free-standing furniture are taken
    away; but not a thin piece in line with other walls, which is the wall between two doors.
    """
    total = free.hits + free.passes
    mask = (free.passes >= MIN_PASSES) & (free.hits <= MAX_HIT_SHARE * total)
    labels, stats = components(~mask, diagonal=True)
    size = np.hypot(stats[:, 2], stats[:, 3]) * free.resolution
    size[0] = np.inf
    things = np.nonzero(size < settings.furniture)[0]
    removed = np.zeros(len(stats), bool)
    removed[things] = ~_in_line(mask, free.hits > 0, labels, stats, things, free.resolution)
    return mask | removed[labels], (removed & (size >= settings.clutter))[labels]


def _in_line(
    mask: np.ndarray, seen: np.ndarray, labels: np.ndarray, stats: np.ndarray, things: np.ndarray, resolution: float
) -> np.ndarray:
    """Whether each thing lies between two walls that go on in one line with it: what parts two doors, not furniture."""
    angle = np.arange(0, np.pi, np.radians(5))
    direction = np.stack([np.cos(angle), np.sin(angle)], 1)
    walls = dilate(seen & ~mask, 1)
    out = np.zeros(len(things), bool)
    for k, i in enumerate(things):
        x, y, w, h, _ = stats[i]
        cells = np.argwhere(labels[y : y + h, x : x + w] == i)[:, ::-1] + [x + 0.5, y + 0.5]
        middle = cells.mean(0)
        along = (cells - middle) @ direction.T
        across = (cells - middle) @ np.stack([-direction[:, 1], direction[:, 0]])
        ok = np.ptp(across, axis=0) * resolution < THIN
        for sign, tip in ((1, along.max(0)), (-1, along.min(0))):
            start = middle + (tip + 2 * sign)[:, None] * direction
            way = reach(mask, start, sign * direction, DOORWAY / resolution)
            ok &= way * resolution < DOORWAY
            wall = start + (sign * (way + 1))[:, None] * direction
            ok &= reach(walls, wall, sign * direction, 0.5 / resolution) * resolution > 0.45
        out[k] = ok.any()
    return out


def cut(open_: np.ndarray, found: Hypotheses, resolution: float, settings: Settings) -> tuple[np.ndarray, list[int]]:
    """Labels (H, W) of the pieces, -1 = none, and which hypotheses separate two of them.

    Gaps too narrow for a robot separate as well, but are no gateways. A cut that only divides a hallway is taken back
    (unless ``settings.split_hallways``), and so is a weak one that helps no strong one to close a room, and the weakest
    one of a piece too small for a place. A piece that no gateway leads to joins its neighbour by the longest gap.
    """
    walls = draw_lines(open_.shape, found.posts[:, 0], found.posts[:, 1], 2)
    labels = _pieces(open_ & ~walls, round(0.5 * settings.min_gateway / resolution) - 1)
    pieces = Pieces(labels, resolution)
    ends = [_sides(labels, p) for p in found.posts]
    distance = clearance(open_)[0]
    wide = np.hypot(*(found.posts[:, 1] - found.posts[:, 0]).T) * resolution > HALLWAY
    limit = np.where(found.kind == KINDS.index("opening"), ROOM, np.where(wide, 1.0, NO_ROOM))
    room = np.array([_room_ahead(labels, distance, p, e) for p, e in zip(found.posts, ends, strict=True)])
    cuts = [k for k in range(len(found)) if min(ends[k]) >= 0]

    def standing(of: list[int]) -> list[int]:
        return [k for k in of if pieces.root[ends[k][0]] != pieces.root[ends[k][1]]]

    if not settings.split_hallways:
        for k in cuts:
            if room[k] < limit[k]:
                pieces.join(*ends[k])
    cuts = standing(cuts)
    for k in sorted((k for k in cuts if found.weak[k]), key=lambda k: found.score[k]):
        pair = pieces.pair(ends[k])
        if not any(pieces.pair(ends[j]) == pair for j in cuts if not found.weak[j]):
            pieces.join(*ends[k])
    while True:
        cuts = standing(cuts)
        small = [(found.score[k], k) for k in cuts if min(pieces.area[list(pieces.pair(ends[k]))]) < settings.min_area]
        joined = {s for k in cuts for s in pieces.pair(ends[k])}
        alone = [i for i in range(len(pieces.area)) if i not in joined and pieces.contact[i].any()]
        if small:
            pieces.join(*ends[min(small)[1]])
        elif alone:
            i = min(alone, key=lambda i: pieces.area[i])
            pieces.join(i, int(pieces.contact[i].argmax()))
        else:
            break
    keep = [i for i, a in enumerate(pieces.area) if a >= settings.min_area and (i in joined or a > 4)]
    renumber = np.full(len(pieces.area) + 1, -1, np.int32)
    renumber[keep] = np.arange(len(keep))
    return _fill(renumber[np.append(pieces.root, -1)[labels]], walls & open_), cuts


def _room_ahead(labels: np.ndarray, distance: np.ndarray, posts: np.ndarray, sides: tuple[int, int]) -> float:
    """How much wider than a cut the free space near it gets, on the side where it gets wider: 1 in a plain hallway.

    The width is that of the largest disc with its centre within one and a half widths of the cut.
    """
    middle = (posts[0] + posts[1]) / 2
    gap = float(np.hypot(*(posts[1] - posts[0])))
    r = int(1.5 * gap) + 1
    x, y = int(middle[0]), int(middle[1])
    window = np.s_[max(0, y - r) : y + r + 1, max(0, x - r) : x + r + 1]
    own = np.isin(labels[window], sides)
    return float(2 * distance[window][own].max(initial=0.0) / max(gap - 1, 1.0))


class Pieces:
    """Pieces of the free space while they are being joined: the label that stands for each (``root``), its area [m2]
    and the length of the contact of each two [cells]."""

    def __init__(self, labels: np.ndarray, resolution: float) -> None:
        count = int(labels.max()) + 1
        self.root = np.arange(count)
        self.area = np.bincount(labels[labels >= 0], minlength=count) * resolution**2
        self.contact = _contacts(labels, count)

    def pair(self, ends: tuple[int, int]) -> tuple[int, int]:
        """The pieces on both sides of a cut, smaller label first."""
        a, b = sorted(int(self.root[e]) for e in ends)
        return a, b

    def join(self, a: int, b: int) -> None:
        """Give the smaller piece to the larger."""
        a, b = self.pair((a, b))
        if a == b:
            return
        small, large = (a, b) if self.area[a] < self.area[b] else (b, a)
        self.root[self.root == small] = large
        self.area[large], self.area[small] = self.area[large] + self.area[small], 0
        c = self.contact
        c[large] += c[small]
        c[:, large] += c[:, small]
        c[small], c[:, small], c[large, large] = 0, 0, 0


def _pieces(mask: np.ndarray, radius: int) -> np.ndarray:
    """Connected pieces of a mask in which a disc [cells] can move about, grown back to the mask; -1 elsewhere."""
    labels, _ = components(erode(mask, radius))
    return grow(labels, mask, 2 * radius) - 1


def _contacts(labels: np.ndarray, count: int) -> np.ndarray:
    """(count, count) number of neighbouring cells of each two labels."""
    out = np.zeros((count, count), int)
    for a, b in ((labels[:, 1:], labels[:, :-1]), (labels[1:], labels[:-1])):
        meet = (a != b) & (a >= 0) & (b >= 0)
        np.add.at(out, (a[meet], b[meet]), 1)
    return out + out.T


def _fill(labels: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Give the cells of the cuts to the nearest region."""
    distance, nearest = clearance(labels < 0)
    return np.where(gap & (distance <= 3), labels[nearest[..., 1], nearest[..., 0]], labels)


def _sides(labels: np.ndarray, posts: np.ndarray) -> tuple[int, int]:
    """The labels in front of and behind a chord."""
    a, b = posts.astype(float)
    u = (b - a) / np.hypot(*(b - a))
    n = np.array([-u[1], u[0]])
    out = []
    for sign in (1, -1):
        where = [a + t * (b - a) + 0.5 + sign * s * n for s in (3, 4, 5) for t in (0.3, 0.4, 0.5, 0.6, 0.7)]
        seen = [int(labels[int(y), int(x)]) for x, y in where]
        seen = [s for s in seen if s >= 0]
        out.append(max(set(seen), key=seen.count) if seen else -1)
    return out[0], out[1]


def _places(labels: Grid, found: Hypotheses, trajectory: Trajectory, settings: Settings) -> Places:
    """Number regions and gateways by the scan that came first, and describe them."""
    positions = trajectory.map_from_base[:, :2]
    at = labels.at(positions, outside=-1)
    count = int(labels.values.max()) + 1
    first = np.full(count, -1)
    for i in reversed(range(len(at))):
        if at[i] >= 0:
            first[at[i]] = i
    order = np.lexsort((np.arange(count), np.where(first < 0, len(at), first)))
    rank = np.append(np.argsort(order), -1).astype(np.int32)
    labels = labels.like(rank[labels.values])
    regions = tuple(_region(labels, i, int(first[order[i]]), settings) for i in range(count))
    gateways = [
        _gateway(labels, found.posts[k], KINDS[int(found.kind[k])], float(found.score[k]), positions)
        for k in range(len(found))
    ]
    known = [g for g in gateways if g is not None]
    known.sort(key=lambda g: (g.first_scan if g.first_scan >= 0 else len(at), g.posts))
    return Places(labels, regions, tuple(known))


def _region(labels: Grid, index: int, first_scan: int, settings: Settings) -> FoundRegion:
    mask = labels.values == index
    shape = polygons.simplify(polygons.from_mask(labels.like(mask))[0], 1.5 * labels.resolution)
    shape = polygons.without_small_holes(shape, 0.3)
    boundary, holes = polygons.rings(shape)
    inner = erode(mask, round(settings.robot_radius / labels.resolution))
    cells = np.argwhere(inner if inner.any() else mask)[:, ::-1]
    center, size, yaw = polygons.min_rectangle(labels.centers(cells))
    return FoundRegion(
        boundary=boundary, holes=holes, box_center=center, box_size=size, box_yaw=yaw, first_scan=first_scan
    )


def _gateway(labels: Grid, posts: np.ndarray, kind: str, score: float, positions: np.ndarray) -> FoundGateway | None:
    a, b = labels.centers(posts)
    u = (b - a) / np.hypot(*(b - a))
    a, b = a + 0.5 * labels.resolution * u, b - 0.5 * labels.resolution * u
    front, back = _sides(labels.values, posts)
    if front < 0 or back < 0 or front == back:
        return None
    return describe(a, b, (front, back), "opening" if kind == "opening" else "narrow_passage", score, positions)


def describe(
    a: np.ndarray, b: np.ndarray, sides: tuple[int, int], class_: str, confidence: float, positions: np.ndarray
) -> FoundGateway:
    """A gateway between posts a and b; ``sides`` are the regions left of and right of a -> b."""
    middle, u = (a + b) / 2, (b - a) / np.hypot(*(b - a))
    n = np.array([-u[1], u[0]])
    passes = crossings(positions, a, b)
    points = {sides[0]: middle + 0.5 * n, sides[1]: middle - 0.5 * n}
    regions = tuple(sorted(sides))
    angle = float(np.arctan2(n[1], n[0]))
    return FoundGateway(
        class_=class_,
        confidence=round(confidence, 4),
        regions=regions,
        posts=(point(a), point(b)),
        crossing_points=(point(middle),),
        gateway_points=tuple(point(points[r]) for r in regions),
        traversal_directions=(round(angle, 4), round(float(se2.wrap(angle + np.pi)), 4)),
        passed=len(passes) > 0,
        first_scan=int(passes[0]) if len(passes) else -1,
    )


def crossings(positions: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Indices of the scans after which the robot's way crosses the chord a - b."""
    p, q = positions[:-1], positions[1:]

    def side(o: np.ndarray, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return (t[..., 0] - o[..., 0]) * (x[..., 1] - o[..., 1]) - (t[..., 1] - o[..., 1]) * (x[..., 0] - o[..., 0])

    crossed = (side(p, q, a) * side(p, q, b) <= 0) & (side(a, b, p) * side(a, b, q) <= 0)
    return np.nonzero(crossed & (np.abs(q - p).sum(1) > 0))[0]


PROBES = (0.1, 0.15, 0.2, 0.3)
"""m: how far off a segment, towards its free side, its region is looked up."""


def region_of_segments(segments: Segments, trajectory: Trajectory, places: Places) -> np.ndarray:
    """(M,) index of the region whose free space each segment bounds, -1 = none.

    Probes the label raster a little to the left of start -> end, at the middle first and then nearer to the ends.
    """
    ends = se2.transform(trajectory.map_from_laser[segments.scan][:, None], segments.ends)
    d = ends[:, 1] - ends[:, 0]
    n = np.stack([-d[:, 1], d[:, 0]], 1) / np.maximum(np.hypot(*d.T), 1e-9)[:, None]
    region = np.full(len(segments), -1)
    for share in (0.5, 0.3, 0.7):
        for step in PROBES:
            open_ = region < 0
            points = ends[open_, 0] + share * d[open_] + step * n[open_]
            region[open_] = places.labels.at(points, outside=-1)
    return region
