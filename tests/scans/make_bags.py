"""Bags as robots record them, written with the library that reads them elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
Pose = tuple[float, float, float]


class Laser(NamedTuple):
    """A laser and how it sits on the robot: x, y, yaw [m, rad], ``over``: hanging upside down."""

    mounting: Pose = (0.2, 0.0, 0.5)
    over: bool = False
    angle_min: float = -1.5
    step: float = 0.01
    topic: str = "/scan"


class Bag:
    """Collects messages, then writes them as a bag of either version."""

    def __init__(self, version: int = 2) -> None:
        self.version, self.store = version, ROS2 if version == 2 else ROS1
        self.messages: list[tuple[str, str, int, Any]] = []

    def add(self, topic: str, type_: str, seconds: float, **fields: Any) -> None:
        self.messages.append((topic, type_, round(seconds * 1e9), self.make(type_, **fields)))

    def make(self, type_: str, **fields: Any) -> Any:
        return self.store.types[type_](**fields)

    def header(self, seconds: float, frame: str) -> Any:
        stamp = self.make("builtin_interfaces/msg/Time", sec=int(seconds), nanosec=round(seconds % 1 * 1e9))
        seq = {"seq": 0} if self.version == 1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **seq)

    def scan(self, seconds: float, ranges: np.ndarray, laser: Laser = Laser(), stamp: float | None = None) -> None:  # noqa: B008
        self.add(
            laser.topic,
            "sensor_msgs/msg/LaserScan",
            seconds,
            header=self.header(seconds if stamp is None else stamp, "laser"),
            angle_min=laser.angle_min,
            angle_max=laser.angle_min + laser.step * (len(ranges) - 1),
            angle_increment=laser.step,
            time_increment=0.0,
            scan_time=0.1,
            range_min=0.1,
            range_max=30.0,
            ranges=np.asarray(ranges, np.float32),
            intensities=np.zeros(0, np.float32),
        )

    def odom(self, seconds: float, pose: Pose, topic: str = "/odom", stamp: float | None = None) -> None:
        place = self.make("geometry_msgs/msg/Pose", position=self._xyz("Point", pose), orientation=self._turn(pose[2]))
        still = self.make(
            "geometry_msgs/msg/Twist", linear=self._xyz("Vector3", (0, 0)), angular=self._xyz("Vector3", (0, 0))
        )
        self.add(
            topic,
            "nav_msgs/msg/Odometry",
            seconds,
            header=self.header(seconds if stamp is None else stamp, "odom"),
            child_frame_id="base_link",
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=np.zeros(36)),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=still, covariance=np.zeros(36)),
        )

    def transform(self, seconds: float, parent: str, child: str, pose: Pose, over: bool = False) -> None:
        placed = self.make(
            "geometry_msgs/msg/Transform",
            translation=self._xyz("Vector3", pose),
            rotation=self._turn(pose[2], over),
        )
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(seconds, parent),
            child_frame_id=child,
            transform=placed,
        )
        topic = "/tf" if parent == "odom" else "/tf_static"
        self.add(topic, "tf2_msgs/msg/TFMessage", seconds, transforms=[stamped])

    def write(self, path: Path, storage: str = "sqlite3") -> Path:
        writer: Any
        if self.version == 1:
            writer = Writer1(path)
        else:
            writer = Writer2(path, version=8, storage_plugin=StoragePlugin[storage.upper()])
        with writer:
            connections = {}
            for topic, type_, at, message in self.messages:
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, type_, typestore=self.store)
                dump = self.store.serialize_ros1 if self.version == 1 else self.store.serialize_cdr
                writer.write(connections[topic], at, dump(message, type_))
        return path

    def _xyz(self, type_: str, at: tuple[float, ...]) -> Any:
        return self.make(f"geometry_msgs/msg/{type_}", x=float(at[0]), y=float(at[1]), z=0.0)

    def _turn(self, yaw: float, over: bool = False) -> Any:
        """The quaternion of a turn about the vertical, after one by half a turn about x if ``over``."""
        w, z = np.cos(yaw / 2), np.sin(yaw / 2)
        x, y, z, w = (w, z, 0.0, 0.0) if over else (0.0, 0.0, z, w)
        return self.make("geometry_msgs/msg/Quaternion", x=float(x), y=float(y), z=float(z), w=float(w))


def wall_ranges(beams: int = 301, base: float = 2.0) -> np.ndarray:
    """Readings that tell left from right: they grow with the bearing."""
    return base + 0.01 * np.arange(beams)


def drive(bag: Bag, scans: int = 5, laser: Laser = Laser(), **stamp: float) -> Bag:  # noqa: B008
    """A robot that drives ahead by 0.1 m and turns by 0.02 rad a scan, its laser on its body."""
    bag.transform(100.0, "base_link", "laser", laser.mounting, laser.over)
    for k in range(scans):
        at = 100.0 + 0.1 * k
        own = {name: value + 0.1 * k for name, value in stamp.items()}
        bag.odom(at, (0.1 * k, 0.0, 0.02 * k), **own)
        bag.scan(at, wall_ranges(), laser, **own)
    return bag
