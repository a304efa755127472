"""Reads the log of a flight and its truth, for judges and pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stator.graph.messages import own_field

if TYPE_CHECKING:
    from pathlib import Path

    from pyulog import ULog

Floats: TypeAlias = NDArray[np.float64]

MODES = dict(own_field("VehicleStatus", "nav_state").values)
_WORDS = {"takeoff": "take-off", "land": "landing"}  # what a flight mode is called in a report
_ARMING = dict(own_field("VehicleStatus", "arming_state").values)
ARMED, DISARMED = _ARMING["armed"], _ARMING["disarmed"]
HOLD = MODES["hold"]
NAV_STATES = {number: _WORDS.get(name, name) for name, number in MODES.items()}
FAILSAFE_EVENTS = {
    number: name
    for name, number in own_field("VehicleStatus", "failsafe_event").values
    if name != "none"
}


class UnreadableFlight(Exception):
    """The log or the truth lacks data that a judgement needs."""


@dataclass(frozen=True)
class Truth:
    time_s: Floats
    position: Floats  # N, m; one row each
    q: Floats  # q_NB, w x y z
    on_ground: NDArray[np.bool_]
    has_wing: bool = False


@dataclass(frozen=True)
class Flight:
    """The data of a judgement. Times in seconds; positions and setpoints in N."""

    truth: Truth
    attitude_time_s: Floats
    attitude_q: Floats
    setpoint_time_s: Floats
    setpoint: Floats  # NaN: free
    status_time_s: Floats
    nav_state: NDArray[np.int64]
    arming_state: NDArray[np.int64]
    # From the program that flew, which sees the truth each millisecond.
    landed: bool
    take_off_s: float | None
    touchdown_s: float | None
    touchdown_m_s: float | None


def read_truth(path: Path) -> Truth:
    columns = read_truth_columns(path)
    try:
        return Truth(
            time_s=columns["time_us"] * 1e-6,
            position=np.column_stack([columns[f"position_{axis}"] for axis in "ned"]),
            q=np.column_stack([columns[f"q_{axis}"] for axis in "wxyz"]),
            on_ground=columns["on_ground"] != 0.0,
            has_wing="surface_1" in columns,
        )
    except KeyError as missing:
        raise UnreadableFlight(f"missing column {missing} in the true flight '{path}'") from None


def read_truth_columns(path: Path) -> dict[str, Floats]:
    """All columns of the true flight, by name: boards/world/world/truth.hpp."""
    head, _, rows = path.read_bytes().partition(b"\n")
    names = head.decode("ascii", errors="replace").split()
    if not names or not rows or len(rows) % (8 * len(names)) != 0:
        raise UnreadableFlight(f"expected a true flight, found another file '{path}'")
    table = np.frombuffer(rows, dtype="<f8").reshape(-1, len(names))
    return dict(zip(names, table.T, strict=True))


def read_flight(log: ULog, truth: Truth, run: dict[str, object]) -> Flight:
    """`run`: the facts that the flight program printed."""
    attitude = topic(log, "vehicle_attitude")
    setpoint = topic(log, "trajectory_setpoint")
    status = topic(log, "vehicle_status")
    return Flight(
        truth=truth,
        attitude_time_s=seconds(attitude["timestamp_sample"]),
        attitude_q=columns(attitude, indexed("q", 4)),
        setpoint_time_s=seconds(setpoint["timestamp"]),
        setpoint=columns(setpoint, indexed("position", 3)),
        status_time_s=seconds(status["timestamp"]),
        nav_state=status["nav_state"].astype(np.int64),
        arming_state=status["arming_state"].astype(np.int64),
        landed=run.get("ended") == "motors_stopped",
        take_off_s=_number(run, "take_off_s"),
        touchdown_s=_number(run, "touchdown_s"),
        touchdown_m_s=_number(run, "touchdown_m_s"),
    )


# --- parts ---


def open_log(path: Path) -> ULog:
    """Raises `UnreadableFlight` if the log has no whole beginning: a machine too busy to store
    blocks loses whole ones, perhaps the first."""
    from pyulog import ULog

    if path.stat().st_size == 0:
        raise UnreadableFlight("cannot judge the flight: the log is empty")
    try:
        return ULog(str(path))
    except Exception:  # a damaged file can raise any exception in the reader
        raise UnreadableFlight(
            "cannot judge the flight: the beginning of the log was lost, as the machine was busy"
        ) from None


def topic(log: ULog, name: str) -> dict[str, NDArray[np.generic]]:
    for dataset in log.data_list:
        if dataset.name == name and dataset.multi_id == 0:
            data: dict[str, NDArray[np.generic]] = dataset.data
            return data
    raise UnreadableFlight(f"cannot judge the flight: missing topic {name} in the log")


def seconds(time_us: NDArray[np.generic]) -> Floats:
    return time_us.astype(np.float64) * 1e-6


def indexed(name: str, count: int) -> list[str]:
    """The names of the elements of an array in pyulog."""
    return [f"{name}[{i}]" for i in range(count)]


def columns(data: dict[str, NDArray[np.generic]], names: list[str]) -> Floats:
    return np.column_stack([data[name] for name in names]).astype(np.float64)


def _number(run: dict[str, object], key: str) -> float | None:
    value = run.get(key)
    return float(value) if isinstance(value, int | float) else None


def newest(times: Floats, values: Floats, at: Floats) -> Floats:
    """The newest of `values` at each time `at`; NaN before the first."""
    index = np.searchsorted(times, at, side="right") - 1
    found = np.full((at.size, *values.shape[1:]), np.nan)
    found[index >= 0] = values[index[index >= 0]]
    return found


def in_flight(flight: Flight, time_s: Floats) -> NDArray[np.bool_]:
    begin = math.inf if flight.take_off_s is None else flight.take_off_s
    end = math.inf if flight.touchdown_s is None else flight.touchdown_s
    rows: NDArray[np.bool_] = (time_s >= begin) & (time_s < end)
    return rows
