"""Metrics of the navigation node on recorded flights: attitudes, innovations, and the position
error after a time without satellites."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stator.processes import run
from stator.score.recordings import (
    GNSS,
    START_US,
    Array,
    Flight,
    RecordingError,
    write_rows,
)

SETTLED_US = 2e6  # after the start, for level and the first fixes
GRID_US = 1e5  # innovations are held, and counted at 10 Hz
HELD_OUT_US, PERIOD_US = 10e6, 30e6  # the last third of every 30 s is without satellites
REFERENCE_END_US = 34.5e6  # the reference's last rows come from reading past the input
INNOVATIONS = {
    "velocity_north_m_s": ("gps_hvel[0]", "inn_vn"),
    "velocity_east_m_s": ("gps_hvel[1]", "inn_ve"),
    "velocity_down_m_s": ("gps_vvel", "inn_vd"),
    "position_north_m": ("gps_hpos[0]", "inn_pn"),
    "position_east_m": ("gps_hpos[1]", "inn_pe"),
    "height_m": ("baro_vpos", "inn_pd"),
}


@dataclass(frozen=True)
class AttitudeScore:
    """Root mean squares in degrees."""

    tilt_deg: float
    roll_deg: float
    pitch_deg: float
    yaw_deg: float


@dataclass(frozen=True)
class HoldOut:
    """Horizontal error when satellites return. A missed window is one without an estimate at the
    first fix after it; it counts as an error beyond all others."""

    windows: int
    missed: int
    p50_m: float
    p95_m: float


@dataclass(frozen=True)
class FlightScore:
    attitude: AttitudeScore
    innovations: dict[str, float]
    hold_out: HoldOut


@dataclass(frozen=True)
class ReferenceScore:
    """Root mean squares of the difference to another estimator."""

    tilt_deg: float
    yaw_deg: float
    velocity_m_s: float
    height_change_m: float


# --- results of the node and of other software ---


class Log:
    """Topics of a run, by field."""

    def __init__(self, path: Path) -> None:
        from pyulog import ULog

        self._topics: dict[str, dict[str, Array]] = {
            dataset.name: dataset.data for dataset in ULog(str(path)).data_list
        }

    def topic(self, name: str) -> dict[str, Array]:
        if name not in self._topics:
            raise RecordingError(
                "the node published nothing in this flight",
                "use a flight with at least one second of IMU samples",
            )
        return self._topics[name]

    def held(self, name: str, fields: list[str], times: Array) -> Array:
        """Columns of the newest samples at these times."""
        data = self.topic(name)
        at = np.searchsorted(data["timestamp"].astype(np.float64), times, side="right") - 1
        result: Array = np.column_stack([data[field][np.maximum(at, 0)] for field in fields])
        return result


def play_back(program: Path, rows: Array) -> Log:
    with tempfile.TemporaryDirectory() as folder:
        recording, log = Path(folder) / "recording", Path(folder) / "flight.ulg"
        write_rows(recording, rows)
        run([program, "--recording", recording, "--log", log], check=True)
        return Log(log)


# --- attitudes ---


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if np.size(values) else float("nan")


def euler(q: Array) -> Array:
    """Columns roll, pitch, yaw of quaternions w x y z."""
    w, x, y, z = q.T
    result: Array = np.column_stack(
        [
            np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
            np.arcsin(np.clip(2 * (w * y - z * x), -1, 1)),
            np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ]
    )
    return result


def down_in_body(angles: Array) -> Array:
    roll, pitch = angles[:, 0], angles[:, 1]
    return np.column_stack(
        [-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)]
    )


def wrapped_deg(angle: Array) -> Array:
    result: Array = (np.degrees(angle) + 180) % 360 - 180
    return result


def attitude_score(ours: Array, others: Array) -> AttitudeScore:
    """The error of Euler angles; the tilt is the angle between the two estimates of down."""
    cosine = np.sum(down_in_body(ours) * down_in_body(others), axis=1)
    difference = wrapped_deg(ours - others)
    roll, pitch, yaw = (rms(difference[:, i]) for i in range(3))
    return AttitudeScore(rms(np.degrees(np.arccos(np.clip(cosine, -1, 1)))), roll, pitch, yaw)


def attitudes(log: Log, times: Array) -> Array:
    return euler(log.held("vehicle_attitude", [f"q[{i}]" for i in range(4)], times))


def onboard_rows(flight: Flight) -> Array:
    """Where the onboard attitude is new and the node has settled, at 10 Hz at most."""
    rows = flight.onboard
    rows = rows[rows[:, 0] > flight.rows[0, 0] + SETTLED_US]
    rows = rows[np.append(True, np.diff(rows[:, 0]) > 0)] if len(rows) else rows
    step_us = float(np.median(np.diff(rows[:, 0]))) if len(rows) > 1 else GRID_US
    result: Array = rows[:: max(1, round(GRID_US / step_us))]
    return result


# --- without satellites ---


def window_ends(flight: Flight) -> Array:
    return np.arange(flight.rows[0, 0] + PERIOD_US, flight.rows[-1, 0], PERIOD_US)


def held_out(flight: Flight) -> Array:
    """The rows without the satellite fixes of each window."""
    phase = (flight.rows[:, 0] - flight.rows[0, 0]) % PERIOD_US
    hidden = (flight.rows[:, 1] == GNSS) & (phase >= PERIOD_US - HELD_OUT_US)
    result: Array = flight.rows[~hidden]
    return result


def returning_fixes(flight: Flight) -> list[Array]:
    """The first fix after each window."""
    fixes = flight.of(GNSS)
    at = np.searchsorted(fixes[:, 0], window_ends(flight))
    return [fixes[i] for i in at if i < len(fixes)]


def summary(errors: list[float]) -> HoldOut:
    """Quantiles of the errors of all windows; the error of a missed window is infinite."""
    missed = sum(np.isinf(errors))
    if not errors:
        return HoldOut(0, 0, float("nan"), float("nan"))
    # Between a number and infinity, or two infinities, NumPy may say NaN.
    with np.errstate(invalid="ignore"):
        p50, p95 = np.nan_to_num(np.percentile(errors, [50, 95]), nan=np.inf, posinf=np.inf)
    return HoldOut(len(errors), int(missed), float(p50), float(p95))


def hold_out(flight: Flight, program: Path) -> HoldOut:
    data = play_back(program, held_out(flight)).topic("estimator_innovations")
    measured = data["timestamp_sample"].astype(np.float64)
    errors = []
    for fix in returning_fixes(flight):
        found = np.flatnonzero(np.abs(measured - np.floor(fix[2])) < 1)
        if not len(found):
            errors.append(float("inf"))
            continue
        north, east = (data[f"gps_hpos[{i}]"][found[0]] for i in range(2))
        errors.append(float(np.hypot(north, east)))
    return summary(errors)


# --- scores ---


def flight_score(flight: Flight, program: Path) -> FlightScore:
    log = play_back(program, flight.rows)
    onboard = onboard_rows(flight)
    times = np.arange(flight.rows[0, 0] + SETTLED_US, flight.rows[-1, 0], GRID_US)
    fields = [ours for ours, _ in INNOVATIONS.values()]
    held = log.held("estimator_innovations", fields, times)
    return FlightScore(
        attitude_score(attitudes(log, onboard[:, 0]), onboard[:, 1:]),
        {key: rms(held[:, i]) for i, key in enumerate(INNOVATIONS)},
        hold_out(flight, program),
    )


def reference_score(flight: Flight, program: Path) -> ReferenceScore:
    log = play_back(program, flight.rows)
    rows = flight.reference
    rows = rows[(rows[:, 0] > START_US + SETTLED_US) & (rows[:, 0] < START_US + REFERENCE_END_US)]
    attitude = attitude_score(attitudes(log, rows[:, 0]), euler(rows[:, 1:5]))
    velocity = log.held("vehicle_local_position", ["vx", "vy", "vz"], rows[:, 0]) - rows[:, 5:8]
    down = log.held("vehicle_local_position", ["z"], rows[:, 0])[:, 0]
    change = (down - down[0]) - (rows[:, 10] - rows[0, 10])
    speed = float(np.sqrt(np.mean(np.sum(velocity**2, axis=1))))
    return ReferenceScore(attitude.tilt_deg, attitude.yaw_deg, speed, rms(change))
