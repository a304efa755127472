"""A ground station calibrates the gyro and the horizon of a vehicle that stands on the ground, as
QGroundControl does; the vehicle flies with it, and the flight replays."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING, Any

import numpy as np
from pyulog import ULog
from tests.flight.mavlink.vehicle import COMMAND, Station, mavlink, met

if TYPE_CHECKING:
    from pathlib import Path

CALIBRATE = mavlink.MAV_CMD_PREFLIGHT_CALIBRATION
AXES = "XYZ"


def read(station: Station, name: str) -> float:
    station.link.mav.param_request_read_send(1, 1, name.encode(), -1)
    value: float = station.wait("PARAM_VALUE", lambda v: v.param_id == name).param_value
    return value


def calibrate(station: Station, *params: float) -> list[str]:
    """The lines until its end."""
    station.accept(CALIBRATE, *params)
    lines: list[str] = []
    while not lines or not lines[-1].startswith(("[cal] calibration done", "[cal] calibration f")):
        text = station.wait("STATUSTEXT", lambda t: t.text.startswith("[cal]")).text
        lines.append(text)
    return lines


def turn_a_motor(station: Station) -> None:
    """The third, for half a second. Ground stations are heard by their heartbeats."""
    while True:
        station.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4)
        result = station.command(mavlink.MAV_CMD_DO_MOTOR_TEST, 3, 0, 10, 0.5, 1)
        if result == mavlink.MAV_RESULT_ACCEPTED:
            return
        assert result == mavlink.MAV_RESULT_TEMPORARILY_REJECTED


def rates_at_rest(log: ULog, begin_us: float, end_us: float) -> Any:
    gyro = log.get_dataset("sensor_gyro").data
    among = (gyro["timestamp"] >= begin_us) & (gyro["timestamp"] < end_us)
    assert among.sum() > 40
    return np.array([gyro[f"xyz[{i}]"][among].mean() for i in range(3)])


def test_gyro_and_level(tmp_path: Path) -> None:
    log = tmp_path / "calibration.ulg"
    with met(log) as (station, facts):
        # What there is not, and two at once.
        assert station.command(CALIBRATE, 0, 0, 0, 0, 0, 1) == mavlink.MAV_RESULT_UNSUPPORTED
        station.accept(CALIBRATE, 0, 1)
        rejected = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        station.wait("STATUSTEXT", lambda t: t.text == "[cal] calibration started: 2 mag")
        assert station.command(CALIBRATE, 1) == rejected
        station.accept(CALIBRATE)
        station.wait("STATUSTEXT", lambda t: t.text == "[cal] calibration cancelled")

        before_us = station.wait("ATTITUDE").time_boot_ms * 1e3
        lines = calibrate(station, 1)
        assert lines[0] == "[cal] calibration started: 2 gyro"
        assert "[cal] progress <50>" in lines
        assert lines[-1] == "[cal] calibration done: gyro"
        offset = np.array([read(station, f"CAL_GYRO0_{axis}OFF") for axis in AXES])
        assert calibrate(station, 0, 0, 0, 0, 2)[-1] == "[cal] calibration done: level"
        after_us = station.wait("ATTITUDE").time_boot_ms * 1e3
        station.wait("ATTITUDE", lambda a: a.time_boot_ms * 1e3 > after_us + 2e6)
        station.take_off()
        assert station.command(CALIBRATE, 1) == rejected, "not in flight"
        station.accept(mavlink.MAV_CMD_NAV_LAND)
        station.wait_armed(False)
        turn_a_motor(station)
        tested_us = station.wait("ATTITUDE").time_boot_ms * 1e3
        station.wait("ATTITUDE", lambda a: a.time_boot_ms * 1e3 > tested_us + 3e6)
    assert facts["success"], facts["problems"]
    flight = ULog(str(log))
    # The sensor's own offset is what it shows before; it is known to the mean of 5 s.
    true_offset = rates_at_rest(flight, before_us - 2e6, before_us)
    assert np.abs(true_offset).max() > 2e-3, "this vehicle has an offset to find"
    assert np.abs(offset - true_offset).max() < 1.5e-3
    left = rates_at_rest(flight, after_us, after_us + 2e6)
    assert np.abs(left).max() < 1e-3
    assert np.abs(left).max() < 0.3 * np.abs(true_offset).max()
    # Level: gravity is along the axis down.
    accel = flight.get_dataset("sensor_accel").data
    among = (accel["timestamp"] >= after_us) & (accel["timestamp"] < after_us + 2e6)
    for i in range(2):
        assert abs(accel[f"xyz[{i}]"][among].mean()) < 0.02
    # The motor that was tested turned alone, and for its time.
    motors = flight.get_dataset("actuator_motors").data
    others = [np.isnan(motors[f"control[{other}]"]) for other in (0, 1, 3)]
    alone = (motors["control[2]"] > 0.0) & np.all(others, axis=0)
    times_us = motors["timestamp"][alone]
    assert 0.3e6 < times_us[-1] - times_us[0] < 0.5e6
    assert np.allclose(motors["control[2]"][alone], 0.1)
    replayed = subprocess.run(
        [*COMMAND, "replay", str(log)], capture_output=True, text=True, check=False
    )
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
