"""The data of a picture of a flight: from its log, and if they exist, from the true flight and the
report beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from stator.diagnostics import UserError
from stator.flight.log import (
    ARMED,
    NAV_STATES,
    Floats,
    Truth,
    UnreadableFlight,
    columns,
    indexed,
    read_truth,
    seconds,
    topic,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from pyulog import ULog

DISARMED_MODE = -1
Mode: TypeAlias = tuple[float, float, str]  # from, to, name


@dataclass(frozen=True)
class Series:
    """One quantity over time; one column for each component."""

    time_s: Floats
    values: Floats


@dataclass(frozen=True)
class Flown:
    """The data of the picture; None or empty if the log lacks it. Frame N, m, rad."""

    title: str
    truth: Truth | None
    position: Series | None
    setpoint: Series | None
    attitude: Series | None  # q_NB
    motors: Series | None
    modes: list[Mode]
    facts: dict[str, Any]  # of the flight's report


def open_log(file: Path) -> ULog:
    """Raises `UserError` for an unreadable one."""
    from pyulog import ULog

    try:
        return ULog(str(file))
    except OSError as error:
        raise UserError(
            f"error: cannot read '{file}': {error.strerror}\n"
            "hint: ./stator fly writes a log, and prints its path"
        ) from None
    except Exception as error:  # a damaged file can raise any exception in the reader
        raise UserError(f"error: cannot read '{file}' as ULog: {error}") from None


def read(file: Path) -> Flown:
    log = open_log(file)
    flown = Flown(
        title=str(log.msg_info_dict.get("graph", file.stem)),
        truth=_truth(file),
        position=_series(log, "vehicle_local_position", ["x", "y", "z"]),
        setpoint=_series(log, "trajectory_setpoint", indexed("position", 3)),
        attitude=_series(log, "vehicle_attitude", indexed("q", 4)),
        motors=_series(log, "actuator_motors", indexed("control", _rotors(log))),
        modes=list(modes_of_log(log)),
        facts=report_beside(file),
    )
    if flown.position is None and flown.truth is None:
        raise UserError(
            f"error: missing topic vehicle_local_position in '{file}': there is no path to draw\n"
            "hint: check that the graph logs it: ./stator explain GRAPH vehicle_local_position"
        )
    return flown


def _truth(file: Path) -> Truth | None:
    truth = file.with_suffix(".truth")
    try:
        return read_truth(truth) if truth.is_file() else None
    except UnreadableFlight as unreadable:
        raise UserError(
            f"error: {unreadable}\nhint: remove that file to draw the log alone"
        ) from None


def report_beside(file: Path) -> dict[str, Any]:
    """The report that `fly` writes beside the log."""
    report = file.with_suffix(".json")
    if not report.is_file():
        return {}
    facts: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    return facts


def _rotors(log: ULog) -> int:
    """How many motors the vehicle has: its log says it as a parameter."""
    return int(log.initial_parameters.get("allocation.rotor_count", 4))


def _series(log: ULog, name: str, names: list[str]) -> Series | None:
    try:
        data = topic(log, name)
    except UnreadableFlight:
        return None
    return Series(seconds(data["timestamp"]), columns(data, names))


def modes_of_log(log: ULog) -> Iterator[Mode]:
    """From, to, name of the flight mode; disarmed, the mode does not matter."""
    try:
        status = topic(log, "vehicle_status")
    except UnreadableFlight:
        return
    time_s = seconds(status["timestamp"])
    armed = status["arming_state"].astype(int) == ARMED
    state = np.where(armed, status["nav_state"].astype(int), DISARMED_MODE)
    edges = [0, *(np.flatnonzero(np.diff(state)) + 1), state.size]
    for begin, end in pairwise(edges):
        until = time_s[end] if end < state.size else time_s[-1]
        number = int(state[begin])
        name = "disarmed" if number == DISARMED_MODE else NAV_STATES.get(number, f"mode {number}")
        yield float(time_s[begin]), float(until), name
