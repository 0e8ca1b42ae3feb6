"""Formats that only Python writes, by packages that know them: Parquet, and ROS 2 bags."""

import importlib
import os
from collections.abc import Callable
from typing import Any

import numpy as np

from . import _piste
from .errors import ConfigError

GPS_EPOCH = 315964800  # s, of Unix time


def _package(name: str, of: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.split(".")[0]
        raise ConfigError(f"{of} needs the package {package}, which is not here: pip install {package}", "to") from None


def _columns(folder: str, week: int | None) -> dict[str, np.ndarray]:
    """All columns of the smoothed rows, by the program's own .npz."""
    file = os.path.join(folder, f".export.{os.getpid()}.npz")
    try:
        _piste.export(folder, "numpy", week, file)
        with np.load(file) as arrays:
            return {name: arrays[name] for name in arrays}
    finally:
        if os.path.exists(file):
            os.remove(file)


def _parquet(folder: str, file: str, week: int | None) -> None:
    _package("pyarrow", "parquet")
    pandas = _package("pandas", "parquet")
    partial = file + ".partial"
    pandas.DataFrame(_columns(folder, week)).to_parquet(partial)
    os.replace(partial, file)


def _rosbag(folder: str, file: str, week: int | None) -> None:
    """Topics /odometry (nav_msgs/Odometry) and /fix (sensor_msgs/NavSatFix); stamps are GPS time counted as Unix time."""
    rosbag2 = _package("rosbags.rosbag2", "rosbag")
    typesys = _package("rosbags.typesys", "rosbag")
    if os.path.exists(file):
        raise ConfigError(f"{file} is there; a bag is a new folder", "output")
    columns = _columns(folder, week)
    poses = _poses(folder, week)
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    types = store.types
    shift = 0 if week is None else GPS_EPOCH + week * 604800
    with rosbag2.Writer(file, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as bag:
        odometry = bag.add_connection("/odometry", "nav_msgs/msg/Odometry", typestore=store)
        fix = bag.add_connection("/fix", "sensor_msgs/msg/NavSatFix", typestore=store)
        for i, pose in enumerate(poses):
            micro = round(1e6 * columns["time_s"][i])
            seconds, rest = divmod(micro, 1_000_000)
            stamp = types["builtin_interfaces/msg/Time"](sec=int(seconds + shift), nanosec=int(1000 * rest))
            at = 1000 * (micro + 1_000_000 * shift)
            for connection, message in (
                (odometry, _odometry(types, stamp, pose, columns, i)),
                (fix, _fix(types, stamp, columns, i)),
            ):
                bag.write(connection, at, store.serialize_cdr(message, connection.msgtype))


def _poses(folder: str, week: int | None) -> np.ndarray:
    file = os.path.join(folder, f".export.{os.getpid()}.tum")
    try:
        _piste.export(folder, "tum", week, file)
        return np.loadtxt(file, ndmin=2)
    finally:
        if os.path.exists(file):
            os.remove(file)


def _odometry(types: Any, stamp: Any, pose: np.ndarray, columns: dict[str, np.ndarray], i: int) -> Any:
    point, quaternion = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    vector = types["geometry_msgs/msg/Vector3"]
    spread, twist = np.zeros((6, 6)), np.zeros((6, 6))
    for k, axis in enumerate(("east", "north", "down")):
        spread[k, k] = columns[f"sigma_{axis}_m"][i] ** 2
        twist[k, k] = columns[f"sigma_velocity_{axis}_m_s"][i] ** 2
    for k, axis in enumerate(("roll", "pitch", "heading")):
        spread[3 + k, 3 + k] = np.radians(columns[f"sigma_{axis}_deg"][i]) ** 2
    velocity = [columns[f"velocity_{axis}_m_s"][i] for axis in ("east", "north", "down")]
    still = vector(x=0.0, y=0.0, z=0.0)
    return types["nav_msgs/msg/Odometry"](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="enu"),
        child_frame_id="body_frd",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](
            pose=types["geometry_msgs/msg/Pose"](
                position=point(x=pose[1], y=pose[2], z=pose[3]),
                orientation=quaternion(x=pose[4], y=pose[5], z=pose[6], w=pose[7]),
            ),
            covariance=spread.ravel(),
        ),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](
            twist=types["geometry_msgs/msg/Twist"](
                linear=vector(x=velocity[0], y=velocity[1], z=-velocity[2]), angular=still
            ),
            covariance=twist.ravel(),
        ),
    )


def _fix(types: Any, stamp: Any, columns: dict[str, np.ndarray], i: int) -> Any:
    kind = types["sensor_msgs/msg/NavSatFix"]
    spread = np.diag([columns[f"sigma_{axis}_m"][i] ** 2 for axis in ("east", "north", "down")])
    return kind(
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="body_frd"),
        status=types["sensor_msgs/msg/NavSatStatus"](status=0, service=1),
        latitude=columns["latitude_deg"][i],
        longitude=columns["longitude_deg"][i],
        altitude=columns["height_m"][i],
        position_covariance=spread.ravel(),
        position_covariance_type=2,
    )


ENDINGS = {"parquet": ".parquet", "rosbag": "_bag"}
WRITERS: dict[str, Callable[[str, str, int | None], None]] = {"parquet": _parquet, "rosbag": _rosbag}
