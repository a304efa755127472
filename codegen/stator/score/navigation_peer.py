"""The results of another estimator on the same data, with the metrics of the node."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stator.score.navigation_metrics import (
    HELD_OUT_US,
    INNOVATIONS,
    FlightScore,
    HoldOut,
    attitude_score,
    onboard_rows,
    returning_fixes,
    rms,
    summary,
)
from stator.score.recordings import GNSS, IMU, START_US, Array, Flight

if TYPE_CHECKING:
    from collections.abc import Mapping

GRAVITY = 9.80665


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
    """The position of the other estimator from its own state and biases and the IMU alone. Its
    biases are angles and velocities per IMU sample."""
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
        if row < 0:
            errors.append(float("inf"))
            continue
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
