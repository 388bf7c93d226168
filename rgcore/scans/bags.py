"""ROS bags without ROS: version 1 (``.bag``), version 2 (folder with ``metadata.yaml``, bare ``.db3`` or ``.mcap``).

Topics are found by their types: LaserScan or MultiEchoLaserScan for the laser, Odometry, else the transforms, for the
odometry. The mounting of the laser comes from the transforms (:mod:`rgcore.scans.bag_frames`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rgcore.errors import InputError, RgError
from rgcore.geometry import se2
from rgcore.scans.bag_frames import Frames, planar
from rgcore.scans.beams import Fan, one_table
from rgcore.scans.echoes import mark_echoes
from rgcore.scans.log import ScanLog
from rgcore.scans.mounting import interpolate, moves

LASERS = ("sensor_msgs/msg/LaserScan", "sensor_msgs/msg/MultiEchoLaserScan")
ODOMETRY = "nav_msgs/msg/Odometry"
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")

_MAGIC = {b"#ROSBAG": ".bag", b"SQLite format 3\0": ".db3", b"\x89MCAP": ".mcap"}
_MOST_BEAMS = 100_000  # a message that announces more is damaged
_TILT = np.deg2rad(10)  # a laser that leans more does not see a plane of the building


class Topics(NamedTuple):
    """Which topics of a bag to read; None: the one that fits, the usual name or the most messages among several."""

    scan: str | None = None
    odometry: str | None = None


USUAL = Topics()


class Topic(NamedTuple):
    """What a bag holds under one name; ``type`` is the message type, e.g. sensor_msgs/msg/LaserScan."""

    name: str
    type: str
    messages: int


def is_bag(path: Path) -> bool:
    """Whether a path is a ROS bag: a folder with metadata, or a file that begins like one."""
    if path.is_dir():
        return (path / "metadata.yaml").exists()
    try:
        with path.open("rb") as f:
            return f.read(16).startswith(tuple(_MAGIC))
    except (OSError, ValueError):
        return False


def topics(path: Path) -> list[Topic]:
    """All topics of a bag by name. Raises InputError for a damaged one."""
    with _opened(path) as bag:
        return _topics(bag)


def read(path: Path, chosen: Topics = USUAL) -> ScanLog:
    """The scans of a bag with the odometry at their times, in the order in which they were recorded.

    Raises InputError for a damaged bag, one without a laser, and a chosen topic that is not there.
    """
    notes: list[str] = []
    with _opened(path) as bag:
        listed = _topics(bag)
        scan_topic = _laser(path, listed, chosen.scan, notes)
        odom_topic = _odometry(path, listed, chosen.odometry, notes)
        wanted = {scan_topic, odom_topic, *(t.name for t in listed if t.type in TRANSFORMS)}
        found = _Messages(scan_topic, odom_topic)
        try:
            for connection, recorded, raw in bag.messages([c for c in bag.connections if c.topic in wanted]):
                found.take(connection.topic, 1e-9 * recorded, bag.deserialize(raw, connection.msgtype))
        except Exception as e:  # whatever a reader of damaged bytes comes to
            if not found.rows:
                raise _damaged(path, e) from e
            notes.append(f"the bag is damaged after {len(found.rows)} scans ({_first_line(e)}); the rest is left out")
    if not found.rows:
        raise InputError(path, f"{scan_topic} holds no scans; nothing to map")
    return _as_log(path, chosen, found, notes)


class _Messages:
    """What the messages say, in plain arrays."""

    def __init__(self, scan_topic: str, odom_topic: str | None) -> None:
        self.scan_topic, self.odom_topic = scan_topic, odom_topic
        self.rows: list[np.ndarray] = []
        self.fans: list[Fan] = []
        self.limits: list[tuple[float, float]] = []
        self.times: list[tuple[float, float]] = []  # by the message, by the recorder
        self.laser_frame = ""
        self.odom: list[tuple[float, float, float, float, float]] = []  # x y theta, by the message, by the recorder
        self.odom_frames = ("", "")
        self.frames = Frames()

    def take(self, topic: str, recorded: float, message: Any) -> None:
        if topic == self.scan_topic:
            self._scan(recorded, message)
        elif topic == self.odom_topic:
            pose = message.pose.pose
            self.odom.append((*planar(pose.position, pose.orientation), _seconds(message.header.stamp), recorded))
            self.odom_frames = (message.header.frame_id.strip("/"), message.child_frame_id.strip("/"))
        else:
            for t in message.transforms:
                self.frames.add(t, _seconds(t.header.stamp), recorded)

    def _scan(self, recorded: float, m: Any) -> None:
        if len(m.ranges) > _MOST_BEAMS:
            raise ValueError(f"a scan announces {len(m.ranges)} readings")
        echoes = [e.echoes[0] if len(e.echoes) else np.inf for e in m.ranges] if _several(m.ranges) else m.ranges
        fan = Fan(len(echoes), round(float(m.angle_min), 6), round(float(m.angle_increment), 8))
        if not np.isfinite([fan.start, fan.step]).all() or (fan.step == 0 and fan.beams > 1):
            raise ValueError(f"a scan has angle_min {fan.start}, angle_increment {fan.step}")
        self.rows.append(np.asarray(echoes, float))
        self.fans.append(fan)
        self.limits.append((float(m.range_min), float(m.range_max)))
        self.times.append((_seconds(m.header.stamp), recorded))
        self.laser_frame = m.header.frame_id.strip("/")


def _as_log(path: Path, chosen: Topics, found: _Messages, notes: list[str]) -> ScanLog:
    base_from_laser, upside_down = _mounting(found, notes)
    rows, fans = found.rows, found.fans
    turned = [_counter_clockwise(r, f, upside_down) for r, f in zip(rows, fans, strict=True)]
    if any(f.step < 0 for f in fans) and not upside_down:
        notes.append("the laser turns clockwise; its readings are put the other way round")
    readings, bearings, moved = one_table([r for r, _ in turned], [f for _, f in turned])
    if not len(bearings):
        raise InputError(path, f"the scans of {found.scan_topic} hold no readings; nothing to map")
    if moved:
        notes.append(f"{moved} scans of another fan of beams moved to the {len(bearings)} of the others")
    ranges, max_range, more = _echoes(readings, np.array(found.limits))
    notes += more
    times = np.array(found.times)
    own = bool((times[:, 0] > 0).all())
    if not own:
        notes.append("scans carry no time stamps; the times of recording are used")
    odom = _poses(found, times, own, notes)
    return ScanLog(
        stamps=times[:, 0 if own else 1],
        ranges=ranges,
        odom_from_base=odom,
        bearings=bearings,
        base_from_laser=base_from_laser,
        max_range=max_range,
        has_odometry=moves(odom),
        source=path.name,
        sha256=_fingerprint(path, chosen),
        format="bag",
        notes="\n".join(notes),
    )


def _counter_clockwise(row: np.ndarray, fan: Fan, upside_down: bool) -> tuple[np.ndarray, Fan]:
    """The readings with bearings that grow; a laser that hangs upside down sees left as right."""
    if upside_down:
        fan = Fan(fan.beams, -fan.start, -fan.step)
    if fan.step >= 0:
        return row, fan
    return row[::-1], Fan(fan.beams, round(fan.start + (fan.beams - 1) * fan.step, 6), -fan.step)


def _echoes(readings: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, float, list[str]]:
    """By REP 117: +inf = nothing near enough, -inf = too near, nan = failed; the messages' limits say the rest.

    A zero is below every lower limit: it says nothing. Older drivers write it for an echo that failed as well, on a
    dark or slanting wall, and to take it for a free way would open that wall.
    """
    low, high = limits[:, :1], np.where(limits[:, 1:] > 0, limits[:, 1:], np.inf)
    with np.errstate(invalid="ignore"):
        readings = np.where(readings >= high, np.inf, readings)
        zeros = int((readings == 0).sum())
        readings = np.where((readings < low) | (readings == 0), np.nan, readings)
    ranges, longest, notes = mark_echoes(readings)
    return ranges, longest, [*notes, f"{zeros} readings of 0 m tell nothing"] if zeros else notes


def _mounting(found: _Messages, notes: list[str]) -> tuple[np.ndarray, bool]:
    """``base_from_laser (3,)``, and whether the laser hangs upside down."""
    base = found.odom_frames[1] or found.frames.base or found.frames.root(found.laser_frame)
    pose = found.frames.between(base, found.laser_frame)
    if pose is None or not found.frames.known(found.laser_frame):
        notes.append(
            f"no transform tells where the laser ({found.laser_frame or 'no frame'}) sits on the robot"
            f" ({base or 'no frame'}); it is taken to sit in the middle, looking ahead"
        )
        return np.zeros(3), False
    up = float(pose[2, 2])
    if abs(up) < np.cos(_TILT):
        notes.append(f"the laser leans by {np.degrees(np.arccos(min(abs(up), 1.0))):.0f} degrees; the map is distorted")
    flat = np.array([pose[0, 3], pose[1, 3], np.arctan2(pose[1, 0], pose[0, 0])])
    return np.where(np.abs(flat) < 1e-4, 0.0, np.round(flat, 6)), up < 0


def _poses(found: _Messages, times: np.ndarray, own: bool, notes: list[str]) -> np.ndarray:
    """(N, 3) odometry of the robot's centre at the scans; zeros where there is none."""
    if found.odom:
        known = np.array(found.odom)
    else:
        known = found.frames.moving(found.laser_frame)
        if len(known):
            notes.append("odometry is taken from the transforms")
    if not len(known):
        notes.append("the bag has no odometry")
        return np.zeros((len(times), 3))
    column = 0 if own and _overlap(times[:, 0], known[:, 3]) else 1
    if own and column:
        notes.append("the clocks of laser and odometry differ; the times of recording join them")
    poses = interpolate(times[:, column], known[:, 3 + column], known[:, :3])
    return np.column_stack([poses[:, :2], se2.wrap(poses[:, 2])])


def _overlap(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two series of stamps were taken by one clock: the middle of each lies within the other."""
    return bool(b.min() <= np.median(a) <= b.max() or a.min() <= np.median(b) <= a.max())


def _laser(path: Path, listed: list[Topic], chosen: str | None, notes: list[str]) -> str:
    fitting = [t for t in listed if t.type in LASERS]
    if chosen is not None:
        return _named(path, fitting, chosen, "laser")
    if not fitting:
        have = ", ".join(f"{t.name} ({t.type.rpartition('/')[2]})" for t in listed[:12]) or "nothing"
        raise InputError(
            path, f"no laser topic ({' or '.join(t.rpartition('/')[2] for t in LASERS)}); it holds: {have}"
        )
    best = _best(fitting, ("scan", "base_scan"))
    if len(fitting) > 1:
        others = ", ".join(f"{t.name} ({t.messages})" for t in fitting if t != best)
        notes.append(f"laser {best.name} ({best.messages} scans) is read; choose another by --scan-topic: {others}")
    return best.name


def _odometry(path: Path, listed: list[Topic], chosen: str | None, notes: list[str]) -> str | None:
    fitting = [t for t in listed if t.type == ODOMETRY]
    if chosen is not None:
        return _named(path, fitting, chosen, "odometry")
    if not any(t.messages for t in fitting):
        return None
    best = _best(fitting, ("odom", "odometry"))
    if len(fitting) > 1:
        others = ", ".join(t.name for t in fitting if t != best)
        notes.append(f"odometry {best.name} is read; choose another by --odom-topic: {others}")
    return best.name


def _named(path: Path, fitting: list[Topic], name: str, what: str) -> str:
    found = next((t for t in fitting if t.name.strip("/") == name.strip("/")), None)
    if found is None:
        have = ", ".join(t.name for t in fitting) or "none"
        raise InputError(path, f"no {what} topic {name}; there is: {have}")
    return found.name


def _best(fitting: list[Topic], usual: tuple[str, ...]) -> Topic:
    """The topic of a usual name with messages, else the one with the most."""
    return max(fitting, key=lambda t: (t.messages > 0 and t.name.strip("/") in usual, t.messages, t.name))


def _topics(bag: Any) -> list[Topic]:
    count: dict[tuple[str, str], int] = {}
    for c in bag.connections:
        messages = c.msgcount if isinstance(c.msgcount, int) else 0  # the metadata of a damaged bag says anything
        count[c.topic, c.msgtype] = count.get((c.topic, c.msgtype), 0) + messages
    return [Topic(name, type_, n) for (name, type_), n in sorted(count.items())]


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A reader of a bag of any kind."""
    from rosbags.highlevel import AnyReader  # heavy, and needed for bags only
    from rosbags.typesys import Stores, get_typestore

    kind = _kind(path)
    if kind is not None and path.suffix != kind:
        raise InputError(path, f"is a ROS bag; rename it to end in {kind}")
    bag = None
    try:
        bag = AnyReader([path], default_typestore=get_typestore(Stores.LATEST))
        bag.open()
    except Exception as e:
        raise _damaged(path, e) from e
    try:
        yield bag
    finally:
        bag.close()


def _kind(path: Path) -> str | None:
    """The ending that the content of a bag's file calls for; None for a folder."""
    if path.is_dir():
        return None
    with path.open("rb") as f:
        start = f.read(16)
    return next(ending for magic, ending in _MAGIC.items() if start.startswith(magic))


def _damaged(path: Path, e: Exception) -> RgError:
    return InputError(
        path, f"the bag cannot be read: {_first_line(e)}; copy it again, or repair it with ROS's own tools"
    )


def _first_line(e: Exception) -> str:
    return (str(e).strip().splitlines() or [type(e).__name__])[0].rstrip(".")[:200]


def _several(ranges: Any) -> bool:
    return len(ranges) > 0 and hasattr(ranges[0], "echoes")


def _seconds(stamp: Any) -> float:
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def _fingerprint(path: Path, chosen: Topics) -> str:
    """sha256 of the bag's files and of the topics chosen: another choice is another log."""
    digest = hashlib.sha256()
    files = sorted(p for p in path.iterdir() if p.is_file()) if path.is_dir() else [path]
    for file in files:
        with file.open("rb") as f:
            while block := f.read(1 << 20):
                digest.update(block)
    if any(chosen):
        digest.update(repr(tuple(chosen)).encode())
    return digest.hexdigest()
