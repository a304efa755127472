"""A station and a computer on board steer the vehicle: setpoints, sticks, and what happens when
they fall silent. All times are the vehicle's."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from pyulog import ULog
from tests.flight.mavlink.vehicle import mavlink, met

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tests.flight.mavlink.vehicle import Station

OFFBOARD = 6 << 16
POSITION_AND_YAW = 0x9F8
VELOCITY_AND_YAW = 0x9C7
SEND_S = 0.05
HOLD, RETURN, POSITION, OFFBOARD_MODE = 4, 5, 2, 14
RC_LOST, STATION_LOST, OFFBOARD_LOST = 7, 8, 9


class Steering:
    """The setpoint that is sent now."""

    def __init__(self, station: Station) -> None:
        self.mav = station.link.mav
        self.values = (VELOCITY_AND_YAW, *[0.0] * 11)

    def go(self, north: float, east: float, down: float, yaw: float = 0.0) -> None:
        self.values = (POSITION_AND_YAW, north, east, down, *[0.0] * 6, yaw, 0.0)

    def move(self, north: float, east: float, down: float) -> None:
        self.values = (VELOCITY_AND_YAW, 0, 0, 0, north, east, down, 0, 0, 0, 0.0, 0.0)

    def send(self) -> None:
        mask, *numbers = self.values
        self.mav.set_position_target_local_ned_send(0, 1, 1, 1, mask, *numbers)


def there(north: float, east: float, down: float, within: float) -> Callable[[Any], bool]:
    return lambda p: math.dist((p.x, p.y, p.z), (north, east, down)) < within


def topic(log: Path, name: str) -> dict[str, Any]:
    data: dict[str, Any] = next(d.data for d in ULog(str(log)).data_list if d.name == name)
    return data


def change(log: Path, field: str, value: int) -> float:
    """When vehicle_status first has this value, in s."""
    status = topic(log, "vehicle_status")
    row = int(np.flatnonzero(status[field] == value)[0])
    return float(status["timestamp"][row]) * 1e-6


def last_before(log: Path, name: str, time_s: float) -> float:
    """When the last sample before was published, in s."""
    times = topic(log, name)["timestamp"] * 1e-6
    return float(times[times < time_s][-1])


def test_setpoints_fly_it_and_their_end_holds(tmp_path: Path) -> None:
    log = tmp_path / "offboard.ulg"
    with met(log) as (station, facts):
        refused = station.command(mavlink.MAV_CMD_DO_SET_MODE, 1, 6, 0)
        assert refused == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        start = station.wait("LOCAL_POSITION_NED")
        steering = Steering(station)
        steering.go(start.x, start.y, start.z - 5.0)
        with station.clock.repeated(steering.send, SEND_S):
            station.wait("LOCAL_POSITION_NED")
            station.accept(mavlink.MAV_CMD_DO_SET_MODE, 1, 6, 0)
            station.wait("HEARTBEAT", lambda beat: beat.custom_mode == OFFBOARD)
            station.accept(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)  # it takes off by setpoints
            for north, east in ((0.0, 0.0), (5.0, 0.0), (5.0, 5.0), (0.0, 0.0)):
                place = (start.x + north, start.y + east, start.z - 5.0)
                steering.go(*place)
                station.wait("LOCAL_POSITION_NED", there(*place, 0.5))
            steering.move(3.0, 0.0, 0.0)
            station.wait("LOCAL_POSITION_NED", lambda p: p.x > start.x + 8.0)
        station.wait("HEARTBEAT", lambda beat: beat.custom_mode == 4 << 16 | 3 << 24)
        station.wait("LOCAL_POSITION_NED", lambda p: math.hypot(p.vx, p.vy, p.vz) < 0.2)
        station.accept(mavlink.MAV_CMD_NAV_LAND)
        station.wait_armed(False)
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0
    lost_s = change(log, "failsafe_event", OFFBOARD_LOST)
    assert 0.9 < lost_s - last_before(log, "offboard_setpoint", lost_s) < 1.5


def test_an_attitude_and_rates_are_flown(tmp_path: Path) -> None:
    log = tmp_path / "attitude.ulg"
    with met(log) as (station, facts):
        station.take_off()
        station.wait_mode("LOITER")
        half = math.radians(10.0) / 2.0
        lean = (math.cos(half), 0.0, -math.sin(half), 0.0)  # nose down: to the north
        begin = station.wait("LOCAL_POSITION_NED")

        def send() -> None:
            station.link.mav.set_attitude_target_send(0, 1, 1, 7, lean, 0, 0, 0, 0.55)

        with station.clock.repeated(send, SEND_S):
            station.wait("LOCAL_POSITION_NED")
            station.accept(mavlink.MAV_CMD_DO_SET_MODE, 1, 6, 0)
            station.wait("ATTITUDE", lambda a: abs(math.degrees(a.pitch) + 10.0) < 2.0)
            station.wait("LOCAL_POSITION_NED", lambda p: p.x > begin.x + 3.0)
            station.accept(mavlink.MAV_CMD_DO_SET_MODE, 1, 4, 3)
        station.wait("LOCAL_POSITION_NED", lambda p: math.hypot(p.vx, p.vy, p.vz) < 0.2)
        station.accept(mavlink.MAV_CMD_NAV_LAND)
        station.wait_armed(False)
    assert facts["success"], facts["reason"]


def test_sticks_of_a_station_fly_it_and_their_silence_is_a_loss(tmp_path: Path) -> None:
    """The simulated radio is heard all the time, with its sticks in the middle."""
    log = tmp_path / "sticks.ulg"
    with met(log) as (station, facts):
        station.take_off()
        station.wait_mode("LOITER")
        begin = station.wait("LOCAL_POSITION_NED")

        def send() -> None:
            station.link.mav.manual_control_send(1, 600, 0, 500, 0, 0)

        with station.clock.repeated(send, SEND_S):
            station.wait("LOCAL_POSITION_NED")
            station.accept(mavlink.MAV_CMD_DO_SET_MODE, 1, 3, 0)
            station.wait(
                "LOCAL_POSITION_NED", lambda p: math.hypot(p.x - begin.x, p.y - begin.y) > 10.0
            )
        station.wait_mode("RTL")
        station.wait_armed(False)
    assert facts["success"], facts["reason"]
    lost_s = change(log, "failsafe_event", RC_LOST)
    assert 0.5 < lost_s - last_before(log, "station_sticks", lost_s) < 1.0


def test_a_station_that_falls_silent_is_lost(tmp_path: Path) -> None:
    log = tmp_path / "station.ulg"
    with met(log) as (station, facts):
        mav = station.link.mav
        for name, value in ((b"NAV_DLL_ACT", 2), (b"COM_DL_LOSS_T", 5)):
            real = name == b"COM_DL_LOSS_T"
            number = float(value) if real else int_as_float(value)
            mav.param_set_send(1, 1, name, number, 9 if real else 6)
            station.wait("PARAM_VALUE", lambda v, name=name: v.param_id == name.decode())

        def send() -> None:
            mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)

        with station.clock.repeated(send, 0.5):
            station.take_off()
            station.wait_mode("LOITER")
        station.wait_mode("RTL")
        station.wait_armed(False)
    assert facts["success"], facts["reason"]
    lost_s = change(log, "failsafe_event", STATION_LOST)
    assert 4.9 < lost_s - last_before(log, "station_heartbeat", lost_s) < 6.0


def int_as_float(value: int) -> float:
    """The float with the bits of this number."""
    return float(np.int32(value).view(np.float32))
