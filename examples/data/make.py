"""Make the data of the examples from the simulated office that ships with rgviz: a ROS 1 bag, and a grid map.

python examples/data/make.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgviz.demo import LOG

HERE = Path(__file__).parent
STORE = get_typestore(Stores.ROS1_NOETIC)
STORE.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))


def message(type_: str, **fields: Any) -> Any:
    return STORE.types[type_](**fields)


def header(stamp: float, frame: str) -> Any:
    time = message("builtin_interfaces/msg/Time", sec=int(stamp), nanosec=round(stamp % 1 * 1e9))
    return message("std_msgs/msg/Header", seq=0, stamp=time, frame_id=frame)


def transform(stamp: float, parent: str, child: str, pose: np.ndarray) -> Any:
    x, y, theta = map(float, pose)
    turn = message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=np.sin(theta / 2), w=np.cos(theta / 2))
    at = message("geometry_msgs/msg/Vector3", x=x, y=y, z=0.0)
    placed = message("geometry_msgs/msg/Transform", translation=at, rotation=turn)
    fields = {"header": header(stamp, parent), "child_frame_id": child, "transform": placed}
    return message("tf2_msgs/msg/TFMessage", transforms=[message("geometry_msgs/msg/TransformStamped", **fields)])


def scan(log: ScanLog, k: int, stamp: float) -> Any:
    start, step = float(log.bearings[0]), float(np.diff(log.bearings).mean())
    return message(
        "sensor_msgs/msg/LaserScan",
        header=header(stamp, "laser"),
        angle_min=start,
        angle_max=float(log.bearings[-1]),
        angle_increment=step,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.05,
        range_max=30.0,
        ranges=log.ranges[k].astype(np.float32),
        intensities=np.zeros(0, np.float32),
    )


def write_bag(log: ScanLog, path: Path) -> None:
    path.unlink(missing_ok=True)
    writer = Writer(path)
    writer.set_compression(Writer.CompressionFormat.BZ2)
    tf, laser = "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/LaserScan"
    with writer:
        on_tf, on_scan = (writer.add_connection(n, t, typestore=STORE) for n, t in (("/tf", tf), ("/scan", laser)))
        for k, stamp in enumerate(1e9 + log.stamps):
            for parent, child, pose in (
                ("base_link", "laser", log.base_from_laser),
                ("odom", "base_link", log.odom_from_base[k]),
            ):
                moved = transform(stamp, parent, child, pose)
                writer.write(on_tf, round(stamp * 1e9), STORE.serialize_ros1(moved, tf))
            writer.write(on_scan, round(stamp * 1e9), STORE.serialize_ros1(scan(log, k, stamp), laser))


def write_grid(log: ScanLog, path: Path) -> None:
    """A grid and its image; the masks that are exported beside it are left out."""
    export(path, pipeline.run(log).map)
    pgm = path.with_suffix(".pgm")
    Image.open(pgm).save(path.with_suffix(".png"), optimize=True)
    path.write_text(path.read_text().replace(pgm.name, path.with_suffix(".png").name))
    for file in (pgm, *path.parent.glob(f"{path.stem}-*")):
        file.unlink()


if __name__ == "__main__":
    office = read_log(LOG)
    write_bag(office[:450], HERE / "office.bag")
    write_grid(office, HERE / "office.yaml")
