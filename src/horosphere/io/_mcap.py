"""MCAP with one ROS 2 `trajectory_msgs/msg/JointTrajectory`, which Foxglove and ros2 bag read; no ROS needed."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from .._atomic import writing
from ..errors import InputError
from ..scenes import Trajectory

TOPIC = "/joint_trajectory"
_TYPE = "trajectory_msgs/msg/JointTrajectory"
_BAR = "=" * 80
_SCHEMA = f"""std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
{_BAR}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_BAR}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
{_BAR}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{_BAR}
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""
_REMEDY = "pip install 'horosphere[mcap]'"


def _stamp(seconds: float) -> dict[str, int]:
    nanoseconds = round(float(seconds) * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def write_mcap(trajectory: Trajectory, path: Path) -> None:
    """Writes the trajectory as one message; times are relative to the first waypoint, to the nanosecond."""
    try:
        from mcap_ros2.writer import Writer
    except ImportError:
        raise InputError("MCAP needs the extra `mcap`", place=str(path), remedy=_REMEDY) from None
    n = trajectory.positions.shape[1]

    def row(array: Any, k: int) -> list[float]:
        return [] if array is None else [float(x) for x in array[k]]

    message = {
        "header": {"stamp": _stamp(0.0), "frame_id": ""},
        "joint_names": list(trajectory.names or (f"q{j + 1}" for j in range(n))),
        "points": [
            {
                "positions": row(trajectory.positions, k),
                "velocities": row(trajectory.velocities, k),
                "accelerations": row(trajectory.accelerations, k),
                "effort": [],
                "time_from_start": _stamp(trajectory.time[k] - trajectory.time[0]),
            }
            for k in range(len(trajectory))
        ],
    }
    with writing(path, "wb") as file:
        writer = Writer(file)
        schema = writer.register_msgdef(_TYPE, _SCHEMA)
        writer.write_message(TOPIC, schema, message, log_time=0, publish_time=0)
        writer.finish()


def read_mcap(path: Path) -> Trajectory:
    """The JointTrajectory message of the file, on any topic. Raises InputError if there are several: which is meant is not known."""
    try:
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory
    except ImportError:
        raise InputError("MCAP needs the extra `mcap`", remedy=_REMEDY) from None
    try:
        with open(path, "rb") as file:
            found = [
                (channel.topic, message)
                for schema, channel, _, message in make_reader(
                    file, decoder_factories=[DecoderFactory()]
                ).iter_decoded_messages()
                if schema is not None and schema.name == _TYPE
            ]
    except Exception as error:
        raise InputError(
            f"not a readable MCAP file ({type(error).__name__}: {error})",
            remedy="was it cut off? copy or write it again",
        ) from None
    if not found:
        raise InputError(f"no {_TYPE} message in it")
    if len(found) > 1:
        topics = ", ".join(dict.fromkeys(topic for topic, _ in found))
        raise InputError(
            f"{len(found)} {_TYPE} messages in it, on {topics}",
            remedy="write the one that is meant into a file of its own",
        )
    return _trajectory(found[0][1])


def _trajectory(message: SimpleNamespace | Any) -> Trajectory:
    points = message.points
    time = np.array([p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in points])
    rates = [
        np.array([getattr(p, name) for p in points], dtype=np.float64)
        if points and len(getattr(points[0], name))
        else None
        for name in ("positions", "velocities", "accelerations")
    ]
    if rates[0] is None:
        raise InputError("the JointTrajectory has no points")
    return Trajectory(time, rates[0], rates[1], rates[2], tuple(message.joint_names))
