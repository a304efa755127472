"""A ground station lists, reads and sets parameters; the vehicle flies by them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pymavlink import mavparm
from tests.flight.mavlink.vehicle import NAN, mavlink, met

if TYPE_CHECKING:
    from pathlib import Path

    from tests.flight.mavlink.vehicle import Station

TAKE_OFF = "MIS_TAKEOFF_ALT"


def read(station: Station, name: str) -> Any:
    station.link.mav.param_request_read_send(1, 1, name.encode(), -1)
    return station.wait("PARAM_VALUE", lambda value: value.param_id == name)


def bits_of(value: Any) -> bytes:
    """Of its value: as a float, some integers are not numbers, which keep no bits here."""
    bits: bytes = value.get_msgbuf()[10:14]
    return bits


def hash_of(values: list[Any]) -> int:
    """As PX4 and its ground stations compute it: CRC-32 without the inversions, of ids and bits."""
    crc = 0
    for value in values:
        for byte in value.param_id.encode() + bits_of(value):
            crc ^= byte
            for _ in range(8):
                crc = (crc >> 1) ^ (0xEDB88320 if crc & 1 else 0)
    return crc


def test_parameters(tmp_path: Path) -> None:
    with met(tmp_path / "params.ulg") as (station, facts):
        begin_ms = station.wait("ATTITUDE").time_boot_ms
        station.link.param_fetch_all()
        values: dict[int, Any] = {}
        while not values or len(values) < next(iter(values.values())).param_count:
            value = station.wait("PARAM_VALUE")
            values[value.param_index] = value
        assert station.wait("ATTITUDE").time_boot_ms - begin_ms < 10_000
        assert sorted(values) == list(range(len(values)))
        ids = [values[i].param_id for i in range(len(values))]
        assert ids == sorted(ids)
        assert len(ids) > 100
        assert all(len(name) <= 16 for name in ids)
        by_index = [values[i] for i in range(len(values))]

        seen = read(station, "_HASH_CHECK")
        assert seen.param_index == 65535
        assert int.from_bytes(bits_of(seen), "little") == hash_of(by_index)

        station.link.mav.param_request_read_send(1, 1, b"NO_SUCH_PARAM", -1)
        refused = station.wait("PARAM_ERROR")
        assert refused.error == mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST

        setter = mavparm.MAVParmDict()
        assert setter.mavset(station.link, TAKE_OFF, 9.0, parm_type=9)
        assert read(station, TAKE_OFF).param_value == 9.0
        station.link.mav.param_set_send(1, 1, TAKE_OFF.encode(), 1e9, 9)
        refused = station.wait("PARAM_ERROR")
        assert refused.error == mavlink.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE

        station.accept(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        station.accept(mavlink.MAV_CMD_NAV_TAKEOFF, NAN, 0, 0, NAN, NAN, NAN, NAN)
        station.wait("GLOBAL_POSITION_INT", lambda p: p.relative_alt > 8500)
        station.accept(mavlink.MAV_CMD_NAV_LAND)
        station.wait_armed(False)
    assert facts["success"], facts["reason"]
