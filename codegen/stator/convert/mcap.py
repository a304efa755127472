"""MCAP with ROS 2 messages: `stator_msgs/msg/...` in CDR, their definitions in the file, and the
vehicle's place as `/tf`. A topic's name is that of the log, with a slash."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mcap.writer import CompressionType, Writer

from stator.names import upper_camel
from stator.version import VERSION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    from stator.convert.topics import Field, Topic

LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # the head of each message in CDR
_ROS_TYPES = {"f4": "float32", "f8": "float64", "b1": "bool"} | {
    f"{kind}{size}": f"{'u' if kind == 'u' else ''}int{size * 8}"
    for kind in "ui"
    for size in (1, 2, 4, 8)
}
_LINE = "=" * 80
TF = f"""geometry_msgs/TransformStamped[] transforms
{_LINE}
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
{_LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{_LINE}
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
{_LINE}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
{_LINE}
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1
"""


def ros_type_of(name: str) -> str:
    """Of a type of a message's field."""
    return {"float": "float32", "double": "float64"}.get(name, name)


class Channel(NamedTuple):
    name: str
    schema: str
    definition: str
    time_us: NDArray[np.uint64]
    message: Callable[[int], bytes]  # by the number of the sample


def write_mcap(topics: list[Topic], output: Path) -> None:
    """All samples in the order of their times, which count from the vehicle's start."""
    channels = [*map(channel_of, topics), *_places(topics)]
    times = np.concatenate([channel.time_us for channel in channels])
    owners = np.repeat(np.arange(len(channels)), [len(channel.time_us) for channel in channels])
    numbers = np.concatenate([np.arange(len(channel.time_us)) for channel in channels])
    with output.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library=f"stator {VERSION}")
        ids = []
        for channel in channels:
            definition = channel.definition.encode()
            schema = writer.register_schema(channel.schema, "ros2msg", definition)
            ids.append(writer.register_channel(f"/{channel.name}", "cdr", schema))
        for i in np.argsort(times, kind="stable"):
            owner, number, time_ns = owners[i], int(numbers[i]), int(times[i]) * 1000
            data = channels[owner].message(number)
            writer.add_message(ids[owner], time_ns, data, time_ns, number)
        writer.finish()  # type: ignore[no-untyped-call]


def channel_of(topic: Topic) -> Channel:
    lines = [f"{_ros_type(field)} {field.name}\n" for field in topic.fields]
    schema = f"stator_msgs/msg/{upper_camel(topic.name)}"
    records = _records(topic)
    return Channel(
        topic.name,
        schema,
        "".join(lines),
        topic.time_us,
        lambda i: LITTLE_ENDIAN + records[i].tobytes(),
    )


def _ros_type(field: Field) -> str:
    length = f"[{len(field.columns)}]" if field.is_array else ""
    return _ROS_TYPES[field.dtype.str[1:]] + length


def _records(topic: Topic) -> NDArray[Any]:
    """One for each sample, as CDR lays them out: each field at a multiple of its size."""
    offsets, end = [], 0
    for field in topic.fields:
        offsets.append(-(-end // field.dtype.itemsize) * field.dtype.itemsize)
        end = offsets[-1] + field.dtype.itemsize * len(field.columns)
    layout = np.dtype(
        {
            "names": [field.name for field in topic.fields],
            "formats": [(field.dtype, len(field.columns)) for field in topic.fields],
            "offsets": offsets,
            "itemsize": end,
        }
    )
    records = np.zeros(len(topic.time_us), layout)
    for field in topic.fields:
        for i, column in enumerate(field.columns):
            records[field.name].reshape(len(column), -1)[:, i] = column
    return records


def _places(topics: list[Topic]) -> Iterator[Channel]:
    """`map` (east, north, up) to `base_link` (forward, left, up), as REP 103 and 105 name them."""
    known = {topic.name: {f.name: f.columns for f in topic.fields} for topic in topics}
    if not {"vehicle_local_position", "vehicle_attitude"} <= known.keys():
        return
    place, attitude = known["vehicle_local_position"], known["vehicle_attitude"]
    if not {"x", "y", "z"} <= place.keys() or "q" not in attitude:
        return
    north, east, down = (place[axis][0] for axis in "xyz")
    position = np.column_stack([east, north, -down]).astype(np.float64)
    rotations = _rotations_enu_flu(np.column_stack(attitude["q"]).astype(np.float64))
    time_us = place["timestamp"][0]
    newest = np.searchsorted(attitude["timestamp"][0], time_us, side="right") - 1

    def message(i: int) -> bytes:
        seconds, us = divmod(int(time_us[i]), 1_000_000)
        head = struct.pack("<IiII4sI10s2x", 1, seconds, us * 1000, 4, b"map\0", 10, b"base_link\0")
        # The numbers start at a multiple of 8.
        numbers = struct.pack("<4x7d", *position[i], *rotations[max(newest[i], 0)])
        return LITTLE_ENDIAN + head + numbers

    yield Channel("tf", "tf2_msgs/msg/TFMessage", TF, time_us, message)


def _rotations_enu_flu(q_nb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows x y z w of the attitude from rows w x y z of q_NB, north-east-down and
    forward-right-down."""
    w, x, y, z = q_nb.T
    half = np.sqrt(0.5)  # (0, half, half, 0) exchanges north with east and turns down to up
    rows = [half * (x + y), half * (x - y), half * (w - z), half * (w + z)]
    return np.column_stack(rows)
