"""Everything that MAVSDK can ask of the vehicle, in a flight after another. Argument: the port."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import math
import os
import sys
import tempfile
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mavsdk.asyncio import ComponentType, Configuration, Mavsdk
from mavsdk.asyncio.plugins.action import ActionAsync, ActionError
from mavsdk.asyncio.plugins.component_metadata import ComponentMetadataAsync
from mavsdk.asyncio.plugins.ftp import FtpAsync, FtpError
from mavsdk.asyncio.plugins.geofence import GeofenceAsync
from mavsdk.asyncio.plugins.info import InfoAsync
from mavsdk.asyncio.plugins.log_files import LogFilesAsync
from mavsdk.asyncio.plugins.manual_control import ManualControlAsync, ManualControlError
from mavsdk.asyncio.plugins.mission import MissionAsync
from mavsdk.asyncio.plugins.mission_raw import MissionRawAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync, OffboardError
from mavsdk.asyncio.plugins.param import ParamAsync, ParamError
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.plugins.component_metadata import MetadataType
from mavsdk.plugins.geofence import Circle, FenceType, GeofenceData, Point, Polygon
from mavsdk.plugins.mission import MissionItem, MissionPlan
from mavsdk.plugins.mission_raw import MissionItem as RawItem
from mavsdk.plugins.offboard import PositionNedYaw, VelocityNedYaw
from mavsdk.plugins.telemetry import FlightMode, LandedState

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Awaitable, Callable

HANGS_S = 600.0  # of wall time
NAN = math.nan
M_PER_DEG = 111319.5


async def until(stream: AsyncGenerator[Any, None], wanted: Callable[[Any], bool]) -> Any:
    """The first wanted value."""
    async with contextlib.aclosing(stream), asyncio.timeout(HANGS_S):
        async for value in stream:
            if wanted(value):
                return value
    raise AssertionError("the stream ended")


def anything(_: Any) -> bool:
    return True


async def refusal(call: Awaitable[Any], error: type[Exception]) -> str:
    """The result of a call that must fail."""
    try:
        await call
    except error as refused:
        name: str = refused.result.name  # type: ignore[attr-defined]
        return name
    raise AssertionError("it was not refused")


class Vehicle:
    def __init__(self, system: Any) -> None:
        self.action = ActionAsync(system)
        self.fence = GeofenceAsync(system)
        self.files = FtpAsync(system)
        self.info = InfoAsync(system)
        self.logs = LogFilesAsync(system)
        self.metadata = ComponentMetadataAsync(system)
        self.manual = ManualControlAsync(system)
        self.mission = MissionAsync(system)
        self.offboard = OffboardAsync(system)
        self.param = ParamAsync(system)
        self.raw = MissionRawAsync(system)
        self.telemetry = TelemetryAsync(system)
        self.home: Any = None

    def place(self, north: float, east: float) -> tuple[float, float]:
        """Latitude and longitude in degrees, from home."""
        latitude = self.home.latitude_deg + north / M_PER_DEG
        shrinks = math.cos(math.radians(latitude))
        return latitude, self.home.longitude_deg + east / (M_PER_DEG * shrinks)

    async def wait_mode(self, *modes: Any) -> None:
        await until(self.telemetry.subscribe_flight_mode(), lambda mode: mode in modes)

    async def wait_armed(self, is_armed: bool) -> None:
        await until(self.telemetry.subscribe_armed(), lambda armed: armed == is_armed)

    async def wait_height(self, height: float) -> None:
        await until(
            self.telemetry.subscribe_position(), lambda p: p.relative_altitude_m > height - 0.7
        )

    async def take_off(self, height: float) -> None:
        await self.action.set_takeoff_altitude(height)
        await self.action.arm()
        await self.wait_armed(True)
        await self.action.takeoff()
        await self.wait_height(height)

    async def land(self) -> None:
        await self.action.land()
        await self.wait_armed(False)


async def tells_who_it_is(v: Vehicle) -> None:
    version = await v.info.get_version()
    assert version.flight_sw_major == 1
    assert (await v.info.get_identification()).hardware_uid


async def becomes_healthy(v: Vehicle) -> None:
    await until(
        v.telemetry.subscribe_health(),
        lambda h: (
            h.is_gyrometer_calibration_ok
            and h.is_accelerometer_calibration_ok
            and h.is_magnetometer_calibration_ok
            and h.is_local_position_ok
            and h.is_global_position_ok
            and h.is_home_position_ok
            and h.is_armable
        ),
    )
    v.home = await until(v.telemetry.subscribe_home(), anything)


async def tells_how_it_does(v: Vehicle) -> None:
    t = v.telemetry
    await until(t.subscribe_attitude_euler(), lambda a: abs(a.roll_deg) < 5.0)
    await until(t.subscribe_velocity_ned(), lambda u: abs(u.north_m_s) < 1.0)
    await until(t.subscribe_raw_gps(), lambda g: abs(g.latitude_deg - v.home.latitude_deg) < 1e-3)
    await until(t.subscribe_gps_info(), lambda g: g.num_satellites > 5)
    await until(t.subscribe_battery(), lambda b: b.remaining_percent > 50.0)
    await until(t.subscribe_landed_state(), lambda s: s == LandedState.ON_GROUND)
    await until(t.subscribe_heading(), lambda h: 0.0 <= h.heading_deg <= 360.0)
    await until(t.subscribe_position_velocity_ned(), lambda p: abs(p.position.down_m) < 2.0)
    await until(t.subscribe_altitude(), lambda a: abs(a.altitude_relative_m) < 2.0)
    await until(t.subscribe_imu(), lambda i: -11.0 < i.acceleration_frd.down_m_s2 < -9.0)
    await t.set_rate_odometry(10.0)
    await until(t.subscribe_odometry(), lambda o: abs(o.velocity_body.x_m_s) < 1.0)


async def keeps_to_a_rate(v: Vehicle) -> None:
    await v.telemetry.set_rate_attitude_euler(20.0)
    times: list[int] = []

    def is_enough(attitude: Any) -> bool:
        times.append(attitude.timestamp_us)
        return len(times) == 60

    await until(v.telemetry.subscribe_attitude_euler(), is_enough)
    steps = sorted(b - a for a, b in itertools.pairwise(times[10:]))
    assert steps[len(steps) // 2] == 50_000, steps


async def lists_reads_and_sets_parameters(v: Vehicle) -> None:
    everything = await v.param.get_all_params()
    ints = {p.name: p.value for p in everything.int_params}
    floats = {p.name: p.value for p in everything.float_params}
    assert len(ints) + len(floats) > 150
    assert all(len(name) <= 16 for name in (*ints, *floats))
    for name, value in ints.items():
        assert await v.param.get_param_int(name) == value, name
    for name, value in list(ints.items())[:5]:
        await v.param.set_param_int(name, value)
    usual = floats["MIS_TAKEOFF_ALT"]
    await v.param.set_param_float("MIS_TAKEOFF_ALT", usual + 0.5)
    assert await v.param.get_param_float("MIS_TAKEOFF_ALT") == usual + 0.5
    await v.param.set_param_float("MIS_TAKEOFF_ALT", usual)
    unknown = await refusal(v.param.get_param_float("NO_SUCH_PARAM"), ParamError)
    assert unknown == "DOES_NOT_EXIST"
    wrong = await refusal(v.param.get_param_int("MIS_TAKEOFF_ALT"), ParamError)
    assert wrong == "WRONG_TYPE"
    await v.action.set_takeoff_altitude(4.0)
    assert await v.action.get_takeoff_altitude() == 4.0
    height = await v.action.get_return_to_launch_altitude()
    await v.action.set_return_to_launch_altitude(height)


def square(v: Vehicle) -> list[Any]:
    return [
        MissionItem(
            latitude_deg=latitude,
            longitude_deg=longitude,
            relative_altitude_m=5.0,
            speed_m_s=5.0,
            is_fly_through=True,
            acceptance_radius_m=1.0,
            loiter_time_s=NAN,
            gimbal_pitch_deg=NAN,
            gimbal_yaw_deg=NAN,
        )
        for latitude, longitude in (v.place(10, 0), v.place(10, 10), v.place(0, 10))
    ]


async def keeps_a_mission(v: Vehicle) -> None:
    items = square(v)
    await v.mission.upload_mission(MissionPlan(items))
    back = (await v.mission.download_mission()).mission_items
    assert len(back) == len(items)
    for a, b in zip(items, back, strict=True):
        assert abs(a.latitude_deg - b.latitude_deg) < 2e-7
        assert abs(a.longitude_deg - b.longitude_deg) < 2e-7
        assert abs(a.relative_altitude_m - b.relative_altitude_m) < 0.01
    await v.mission.clear_mission()
    assert await v.raw.download_mission() == []


async def keeps_fences_and_rally_points(v: Vehicle) -> None:
    latitude, longitude = v.place(5, 5)
    point = RawItem(
        seq=0,
        frame=3,
        command=5100,
        current=0,
        autocontinue=1,
        param1=0,
        param2=0,
        param3=0,
        param4=0,
        x=round(latitude * 1e7),
        y=round(longitude * 1e7),
        z=10,
        mission_type=2,
    )
    await v.raw.upload_rally_points([point])
    assert [p.x for p in await v.raw.download_rallypoints()] == [point.x]
    circle = Circle(Point(*v.place(0, 0)), 200.0, FenceType.INCLUSION)
    await v.fence.upload_geofence(GeofenceData([], [circle]))
    assert abs((await v.fence.download_geofence()).circles[0].radius - 200.0) < 0.1
    corners = [Point(*v.place(*p)) for p in ((-150, -150), (150, -150), (150, 150), (-150, 150))]
    await v.fence.upload_geofence(GeofenceData([Polygon(corners, FenceType.INCLUSION)], []))
    back = await v.fence.download_geofence()
    assert [len(polygon.points) for polygon in back.polygons] == [4]
    await v.fence.clear_geofence()


async def describes_its_parameters(v: Vehicle) -> None:
    stream = v.metadata.subscribe_metadata_available()
    await v.metadata.request_autopilot_component()
    await until(stream, lambda update: update.type == MetadataType.PARAMETER)
    data = await v.metadata.get_metadata(1, MetadataType.PARAMETER)
    rows = json.loads(data.json_metadata)["parameters"]
    described = {parameter["name"] for parameter in rows}
    everything = await v.param.get_all_params()
    names = {p.name for p in (*everything.int_params, *everything.float_params)}
    assert described == names


async def hands_out_files_and_lists_logs(v: Vehicle) -> None:
    assert "etc" in {e.name for e in (await v.files.list_directory("/")).entries}
    with tempfile.TemporaryDirectory() as folder:

        async def get(stream: AsyncGenerator[Any, None]) -> None:
            async for _ in stream:
                pass

        absent = get(v.files.download("/no/such/file", folder, False))
        assert await refusal(absent, FtpError) == "FILE_DOES_NOT_EXIST"
        for entry in (await v.files.list_directory("/etc")).entries:
            for in_bursts in (False, True):
                await get(v.files.download(f"/etc/{entry.name}", folder, in_bursts))
                local = Path(folder) / entry.name
                assert local.stat().st_size == entry.size_bytes
                assert await v.files.are_files_identical(str(local), f"/etc/{entry.name}")
                local.unlink()
    (log,) = await v.logs.get_entries()  # its download takes minutes
    assert log.size_bytes > 0


async def flies_by_commands(v: Vehicle) -> None:
    t, a = v.telemetry, v.action
    await a.set_takeoff_altitude(5.0)
    await a.arm()
    await v.wait_armed(True)
    is_taking_off = asyncio.ensure_future(v.wait_mode(FlightMode.TAKEOFF))  # it is short
    await a.takeoff()
    await is_taking_off
    await until(t.subscribe_in_air(), bool)
    await v.wait_height(5.0)
    assert await refusal(a.disarm(), ActionError) == "COMMAND_DENIED"
    here = await until(t.subscribe_position(), anything)
    latitude, longitude = v.place(15, 5)
    await a.goto_location(latitude, longitude, here.absolute_altitude_m, 90.0)
    await until(
        t.subscribe_position(),
        lambda p: (
            abs(p.latitude_deg - latitude) < 1e-5 and abs(p.longitude_deg - longitude) < 1.5e-5
        ),
    )
    await a.hold()
    await v.wait_mode(FlightMode.HOLD)
    await a.return_to_launch()
    await v.wait_mode(FlightMode.RETURN_TO_LAUNCH)
    await v.wait_armed(False)
    await until(t.subscribe_landed_state(), lambda s: s == LandedState.ON_GROUND)


async def flies_a_mission(v: Vehicle) -> None:
    m = v.mission
    await m.set_return_to_launch_after_mission(True)
    await m.upload_mission(MissionPlan(square(v)))
    await v.action.arm()
    await m.start_mission()
    await v.wait_mode(FlightMode.MISSION)
    await m.pause_mission()
    await v.wait_mode(FlightMode.HOLD)
    await m.start_mission()
    await v.wait_mode(FlightMode.MISSION)
    end = await until(m.subscribe_mission_progress(), lambda p: p.total and p.current == p.total)
    assert end.total == 3
    await v.wait_armed(False)
    assert await m.is_mission_finished()


async def flies_by_setpoints(v: Vehicle) -> None:
    """MAVSDK repeats setpoints by its own clock: the vehicle waits longer for them than usual."""
    off, t = v.offboard, v.telemetry
    assert await refusal(off.start(), OffboardError) == "NO_SETPOINT_SET"
    await v.param.set_param_float("COM_OF_LOSS_T", 30.0)
    await v.take_off(5.0)
    before = await until(t.subscribe_position_velocity_ned(), anything)
    await off.set_velocity_ned(VelocityNedYaw(0.0, 0.0, 0.0, 0.0))
    async with asyncio.timeout(HANGS_S):
        while True:  # the last setpoint may be too old at the moment
            with contextlib.suppress(OffboardError):
                await off.start()
                break
    await v.wait_mode(FlightMode.OFFBOARD)
    await off.set_velocity_ned(VelocityNedYaw(2.0, 0.0, 0.0, 0.0))
    north = before.position.north_m + 6.0
    await until(t.subscribe_position_velocity_ned(), lambda p: p.position.north_m > north)
    await off.set_position_ned(PositionNedYaw(0.0, 5.0, -6.0, 90.0))

    def is_there(p: Any) -> bool:
        place = (p.position.north_m, p.position.east_m, p.position.down_m)
        return math.dist(place, (0.0, 5.0, -6.0)) < 1.0

    await until(t.subscribe_position_velocity_ned(), is_there)
    await off.stop()
    await v.wait_mode(FlightMode.HOLD)
    await v.land()


async def flies_by_sticks(v: Vehicle) -> None:
    await v.take_off(5.0)
    ends = False

    async def feed() -> None:
        while not ends:
            await v.manual.set_manual_control_input(0.0, 0.0, 0.5, 0.0)
            await asyncio.sleep(0.02)

    await v.manual.set_manual_control_input(0.0, 0.0, 0.5, 0.0)
    feeding = asyncio.ensure_future(feed())
    async with asyncio.timeout(HANGS_S):
        while True:  # the last sticks may be too old at the moment
            with contextlib.suppress(ManualControlError):
                await v.manual.start_position_control()
                break
    ends = True
    await feeding
    await v.wait_mode(FlightMode.RETURN_TO_LAUNCH)  # their silence is a loss
    await v.wait_armed(False)


STEPS = (
    tells_who_it_is,
    becomes_healthy,
    tells_how_it_does,
    keeps_to_a_rate,
    lists_reads_and_sets_parameters,
    keeps_a_mission,
    keeps_fences_and_rally_points,
    describes_its_parameters,
    hands_out_files_and_lists_logs,
    flies_by_commands,
    flies_a_mission,
    flies_by_setpoints,
    flies_by_sticks,
)


async def main(port: str) -> None:
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    await mavsdk.add_any_connection(f"udpin://127.0.0.1:{port}")
    system = await mavsdk.first_autopilot(timeout_s=HANGS_S)
    assert system is not None, "no vehicle"
    vehicle = Vehicle(system)
    for step in STEPS:
        print(f"{step.__name__} ...", flush=True)
        await step(vehicle)


if __name__ == "__main__":
    status = 0
    try:
        asyncio.run(main(sys.argv[1]))
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)  # MAVSDK's threads may outlive the loop
