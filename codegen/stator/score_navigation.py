"""`stator score navigation DIR`: the navigation node over recorded flights, beside what others
computed from the same recordings."""

from __future__ import annotations

import json
import subprocess
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stator.flight_recordings import (
    GNSS,
    IMU,
    START_US,
    Array,
    Flight,
    RecordingError,
    flights_in,
    write_rows,
)
from stator.library import HOME

if TYPE_CHECKING:
    from collections.abc import Mapping

GRAPH = HOME / "graph" / "navigation_recording.yaml"
BOARD = "replay"
EPILOG = """\
navigation: a recorded flight is NAME.zip, text tables as the InertialNav project has them (IMU,
GPS, MAG, NTUN, ATT, timing), beside it NAME_peer_*.csv.gz if there is one; or NAME_replay.csv.gz,
an input of PX4's estimator tests, beside it NAME_reference*.csv."""

SETTLED_US = 2e6  # after the start, for level and the first fixes
GRID_US = 1e5  # innovations are held, and counted at 10 Hz
HELD_OUT_US, PERIOD_US = 10e6, 30e6  # the last third of every 30 s is without satellites
REFERENCE_END_US = 34.5e6  # the reference's last rows come from reading past the input
GRAVITY = 9.80665
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
    """Horizontal error when satellites return."""

    windows: int
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


# --- what others and the node say ---


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
                "the node said nothing about this flight", "it needs a second of IMU samples"
            )
        return self._topics[name]

    def held(self, name: str, fields: list[str], times: Array) -> Array:
        """Columns of the newest samples at these times."""
        data = self.topic(name)
        at = np.searchsorted(data["timestamp"].astype(np.float64), times, side="right") - 1
        result: Array = np.column_stack([data[field][np.maximum(at, 0)] for field in fields])
        return result


def replay(program: Path, rows: Array) -> Log:
    with tempfile.TemporaryDirectory() as folder:
        recording, log = Path(folder) / "recording", Path(folder) / "flight.ulg"
        write_rows(recording, rows)
        subprocess.run([program, "--recording", recording, "--log", log], check=True)
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
    """Of Euler angles; the tilt is the angle between what both take for down."""
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
    if not errors:
        return HoldOut(0, float("nan"), float("nan"))
    p50, p95 = np.percentile(errors, [50, 95])
    return HoldOut(len(errors), float(p50), float(p95))


def hold_out(flight: Flight, program: Path) -> HoldOut:
    data = replay(program, held_out(flight)).topic("estimator_innovations")
    measured = data["timestamp_sample"].astype(np.float64)
    errors = []
    for fix in returning_fixes(flight):
        found = np.flatnonzero(np.abs(measured - np.floor(fix[2])) < 1)
        if len(found):
            north, east = (data[f"gps_hpos[{i}]"][found[0]] for i in range(2))
            errors.append(float(np.hypot(north, east)))
    return summary(errors)


# --- the peer ---


def turned(q: Array, angle: Array) -> Array:
    """The quaternion q after a turn by the rotation vector in the body."""
    size = float(np.linalg.norm(angle))
    x, y, z = angle * (np.sin(size / 2) / size if size > 1e-9 else 0.5)
    w, a, b, c = q
    d = np.cos(size / 2)
    product = np.array(
        [
            w * d - a * x - b * y - c * z,
            w * x + a * d + b * z - c * y,
            w * y - a * z + b * d + c * x,
            w * z + a * y - b * x + c * d,
        ]
    )
    result: Array = product / np.linalg.norm(product)
    return result


def matrix(q: Array) -> Array:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def local(fixes: Array) -> Array:
    """North and east of the first fix, on the sphere that the peer uses."""
    lat, lon = np.radians(fixes[:, 3]), np.radians(fixes[:, 4])
    radius = 6378145.0
    return np.column_stack([radius * (lat - lat[0]), radius * np.cos(lat[0]) * (lon - lon[0])])


def coast(peer: Mapping[str, Array], row: int, imu: Array, until_us: float) -> Array:
    """Where the peer would have been by its own state and biases and the IMU alone. Its biases are
    angles and velocities per IMU sample."""
    q = np.array([peer[f"q{i}"][row] for i in range(4)])
    v = np.array([peer[name][row] for name in ("vn", "ve", "vd")])
    p = np.array([peer[name][row] for name in ("pn", "pe", "pd")])
    gyro_bias = np.array([peer[f"dangb{axis}"][row] for axis in "xyz"])
    accel_bias = np.array([0.0, 0.0, peer["dvbz"][row]])
    start = np.searchsorted(imu[:, 0], peer["t_s"][row] * 1e6 + START_US, side="right")
    for i in range(max(int(start), 1), len(imu)):
        if imu[i, 0] > until_us:
            break
        dt = (imu[i, 0] - imu[i - 1, 0]) * 1e-6
        angle = 0.5 * (imu[i, 3:6] + imu[i - 1, 3:6]) * dt - gyro_bias
        push = 0.5 * (imu[i, 6:9] + imu[i - 1, 6:9]) * dt - accel_bias
        before = v
        v = v + matrix(q) @ (push + 0.5 * np.cross(angle, push)) + np.array([0, 0, GRAVITY * dt])
        p = p + 0.5 * (before + v) * dt
        q = turned(q, angle)
    north_east: Array = p[:2]
    return north_east


def peer_hold_out(flight: Flight) -> HoldOut:
    peer, fixes, imu = flight.peer, flight.of(GNSS), flight.of(IMU)
    times = peer["t_s"] * 1e6 + START_US
    seen = local(fixes)
    own = np.column_stack([np.interp(fixes[:, 2], times, peer[name]) for name in ("pn", "pe")])
    origin = np.median((own - seen)[len(fixes) // 10 :], axis=0)
    errors = []
    for fix in returning_fixes(flight):
        row = int(np.searchsorted(times, fix[0] - HELD_OUT_US, side="right")) - 1
        found = int(np.searchsorted(fixes[:, 0], fix[0]))
        if row >= 0:
            at = coast(peer, row, imu, fix[2])
            errors.append(float(np.hypot(*(at - seen[found] - origin))))
    return summary(errors)


def peer_score(flight: Flight) -> FlightScore | None:
    peer = flight.peer
    needed = {"t_s", "roll_est", "pitch_est", "yaw_est", *(b for _, b in INNOVATIONS.values())}
    if not needed <= peer.keys():
        return None
    onboard = onboard_rows(flight)
    times = peer["t_s"] * 1e6 + START_US
    angles = np.column_stack(
        [
            np.interp(onboard[:, 0], times, np.unwrap(peer[f"{name}_est"]))
            for name in ("roll", "pitch", "yaw")
        ]
    )
    return FlightScore(
        attitude_score(angles, onboard[:, 1:]),
        {key: rms(peer[name]) for key, (_, name) in INNOVATIONS.items()},
        peer_hold_out(flight),
    )


# --- scores ---


def flight_score(flight: Flight, program: Path) -> FlightScore:
    log = replay(program, flight.rows)
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
    log = replay(program, flight.rows)
    rows = flight.reference
    rows = rows[(rows[:, 0] > START_US + SETTLED_US) & (rows[:, 0] < START_US + REFERENCE_END_US)]
    attitude = attitude_score(attitudes(log, rows[:, 0]), euler(rows[:, 1:5]))
    velocity = log.held("vehicle_local_position", ["vx", "vy", "vz"], rows[:, 0]) - rows[:, 5:8]
    down = log.held("vehicle_local_position", ["z"], rows[:, 0])[:, 0]
    change = (down - down[0]) - (rows[:, 10] - rows[0, 10])
    speed = float(np.sqrt(np.mean(np.sum(velocity**2, axis=1))))
    return ReferenceScore(attitude.tilt_deg, attitude.yaw_deg, speed, rms(change))


# --- the command ---


def show_flight(name: str, ours: FlightScore, peer: FlightScore | None) -> None:
    def line(what: str, unit: str, mine: float, other: float | None) -> str:
        beside = "" if other is None else f"{other:.2f}"
        return f"  {what:<28} {mine:9.2f} {beside:>9}  {unit}"

    print(f"{name:<30} {'here':>9} {'' if peer is None else 'peer':>9}".rstrip())
    for key, value in asdict(ours.attitude).items():
        other = None if peer is None else getattr(peer.attitude, key)
        print(line(f"{key.removesuffix('_deg')} against onboard", "deg RMS", value, other))
    for key, value in ours.innovations.items():
        what, unit = (key[:-4], "m/s RMS") if key.endswith("_m_s") else (key[:-2], "m RMS")
        other = None if peer is None else peer.innovations[key]
        print(line(f"innovation {what.replace('_', ' ')}", unit, value, other))
    for key, what in (("p50_m", "half"), ("p95_m", "95 %")):
        other = None if peer is None else getattr(peer.hold_out, key)
        unit = f"m at most, in {what} of {ours.hold_out.windows} windows"
        print(line("10 s without satellites", unit, getattr(ours.hold_out, key), other))


def show_reference(name: str, score: ReferenceScore) -> None:
    print(f"{name + ', against the reference':<30} {'here':>9}")
    rows = {
        "tilt": (score.tilt_deg, "deg RMS"),
        "yaw": (score.yaw_deg, "deg RMS"),
        "velocity": (score.velocity_m_s, "m/s RMS"),
        "height change": (score.height_change_m, "m RMS"),
    }
    for what, (value, unit) in rows.items():
        print(f"  {what:<28} {value:9.2f}  {unit}")


def known(value: object) -> object:
    """JSON has no NaN: what could not be measured is null."""
    if isinstance(value, dict):
        return {key: known(item) for key, item in value.items()}
    return None if isinstance(value, float) and np.isnan(value) else value


def main(folder: Path, *, as_json: bool) -> None:
    from stator.build import build

    flights = flights_in(folder)
    program = build(GRAPH, BOARD)
    result: list[dict[str, object]] = []
    for flight in flights:
        if len(flight.reference):
            reference = reference_score(flight, program)
            result.append({"name": flight.name, "reference": asdict(reference)})
            if not as_json:
                show_reference(flight.name, reference)
            continue
        ours, peer = flight_score(flight, program), peer_score(flight)
        beside = None if peer is None else asdict(peer)
        result.append({"name": flight.name, **asdict(ours), "peer": beside})
        if not as_json:
            show_flight(flight.name, ours, peer)
    if as_json:
        print(json.dumps({"recordings": [known(row) for row in result]}, indent=2))
