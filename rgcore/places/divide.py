"""Dividing the free space: at its gateways, and at gaps that no robot fits through."""

from __future__ import annotations

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry.grid import clearance, components, dilate, draw_lines, erode, grow, reach
from rgcore.places.chords import measure_chords
from rgcore.places.freespace import FreeSpace
from rgcore.places.hypotheses import TRANSITIONS, Hypotheses, chances

MIN_PASSES, MAX_HIT_SHARE = 2, 0.25
"""A cell is free if that many beams went through it and at most this share of all its beams ended in it."""


BETWEEN = 0.7
"""A weak cut of this score stands between two pieces that have a sure gateway each."""

NO_ROOM, ROOM = 1.2, 1.9
"""A gap in a wall with nothing wider near it than so many times its width only divides a hallway; and so does a
hallway's mouth unless something as wide as a room lies behind it."""


HALLWAY = 3.5
"""m: no hallway is wider."""

LEAST_PILLAR, PILLAR = 0.2, 1.0
"""m: what stands between two doors in one line is no thinner, as a leaf of a door is, and no thicker, even with one."""

PIECE, THIN, THICK, DOORWAY = 0.8, 0.3, 0.5, 1.7
"""m: a thing so long and thin is a piece of wall; one no thicker than the third between two openings no wider than the
last, in line with the walls beyond them, as well."""


def free_mask(free: FreeSpace) -> np.ndarray:
    """Mask (H, W) of the cells that are free."""
    return np.asarray((free.passes >= MIN_PASSES) & (free.hits <= MAX_HIT_SHARE * (free.hits + free.passes)))


def open_space(free: FreeSpace, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """Masks (H, W) of the free space without the things that stand in it, and of the larger ones of those things.

    A gap beside a thing that stands free is no gateway, so both small clutter and free-standing furniture are taken
    away; but not a thin piece in line with other walls, which is the wall between two doors.
    """
    mask = free_mask(free)
    labels, stats = components(~mask, diagonal=True)
    size = np.hypot(stats[:, 2], stats[:, 3]) * free.resolution
    size[0] = np.inf
    things = np.nonzero(size < settings.furniture)[0]
    removed = np.zeros(len(stats), bool)
    removed[things] = ~_parts_doors(mask, free.hits > 0, labels, stats, things, free.resolution)
    return mask | removed[labels], (removed & (size >= settings.clutter))[labels]


def _parts_doors(
    mask: np.ndarray, seen: np.ndarray, labels: np.ndarray, stats: np.ndarray, things: np.ndarray, resolution: float
) -> np.ndarray:
    """Whether each thing is a piece of wall rather than furniture: thin and long, or in one line between two walls."""
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
        thick = np.ptp(across, axis=0) * resolution
        if np.hypot(w, h) * resolution >= PIECE and thick.min() < THIN:
            out[k] = True
            continue
        ok = thick < THICK
        for sign, tip in ((1, along.max(0)), (-1, along.min(0))):
            start = middle + (tip + 2 * sign)[:, None] * direction
            way = reach(mask, start, sign * direction, DOORWAY / resolution)
            ok &= way * resolution < DOORWAY
            wall = start + (sign * (way + 1))[:, None] * direction
            ok &= reach(walls, wall, sign * direction, 1.0 / resolution) * resolution > 0.8
        out[k] = ok.any()
    return out


def split_at_pillars(
    open_: np.ndarray, mask: np.ndarray, found: Hypotheses, resolution: float, settings: Settings
) -> tuple[np.ndarray, Hypotheses]:
    """The hypotheses, each divided at the things in its line that were taken for clutter: pillars between doors.

    ``mask``: the free cells with all that stands in them. A thing counts where a robot fits through on both sides of
    it; it is given back to the walls.
    """
    labels, stats = components(open_ & ~mask, diagonal=True)
    labels[(stats[:, 2:4].min(1) * resolution < LEAST_PILLAR)[labels]] = 0
    near = grow(labels, labels == 0, 1)
    open_ = open_.copy()
    posts, source = [], []
    for k, (a, b) in enumerate(found.posts.astype(float)):
        n = max(2, round(2 * float(np.hypot(*(b - a)))))
        at = a + np.linspace(0, 1, n + 1)[:, None] * (b - a)
        cells = np.floor(at + 0.5).astype(int)
        thing = near[cells[:, 1], cells[:, 0]]
        runs = _free_runs(thing == 0)
        wide = [(i, j) for i, j in runs if (j - i) * resolution / 2 >= settings.min_gateway]
        pillar = n * resolution / 2 - sum(j - i for i, j in wide) * resolution / 2
        if len(wide) < 2 or pillar > PILLAR * (len(wide) - 1):
            wide = [(0, n)]
        else:
            open_ &= ~np.isin(labels, thing[thing > 0])
        posts += [np.array([cells[i], cells[j]]) for i, j in wide]
        source += [k] * len(wide)
    out = found[np.array(source, int)]
    both = np.array(posts, int).reshape(-1, 2, 2)
    parts = np.flatnonzero(np.bincount(source, minlength=len(found))[source] > 1)
    score, weak = out.score.copy(), out.weak.copy()
    if len(parts):
        alone = chances(measure_chords(open_, both[parts], resolution), resolution)[:, 1:3].sum(1)
        score[parts] = np.maximum(score[parts], alone)
        weak[parts] &= alone < settings.min_confidence
    return open_, Hypotheses(both, score, out.kind, weak)


def _free_runs(free: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each run of true values."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], free, [False]]).astype(np.int8)))
    return [(int(i), int(j) - 1) for i, j in edge.reshape(-1, 2)]


def cut(open_: np.ndarray, found: Hypotheses, resolution: float, settings: Settings) -> tuple[np.ndarray, list[int]]:
    """Labels (H, W) of the pieces, -1 = none, and which hypotheses separate two of them.

    Gaps too narrow for a robot separate as well, but are no gateways. A cut that only divides a hallway is taken back
    (unless ``settings.split_hallways``), and so is a weak one that helps no strong one to close a room, and the weakest
    one of a piece too small for a place. A piece that no gateway leads to joins its neighbour by the longest gap.
    """
    walls = draw_lines(open_.shape, found.posts[:, 0], found.posts[:, 1], 2)
    labels = _pieces(open_ & ~walls, round(0.5 * settings.min_gateway / resolution) - 1)
    pieces = Pieces(labels, resolution)
    ends = [sides(labels, p) for p in found.posts]
    distance = clearance(open_)[0]
    wide = np.hypot(*(found.posts[:, 1] - found.posts[:, 0]).T) * resolution > HALLWAY
    limit = np.where(found.kind == TRANSITIONS.index("opening"), ROOM, np.where(wide, 1.0, NO_ROOM))
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
        strong = [pieces.pair(ends[j]) for j in cuts if not found.weak[j]]
        entered = {s for p in strong for s in p if p[0] != p[1]}
        if pair not in strong and not (found.score[k] >= BETWEEN and entered.issuperset(pair)):
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


def sides(labels: np.ndarray, posts: np.ndarray) -> tuple[int, int]:
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
